"""Drives to diagnose: of a scene, of a stress suite, of KITTI; each is tracked and searched."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from hashlib import sha256
from pathlib import Path
from typing import Protocol, runtime_checkable

from mot_sim.datasets import KittiSequence
from mot_sim.datasets.images import ImageFolder, ImageSource
from mot_sim.diagnosis.attribution import Attributor, Replays
from mot_sim.diagnosis.diagnosed_sequence import DiagnosedSequence, diagnosed_kitti, diagnosed_scene
from mot_sim.diagnosis.findings import Findings, findings_of
from mot_sim.diagnosis.sources import SourceAblation
from mot_sim.experiments.stress.suites import find_suites, read_suites
from mot_sim.experiments.sweep.conditions import Conditions
from mot_sim.experiments.sweep.drives import Recordings
from mot_sim.experiments.sweep.paths import Level
from mot_sim.experiments.sweep.tracker_specs import TrackerSpec
from mot_sim.files.fingerprint import DIGEST_LETTERS, code_digest, digest
from mot_sim.simulation.episodes.extra import Extra
from mot_sim.simulation.registry import scene_maker
from mot_sim.simulation.truth import labels
from tracker.errors import BadConfig, DatasetNotFound
from tracker.types import Tracks


@runtime_checkable
class Task(Protocol):
    """A drive, and the tracker that is diagnosed on it."""

    @property
    def name(self) -> str:
        """Of the drive."""
        ...

    @property
    def key(self) -> str:
        """A hash of everything that decides the findings."""
        ...

    def run(self) -> Findings:
        """The findings."""
        ...

    def track(self) -> tuple[DiagnosedSequence, Tracks]:
        """The drive, and the tracker's output."""
        ...


@dataclass(frozen=True)
class SceneTask:
    """One run of a scene to be diagnosed."""

    conditions: Conditions
    """What the tracker is given: scene, camera, detector, motion."""
    seed: int
    """The seed of the run, 0 or more."""
    tracker_spec: TrackerSpec
    """The tracker."""
    recordings: Path
    """Folder of recorded traffic and truth."""
    attribute: bool = False
    """Whether the causes of switches are sought too, by tracking the drive again many times."""

    @property
    def name(self) -> str:
        """Scene and seed."""
        return f"{self.conditions.scene}/{self.seed}"

    @property
    def key(self) -> str:
        """A hash of everything that decides the findings."""
        about = [self.conditions.description(), self.seed, self.tracker_spec.description()]
        return digest([_code(), "scene", *about, self.attribute])

    @property
    def recorded(self) -> Extra:
        """Traffic, vehicles and truth; recorded when it is first needed."""
        return Recordings(self.recordings).truth(self.conditions, self.seed)

    def track(self) -> tuple[DiagnosedSequence, Tracks]:
        """The drive, and the tracker's output."""
        diagnosed = diagnosed_scene(self.conditions, self.recorded, self.seed)
        return diagnosed, _output(self.tracker_spec, diagnosed)

    def run(self) -> Findings:
        """The findings; with `attribute` the drive is tracked again for every source and switch."""
        diagnosed, output = self.track()
        if not self.attribute:
            return findings_of(diagnosed, output)
        recorded = self.recorded
        ablation = SourceAblation.of(self.conditions, recorded, self.seed)
        every = labels(recorded.annotations.truth)
        attributor = Attributor(ablation, every, Replays(self.tracker_spec))
        return findings_of(diagnosed, output, attributor.attribute)


@dataclass(frozen=True)
class KittiTask:
    """A labelled KITTI sequence to be diagnosed; its real detector's noise is not attributed."""

    drive: KittiSequence
    """The sequence with its labels, without images."""
    tracker_spec: TrackerSpec
    """The tracker."""
    pictures: ImageSource | None = None
    """Its images, for the contact sheet; the tracker does not get them. None: there are none."""

    @property
    def name(self) -> str:
        """Of the sequence."""
        return self.drive.name

    @property
    def key(self) -> str:
        """A hash of everything that decides the findings."""
        drive = self.drive
        about = [
            drive.name,
            drive.camera,
            drive.log,
            drive.frame_indices,
            drive.Ts_world_cam,
            drive.motion_cov,
            drive.frame_rate,
            drive.truth,
            self.tracker_spec.description(),
        ]
        return digest([_code(), "kitti", *about])

    def track(self) -> tuple[DiagnosedSequence, Tracks]:
        """The drive, and the tracker's output."""
        diagnosed = diagnosed_kitti(self.drive)
        return diagnosed, _output(self.tracker_spec, diagnosed)

    def run(self) -> Findings:
        """The findings."""
        return findings_of(*self.track())


def _output(tracker_spec: TrackerSpec, diagnosed: DiagnosedSequence) -> Tracks:
    """All rows of the tracker."""
    return Replays(tracker_spec).run(diagnosed.stream, diagnosed.stream.frame_count)


@lru_cache(maxsize=1)
def _code() -> str:
    """A hash of the code that decides findings, this package included."""
    total = sha256()
    for path in sorted(Path(__file__).parent.glob("*.py")):
        total.update(path.name.encode() + path.read_bytes())
    return code_digest() + total.hexdigest()[:DIGEST_LETTERS]


def scene_tasks(
    scene: str,
    settings: Mapping[str, Level],
    seeds: Sequence[int],
    tracker_spec: TrackerSpec,
    attribute: bool = False,
) -> Iterator[SceneTask]:
    """Runs of a scene. Their truths are kept in the cache that `mot_sim.testing` uses.

    Raises UnknownName and BadConfig for what cannot be run.
    """
    scene_maker(scene)
    if not len(seeds):
        raise BadConfig("--seeds 0: give 1 or more")
    if min(seeds) < 0:
        raise BadConfig(f"--first-seed {min(seeds)}: give 0 or more")
    conditions = Conditions.of(scene, settings)
    recordings = Recordings.shared().folder
    for seed in seeds:
        yield SceneTask(conditions, seed, tracker_spec, recordings, attribute)


def suite_tasks(
    suite: str,
    settings: Mapping[str, Level],
    seeds: Sequence[int],
    tracker_spec: TrackerSpec,
    attribute: bool = False,
) -> Iterator[SceneTask]:
    """Runs of a stress suite; settings: changes to it. Raises as `scene_tasks`."""
    (found,) = find_suites([suite], read_suites())
    whole = {"scene.frames": found.frames, **found.settings, **settings}
    return scene_tasks(found.scene, whole, seeds, tracker_spec, attribute)


def kitti_tasks(drives: Sequence[KittiSequence], tracker_spec: TrackerSpec) -> Iterator[KittiTask]:
    """Sequences of a KITTI tree, of cars; all must have labels. Raises DatasetNotFound."""
    for drive in drives:
        drive.require_cars()
        if drive.label_path is None or drive.truth is None:
            raise DatasetNotFound(
                f"sequence {drive.name}: no labels (label_02/{drive.name}.txt); choose others: "
                "--sequences labelled takes those that have some"
            )
        yield KittiTask(replace(drive, images=None), tracker_spec, _images(drive))


def _images(drive: KittiSequence) -> ImageSource | None:
    """The images of a drive, if the tree has any."""
    if drive.label_path is None:
        return None
    return ImageFolder.find(drive.label_path.parents[1] / "image_02" / drive.name)
