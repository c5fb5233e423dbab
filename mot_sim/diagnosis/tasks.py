"""One drive to diagnose, of a scene or of KITTI: what decides its findings, and finding them."""

from dataclasses import dataclass
from functools import lru_cache
from hashlib import sha256
from pathlib import Path
from typing import Protocol, runtime_checkable

from mot_sim.datasets import KittiSequence
from mot_sim.datasets.images import ImageSource
from mot_sim.diagnosis.attribution import Attributor
from mot_sim.diagnosis.diagnosed_sequence import DiagnosedSequence, diagnosed_kitti, diagnosed_scene
from mot_sim.diagnosis.findings import Findings, findings_of
from mot_sim.diagnosis.replay import Replays
from mot_sim.diagnosis.sources import SourceAblation
from mot_sim.experiments.sweep.conditions import Conditions
from mot_sim.experiments.sweep.drives import Recordings
from mot_sim.experiments.sweep.tracker_specs import TrackerSpec
from mot_sim.files.fingerprint import DIGEST_LETTERS, code_digest, digest
from mot_sim.simulation.episodes.extra import Extra
from mot_sim.simulation.truth import labels
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
    return code_digest() + total.hexdigest()[:DIGEST_LETTERS]


__all__ = ["KittiTask", "SceneTask", "Task"]
