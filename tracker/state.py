"""What a tracker remembers between two frames."""

from dataclasses import dataclass

from tracker.box_filter import Gains
from tracker.existence import DetectorStatistics
from tracker.lifecycle import NO_TRACKS, ActiveTracks
from tracker.score_scale import ScoreMemory


@dataclass(frozen=True)
class TrackerStatistics:
    """What a tracker did since its reset, for the summary of a run."""

    frames: int = 0
    """Steps taken."""
    pairs: int = 0
    """Pairs of a predicted track and a detection, inside the gate or not."""
    compared: int = 0
    """Pairs inside the gate, the only ones whose costs were computed."""
    unmeasured: int = 0
    """Costs of single cues that were NaN: a detection or a track lacked the cue."""

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
    """Everything that a tracker remembers; never modified, so keeping it is a copy."""

    tracks: ActiveTracks = NO_TRACKS
    """The tracks that have not ended, in the road frame of the last frame."""
    next_id: int = 0
    """The id of the next track that begins; ids are never used twice."""
    time: float | None = None
    """Time of the last frame, s; None: no frame yet."""
    statistics: TrackerStatistics = TrackerStatistics()
    """What was done since the reset."""
    detector: DetectorStatistics = DetectorStatistics()
    """What `ExistenceFilter` learned of the detector's misses and clutter."""
    gains: Gains | None = None
    """What `BoxFilter` learned of the noise of the detector's boxes; None: nothing yet."""
    scores: ScoreMemory = ScoreMemory()
    """What `ScoreScale` learned of the detector's scores."""
