"""What a tracker remembers between two frames."""

from dataclasses import dataclass
from typing import NamedTuple

from jaxtyping import Float
from numpy import ndarray as Array

from tracker.box_filter import Gains
from tracker.car_filter import RoadMemory
from tracker.ego_motion import NO_MOTION, CameraMotion
from tracker.errors import BadConfig
from tracker.existence import DetectorStatistics
from tracker.lifecycle import NO_TRACKS, ActiveTracks
from tracker.motion_check import MotionCheck
from tracker.score_scale import ScoreMemory
from tracker.types import CarEstimates, Frame


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


class Clock(NamedTuple):
    """Where a tracker is in time: at which frame, and since when it has predicted."""

    time: float | None = None
    """Of the last frame, s; None: no frame yet."""
    looked_at: float | None = None
    """Of the last frame that a detector looked at, s; None: no such frame yet."""
    motion: CameraMotion | None = None
    """Of the camera from that frame to the last one; None: they are the same."""

    def since_look(self, frame: Frame) -> tuple[CameraMotion, float]:
        """The camera's motion from the last frame that was looked at to this one; the seconds.

        0 seconds where there was none. BadConfig when time goes backwards.
        """
        if self.time is None:
            return NO_MOTION, 0.0
        motion = CameraMotion.of(frame, self._elapsed(frame, self.time)).after(self.motion)
        return motion, self.seconds_since_look(frame)

    def T_since_look(self, frame: Frame) -> Float[Array, "4 4"] | None:
        """The camera's motion as `since_look` has it, where it was given over all frames."""
        if self.motion is None:
            return frame.T_now_before
        motion, _ = self.since_look(frame)
        return motion.T_now_before if motion.is_known else None

    def seconds_since_look(self, frame: Frame) -> float:
        """From the last frame that was looked at to this one; 0 where there was none."""
        return 0.0 if self.looked_at is None else frame.time - self.looked_at

    def after(self, frame: Frame) -> "Clock":
        """The same after this frame."""
        if frame.looked_at:
            return Clock(frame.time, frame.time)
        return Clock(frame.time, self.looked_at, self.since_look(frame)[0])

    def _elapsed(self, frame: Frame, before: float) -> float:
        """Seconds since the last frame."""
        if not frame.time >= before:
            raise BadConfig(
                f"frame {frame.index} at {frame.time:g} s comes after one at {before:g} s: "
                "frames go forward in time; call reset() between sequences"
            )
        return frame.time - before


@dataclass(frozen=True, eq=False)
class TrackerState:
    """Everything that a tracker remembers; never modified, so keeping it is a copy."""

    tracks: ActiveTracks = NO_TRACKS
    """The tracks that have not ended, in the road frame of the last frame."""
    next_id: int = 0
    """The id of the next track that begins; ids are never used twice."""
    clock: Clock = Clock()
    """Where the tracker is in time."""
    statistics: TrackerStatistics = TrackerStatistics()
    """What was done since the reset."""
    detector: DetectorStatistics = DetectorStatistics()
    """What `ExistenceFilter` learned of the detector's misses and clutter."""
    gains: Gains | None = None
    """What `BoxFilter` learned of the noise of the detector's boxes; None: nothing yet."""
    scores: ScoreMemory = ScoreMemory()
    """What `ScoreScale` learned of the detector's scores."""
    motion_check: MotionCheck = MotionCheck()
    """What the boxes told of the motion and the calibration that are given."""
    road: RoadMemory = RoadMemory()
    """What `CarFilter` learned of the road and its traffic."""
    estimates: CarEstimates | None = None
    """The likeliest states of the cars of `tracks`; None without a `CarFilter`."""
