"""Who can be compared: our trackers, the two-frame baselines and the guests, over whole drives."""

import tempfile
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from time import process_time
from typing import Protocol, runtime_checkable

from mot_sim.datasets.recorded import RecordedSequence
from mot_sim.experiments.guests.exchange import read_guest_results, read_seconds, write_detections
from mot_sim.experiments.guests.failure import ExternalTrackerFailed
from mot_sim.experiments.guests.processes import run_process
from mot_sim.experiments.guests.register import GUESTS, ExternalTracker
from mot_sim.files.settings import require_empty
from tracker import TRACKERS, Camera, Tracker, Tracks
from tracker.association import Greedy, Hungarian
from tracker.costs import ImageOverlap
from tracker.dynamics import ConstantPosition
from tracker.errors import BadConfig, TrackingError, UnknownName
from tracker.lifecycle import Lifecycle
from tracker.suppression import Suppression

# Least score and IoU of the two-frame baselines.
BASELINE_SCORE, BASELINE_IOU = 0.3, 0.3


@dataclass(frozen=True, eq=False)
class TrackedSequences:
    """What a tracker made of some drives.

    tracks: by drive. seconds: CPU time of the tracker's calls alone, by drive; None: not told.
    min_score: boxes below it were not used.
    """

    tracks: Mapping[str, Tracks]
    seconds: Mapping[str, float] | None
    min_score: float


@runtime_checkable
class SequenceTracker(Protocol):
    """A tracker by name that is given whole drives; guests know no single steps."""

    @property
    def name(self) -> str:
        """How tables name it."""
        ...

    def track(self, drives: Sequence[RecordedSequence]) -> TrackedSequences:
        """The tracks of every drive; TrackingError when it cannot."""
        ...


@dataclass(frozen=True)
class OwnTracker:
    """A tracker of this process, made anew for every drive.

    uses_motion: whether it is told how the camera moved.
    """

    name: str
    build: Callable[[Camera], Tracker]
    uses_motion: bool = True

    def track(self, drives: Sequence[RecordedSequence]) -> TrackedSequences:
        """The tracks of every drive."""
        tracks, seconds, min_score = {}, {}, 0.0
        for drive in drives:
            tracker = self.build(drive.camera)
            min_score = tracker.suppress.min_score
            tracks[drive.name], seconds[drive.name] = self._track(tracker, drive)
        return TrackedSequences(tracks, seconds, min_score)

    def _track(self, tracker: Tracker, drive: RecordedSequence) -> tuple[Tracks, float]:
        """The tracks of one drive, and the CPU seconds of the steps."""
        parts, seconds = [Tracks.empty()], 0.0
        for frame in drive:
            if not self.uses_motion:
                frame = replace(frame, T_now_before=None, motion_cov=None)  # noqa: PLW2901
            start = process_time()
            rows = tracker.step(frame)
            seconds += process_time() - start
            parts.append(replace(rows, cuboids=None))
        return Tracks.concatenate(parts), seconds


@dataclass(frozen=True)
class ExternalSequenceTracker:
    """A guest as a tracker over whole drives: one run of its command for all of them.

    folder: where the exchanged files stay, new or empty; None: nowhere.
    """

    guest: ExternalTracker
    folder: Path | None = None

    @property
    def name(self) -> str:
        """The guest's."""
        return self.guest.name

    def track(self, drives: Sequence[RecordedSequence]) -> TrackedSequences:
        """The tracks of every drive.

        Raises ExternalTrackerFailed, with the guest's stderr, when it fails, takes too long or writes
        rubbish (file, line and value are named).
        """
        require_different_names(drives)
        with self._exchange() as folder:
            detections, results = folder / "detections", folder / "results"
            command = self.guest.words(detections, results)
            write_detections(drives, self.guest.min_score, detections)
            results.mkdir()
            said = run_process(self.name, command, self.guest.timeout)
            try:
                tracks = read_guest_results(drives, results)
                seconds = read_seconds(drives, results)
            except TrackingError as error:
                raise ExternalTrackerFailed(self.name, str(error), said) from None
        return TrackedSequences(tracks, seconds, self.guest.min_score)

    @contextmanager
    def _exchange(self) -> Iterator[Path]:
        """The folder for the files."""
        if self.folder is not None:
            require_empty(self.folder)
            yield self.folder
            return
        with tempfile.TemporaryDirectory(prefix="mot-sim-guest-") as folder:
            yield Path(folder)


def image_overlap_baseline(camera: Camera, greedy: bool = False) -> Tracker:
    """Box overlap of two frames and nothing else: no motion, no memory, no geometry.

    It is meant for frames without ego-motion; the boxes then stay where they are.
    """
    associate = Greedy if greedy else Hungarian
    return Tracker(
        camera,
        ((1.0, ImageOverlap()),),
        dynamics=ConstantPosition(),
        suppress=Suppression(min_score=BASELINE_SCORE, max_iou=1.0),
        associate=associate(1.0 - BASELINE_IOU),
        lifecycle=Lifecycle(birth_score=0.0, max_gap=0.0),
        tie_break=0.0,
    )


BASELINES: dict[str, Callable[[Camera], Tracker]] = {
    "iou": image_overlap_baseline,
    "iou-greedy": lambda camera: image_overlap_baseline(camera, greedy=True),
}


def find_sequence_tracker(
    name: str, guests: Mapping[str, ExternalTracker] = GUESTS, folder: Path | None = None
) -> SequenceTracker:
    """A tracker by name: of TRACKERS, of BASELINES, or a guest.

    folder: where a guest's files stay. Raises UnknownName with the nearest name.
    """
    if name in TRACKERS:
        return OwnTracker(name, TRACKERS[name])
    if name in BASELINES:
        return OwnTracker(name, BASELINES[name], uses_motion=False)
    if name in guests:
        return ExternalSequenceTracker(guests[name], folder)
    raise UnknownName.of("tracker", name, [*TRACKERS, *BASELINES, *guests])


def require_different_names(drives: Sequence[RecordedSequence]) -> None:
    """BadConfig when two drives have one name: their files would be one."""
    names = [drive.name for drive in drives]
    twice = sorted({name for name in names if names.count(name) > 1})
    if twice:
        raise BadConfig(f"two drives are named {twice[0]!r}: give each a name of its own")
