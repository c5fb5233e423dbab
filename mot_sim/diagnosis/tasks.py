"""One drive to diagnose, of a scene or of KITTI: what decides its findings, and finding them."""

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
from mot_sim.experiments.sweep.seeded_episodes import default_cache
from mot_sim.experiments.sweep.tracker_specs import TrackerSpec
from mot_sim.files.fingerprint import LETTERS, code_digest, digest
from mot_sim.simulation.episodes.extra import Extra
from mot_sim.simulation.scene_names import SCENES
from mot_sim.simulation.truth import labels
from tracker.errors import BadConfig, DatasetNotFound, UnknownName
from tracker.types import Tracks


@runtime_checkable
class Task(Protocol):
    """A drive, and the tracker that is looked at."""

    @property
    def name(self) -> str:
        """Of the drive."""
        ...

    @property
    def key(self) -> str:
        """A hash of all that decides the findings."""
        ...

    def run(self) -> Findings:
        """What is found."""
        ...

    def look(self) -> tuple[DiagnosedSequence, Tracks]:
        """The drive, and what the tracker makes of it."""
        ...


@dataclass(frozen=True)
class SceneTask:
    """A seed of a scene. recordings: where truths lie. attribute: say what switches hang on."""

    conditions: Conditions
    seed: int
    contender: TrackerSpec
    recordings: Path
    attribute: bool = False

    @property
    def name(self) -> str:
        """Scene and seed."""
        return f"{self.conditions.scene}/{self.seed}"

    @property
    def key(self) -> str:
        """A hash of all that decides the findings."""
        about = [self.conditions.description(), self.seed, self.contender.description()]
        return digest([_code(), "scene", *about, self.attribute])

    @property
    def recorded(self) -> Extra:
        """Traffic, cast and truth; made when it is first asked for."""
        return Recordings(self.recordings).truth(self.conditions, self.seed)

    def look(self) -> tuple[DiagnosedSequence, Tracks]:
        """The drive, and what the tracker makes of it."""
        watched = diagnosed_scene(self.conditions, self.recorded, self.seed)
        return watched, _output(self.contender, watched)

    def run(self) -> Findings:
        """What is found; with `attribute` the drive is run again for every source and switch."""
        watched, output = self.look()
        if not self.attribute:
            return findings_of(watched, output)
        recorded = self.recorded
        bench = SourceAblation.of(self.conditions, recorded, self.seed)
        every = labels(recorded.annotations.truth)
        court = Attributor(bench, every, Replays(self.contender))
        return findings_of(watched, output, court.attribute)


@dataclass(frozen=True)
class KittiTask:
    """A labelled sequence. What a real detector did cannot be undone: nothing is attributed.

    pictures: its images, for those who want to look; no tracker gets them.
    """

    drive: KittiSequence
    contender: TrackerSpec
    pictures: ImageSource | None = None

    @property
    def name(self) -> str:
        """Of the sequence."""
        return self.drive.name

    @property
    def key(self) -> str:
        """A hash of all that decides the findings."""
        drive = self.drive
        about = [
            drive.name, drive.camera, drive.log, drive.frame_indices, drive.Ts_world_cam,
            drive.motion_cov, drive.frame_rate, drive.truth, self.contender.description(),
        ]  # fmt: skip
        return digest([_code(), "kitti", *about])

    def look(self) -> tuple[DiagnosedSequence, Tracks]:
        """The drive, and what the tracker makes of it."""
        watched = diagnosed_kitti(self.drive)
        return watched, _output(self.contender, watched)

    def run(self) -> Findings:
        """What is found."""
        return findings_of(*self.look())


def _output(contender: TrackerSpec, watched: DiagnosedSequence) -> Tracks:
    """All rows of the tracker."""
    return Replays(contender).run(watched.stream, watched.stream.frame_count)


@lru_cache(maxsize=1)
def _code() -> str:
    """Of the code that decides findings, this package's too."""
    total = sha256()
    for path in sorted(Path(__file__).parent.glob("*.py")):
        total.update(path.name.encode() + path.read_bytes())
    return code_digest() + total.hexdigest()[:LETTERS]


def scene_tasks(
    scene: str,
    settings: Mapping[str, Level],
    seeds: Sequence[int],
    contender: TrackerSpec,
    attribute: bool = False,
) -> Iterator[SceneTask]:
    """Runs of a scene. Their truths are kept where `mot_sim.testing` keeps its own.

    Raises UnknownName and BadConfig for what cannot be run.
    """
    if scene not in SCENES:
        raise UnknownName.of("scene", scene, SCENES)
    if not len(seeds):
        raise BadConfig("--seeds 0: give 1 or more")
    if min(seeds) < 0:
        raise BadConfig(f"--first-seed {min(seeds)}: give 0 or more")
    conditions = Conditions.of(scene, settings)
    recordings = default_cache() / code_digest()[:16]
    for seed in seeds:
        yield SceneTask(conditions, seed, contender, recordings, attribute)


def suite_tasks(
    suite: str,
    settings: Mapping[str, Level],
    seeds: Sequence[int],
    contender: TrackerSpec,
    attribute: bool = False,
) -> Iterator[SceneTask]:
    """Runs of a stress suite; settings: what is changed in it. Raises as `scene_tasks`."""
    (found,) = find_suites([suite], read_suites())
    whole = {"scene.frames": found.frames, **found.settings, **settings}
    return scene_tasks(found.scene, whole, seeds, contender, attribute)


def kitti_tasks(drives: Sequence[KittiSequence], contender: TrackerSpec) -> Iterator[KittiTask]:
    """Sequences of a KITTI tree; all must have labels. Raises DatasetNotFound."""
    for drive in drives:
        if drive.label_path is None or drive.truth is None:
            raise DatasetNotFound(
                f"sequence {drive.name}: no labels (label_02/{drive.name}.txt); choose others: "
                "--sequences labelled takes those that have some"
            )
        yield KittiTask(replace(drive, images=None), contender, _images(drive))


def _images(drive: KittiSequence) -> ImageSource | None:
    """The images that the tree has of a drive."""
    if drive.label_path is None:
        return None
    return ImageFolder.find(drive.label_path.parents[1] / "image_02" / drive.name)
