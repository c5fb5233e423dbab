"""What a tracker remembers between two frames."""

from dataclasses import dataclass

from tracker.box_filter import Gains
from tracker.existence import DetectorStatistics
from tracker.lifecycle import NO_TRACKS, ActiveTracks


@dataclass(frozen=True)
class TrackerStatistics:
    """What a tracker did since its reset, for the summary of a run.

    frames: steps taken. pairs: of a predicted track and a detection. compared: those inside the
    gate, the only ones whose costs were computed. unmeasured: costs that were NaN.
    """

    frames: int = 0
    pairs: int = 0
    compared: int = 0
    unmeasured: int = 0

    def after_frame(self, pairs: int, compared: int, unmeasured: int) -> "TrackerStatistics":
        """The counts after another frame with these."""
        return TrackerStatistics(
            self.frames + 1,
            self.pairs + pairs,
            self.compared + compared,
            self.unmeasured + unmeasured,
        )

    @property
    def skipped_share(self) -> float:
        """The share of pairs that the gate spared."""
        return 1.0 - self.compared / self.pairs if self.pairs else 0.0


@dataclass(frozen=True, eq=False)
class TrackerState:
    """Everything that a tracker remembers; never modified, so keeping it is a copy.

    Its arrays cannot be written to. tracks: as after the last frame, at the `time` of it,
    seconds. detector: what was learned of the detector's misses and clutter. gains: of the noise
    of its boxes.
    """

    tracks: ActiveTracks = NO_TRACKS
    next_id: int = 0
    time: float | None = None
    statistics: TrackerStatistics = TrackerStatistics()
    detector: DetectorStatistics = DetectorStatistics()
    gains: Gains | None = None
