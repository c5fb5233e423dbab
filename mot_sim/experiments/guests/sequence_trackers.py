"""Who can be compared: our trackers, the two-frame baselines and the guests, over whole drives."""

import tempfile
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from itertools import islice
from pathlib import Path
from time import process_time
from typing import Protocol, runtime_checkable

from mot_sim.datasets.recorded import RecordedSequence
from mot_sim.experiments.guests.exchange import read_guest_results, read_seconds, write_detections
from mot_sim.experiments.sweep.tracker_specs import TrackerSpec
from mot_sim.experiments.sweep.trial import require_rows
from mot_sim.files.named_objects import TRACKER_NAMES, BrokenCode
from mot_sim.files.settings import require_empty
from mot_sim.foreign.failure import ExternalTrackerFailed
from mot_sim.foreign.isolation import (
    DEFAULT_ISOLATION,
    IsolatedTracker,
    Isolation,
    TrackerStopped,
    close_tracker,
)
from mot_sim.foreign.processes import run_process
from mot_sim.foreign.protocol import Steps
from mot_sim.foreign.register import GUESTS, ExternalTracker
from tracker import Camera, Frame, Tracker, Tracks
from tracker.association import Greedy, Hungarian
from tracker.costs import ImageOverlap
from tracker.dynamics import ConstantPosition
from tracker.errors import BadConfig, TrackingError, UnknownName
from tracker.lifecycle import Lifecycle
from tracker.per_class import for_kind
from tracker.suppression import Suppression

# Least score and IoU of the two-frame baselines.
BASELINE_SCORE, BASELINE_IOU = 0.3, 0.3
# Frames before the clock runs: kernels are loaded in them, which else the first tracker would pay.
UNTIMED_FRAMES = 40


@dataclass(frozen=True, eq=False)
class TrackedSequences:
    """What a tracker made of several drives."""

    tracks: Mapping[str, Tracks]
    """The tracks of each drive, by the drive's name."""
    seconds: Mapping[str, float] | None
    """CPU seconds of the tracker's calls alone, by the drive's name; None: not reported."""
    min_score: float
    """Detector score, 0..1, below which boxes were not used."""


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
    """A tracker that runs in this process, made anew for every drive."""

    name: str
    """Its name in tables."""
    build: Callable[[Camera, float], Steps]
    """Makes a fresh tracker for a camera and a frame rate, Hz."""
    uses_motion: bool = True
    """Whether its frames hold the camera's motion; False removes it from every frame."""

    def track(self, drives: Sequence[RecordedSequence]) -> TrackedSequences:
        """The tracks of every drive. Raises TrackingError for whatever the tracker raises."""
        tracks: dict[str, Tracks] = {}
        seconds: dict[str, float] = {}
        min_score = 0.0
        for drive in drives:
            tracker = self._built(drive)
            if isinstance(tracker, Tracker):
                tracker = for_kind(tracker, drive.kinds[0])
            min_score = getattr(getattr(tracker, "suppress", None), "min_score", 0.0)
            try:
                if not tracks and type(tracker) is Tracker:
                    for frame in islice(self._frames(drive), UNTIMED_FRAMES):
                        tracker.step(frame)
                    tracker.reset()
                tracks[drive.name], seconds[drive.name] = self._track(tracker, drive)
            except TrackerStopped as stopped:
                raise self._failed(drive, str(stopped), stopped.said) from None
            except TrackingError:
                raise
            except (Exception, SystemExit) as error:  # noqa: BLE001
                words = " ".join(f"{type(error).__name__}: {error}".split())
                raise self._failed(drive, words) from None
            finally:
                close_tracker(tracker)
        return TrackedSequences(tracks, seconds, min_score)

    def _frames(self, drive: RecordedSequence) -> Iterator[Frame]:
        """Those of a drive, with what this tracker may see."""
        for frame in drive:
            yield frame if self.uses_motion else replace(frame, T_now_before=None, motion_cov=None)

    def _built(self, drive: RecordedSequence) -> Steps:
        """A fresh tracker for a drive."""
        try:
            return self.build(drive.camera, drive.frame_rate)
        except (BrokenCode, TrackerStopped) as error:
            raise self._failed(drive, str(error), getattr(error, "said", "")) from None

    def _failed(self, drive: RecordedSequence, words: str, said: str = "") -> ExternalTrackerFailed:
        return ExternalTrackerFailed(self.name, f"failed on {drive.name}: {words}", said, "tracker")

    def _track(self, tracker: Steps, drive: RecordedSequence) -> tuple[Tracks, float]:
        """The tracks of one drive, and the CPU seconds of the calls."""
        finish = getattr(tracker, "finish", None)
        came: list[int] = []
        parts, seconds = [Tracks.empty()], 0.0
        elsewhere = getattr(tracker, "cpu_seconds", None)  # of a process of its own
        for frame in self._frames(drive):
            start = process_time()
            parts.append(tracker.step(frame))
            seconds += process_time() - start
            came.append(frame.index)
            require_rows(parts[-1], came if finish else came[-1:])
        if finish:
            start = process_time()
            parts.append(finish())
            seconds += process_time() - start
            require_rows(parts[-1], came)
        if isinstance(tracker, IsolatedTracker):
            seconds = tracker.cpu_seconds - (elsewhere or 0.0)
        return Tracks.concatenate([replace(rows, cuboids=None) for rows in parts]), seconds


@dataclass(frozen=True)
class ExternalSequenceTracker:
    """A guest as a tracker over whole drives: its command runs once for all of them."""

    guest: ExternalTracker
    """The program and its settings."""
    folder: Path | None = None
    """Folder where the exchanged files stay, new or empty; None: a temporary one."""

    @property
    def name(self) -> str:
        """The guest's."""
        return self.guest.name

    def track(self, drives: Sequence[RecordedSequence]) -> TrackedSequences:
        """The tracks of every drive.

        Raises ExternalTrackerFailed, with the guest's stderr, when it fails, takes too long or
        writes rubbish (file, line and value are named).
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
    name: str,
    guests: Mapping[str, ExternalTracker] = GUESTS,
    folder: Path | None = None,
    isolation: Isolation = DEFAULT_ISOLATION,
) -> SequenceTracker:
    """A tracker by name: of BASELINES, a guest, or as `mot-sim sweep --trackers` takes it.

    folder: where a guest's files stay. isolation: of one that is none of ours. Raises UnknownName
    with the nearest name, BadConfig for a tracker of yours that cannot be built.
    """
    if name in BASELINES:
        make = BASELINES[name]
        return OwnTracker(name, lambda camera, _: make(camera), uses_motion=False)
    if name in guests:
        return ExternalSequenceTracker(guests[name], folder)
    spec = replace(TrackerSpec.parse(name), isolation=isolation)
    if ":" not in spec.made_by and spec.made_by not in {*TRACKER_NAMES.names(), *guests}:
        raise UnknownName.of("tracker", name, [*TRACKER_NAMES.names(), *BASELINES, *guests])
    spec.check()
    return OwnTracker(spec.name, spec.start)


def require_different_names(drives: Sequence[RecordedSequence]) -> None:
    """BadConfig when two drives have one name: their files would be one."""
    names = [drive.name for drive in drives]
    twice = sorted({name for name in names if names.count(name) > 1})
    if twice:
        raise BadConfig(f"two drives are named {twice[0]!r}: give each a name of its own")
