"""What a tracker makes of frames before it looks at any track: it depends on no decision."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Bool, Float, Int
from numpy import ndarray as Array

from tracker.beliefs import NO_BELIEFS, Beliefs
from tracker.car_filter import CarFilter
from tracker.car_filter.road_memory import FORGETTING_TURN
from tracker.ego_motion import NO_COV, RoadMotion
from tracker.errors import BadConfig
from tracker.score_scale import ScoreMemory
from tracker.state import Clock
from tracker.tracker import Tracker
from tracker.types import Detections, Frame
from tracker.types.rows import Rows

MotionRow = tuple[Any, ...]
UNKNOWN_COV = np.full((2, 2), np.nan)


@dataclass(frozen=True, eq=False)
class FrameMotions(Rows):
    """The motion of the camera since the frame before, one row per frame, and what follows."""

    dt: Float[Array, " f"]
    """Seconds since the frame before; 0 at the first one."""
    is_given: Bool[Array, " f"]
    """Whether a motion was given."""
    is_uncertain: Bool[Array, " f"]
    """Whether the tracker corrects its rotation by the boxes."""
    T_now_before: Float[Array, "f 4 4"]
    """As in `Frame`; standing still where none was given."""
    covariance: Float[Array, "f 6 6"]
    """Of that motion."""
    T_road: Float[Array, "f 4 4"]
    """Of `RoadMotion`, as the next four."""
    turn: Float[Array, " f"]
    """Yaw of that, rad."""
    H: Float[Array, "f 3 3"]
    """Moves pixels of what is infinitely far."""
    shift: Float[Array, "f 3"]
    """How homogeneous pixels move at depth 1 m."""
    by_moved: Float[Array, "f 3 2"]
    """How they do where the object goes a metre."""
    survival: Float[Array, " f"]
    """Probability that a car is still there."""
    kept: Float[Array, "f 3"]
    """What is kept of the road's flatness, slope and traffic."""
    squared: Float[Array, " f"]
    """Square of the second of those."""
    rise: Float[Array, " f"]
    """How much the road seems to rise by the camera's motion, rad."""
    velocity_cov: Float[Array, "f 2 2"]
    """Covariance of the camera's velocity along road x and z; NaN: as before."""

    @classmethod
    def of(cls, rows: Sequence[MotionRow]) -> "FrameMotions":
        """The table of one or more rows."""
        return cls(*(np.array(column) for column in zip(*rows, strict=True)))


def motion_row(
    tracker: Tracker, T: Array, covariance: Array, dt: float, is_given: bool
) -> MotionRow:
    """What a row of `FrameMotions` holds, in their order."""
    camera, turns = tracker.camera, tracker.camera_rotation_filter
    road = RoadMotion.of(T, camera)
    uncertain = turns is not None and is_given and turns.is_uncertain(covariance, camera)
    survival = 1.0 if tracker.existence is None else tracker.existence.survival(dt)
    kept, squared, rise = road_terms(tracker.car_filter, road, dt)
    velocity_cov = UNKNOWN_COV
    if dt > 0.0:
        R = camera.T_road_cam[:3:2, :3] / dt
        velocity_cov = R @ covariance[:3, :3] @ R.T
    told = dt, is_given, uncertain, T, covariance
    return *told, *road, survival, kept, squared, rise, velocity_cov


def road_terms(
    cars: CarFilter | None, road: RoadMotion, dt: float
) -> tuple[tuple[float, float, float], float, float]:
    """The columns `kept`, `squared` and `rise` of a frame; see `CarFilter.predict`."""
    if cars is None:
        return (1.0, 1.0, 1.0), 1.0, 0.0
    slope = math.exp(-dt / cars.road.slope_time)
    traffic = math.exp(-dt / cars.directions.memory_time - abs(road.turn) / FORGETTING_TURN)
    kept = math.exp(-dt / cars.roughness.memory_time), slope, traffic
    return kept, slope**2, math.atan2(road.T_road[1, 2], road.T_road[2, 2])


@dataclass(frozen=True, eq=False)
class PreparedFrames:
    """Frames of a drive, or of several one after another, ready for a `BatchTracker`.

    The first row of `motions` is a frame that stands for none: nothing is seen, no time passes.
    """

    starts: Int[Array, " _"]
    """Where the detections of each frame begin, and where the last ones end."""
    detections: Detections
    """What is left of them after suppression, with probabilities for scores."""
    observed: Beliefs
    """The same, lifted to the road."""
    motions: FrameMotions
    """One row per frame."""

    def __len__(self) -> int:
        return len(self.motions)

    def after(self, before: "PreparedFrames") -> "PreparedFrames":
        """The frames of both as one table, these ones last."""
        starts = np.concatenate((before.starts, before.starts[-1] + self.starts[2:]))
        one = np.arange(1, len(self))
        return PreparedFrames(
            starts,
            Detections.concatenate((before.detections, self.detections)),
            Beliefs.concatenate((before.observed, self.observed)),
            FrameMotions.concatenate((before.motions, self.motions.select(one))),
        )


def decisive_parts(tracker: Tracker) -> tuple[object, ...]:
    """What decides beside the frames what `prepare_frames` gives: the camera, then components."""
    of_boxes = tracker.score_scale, tracker.suppress, tracker.lift
    of_motions = tracker.camera_rotation_filter, tracker.existence, tracker.car_filter
    return (tracker.camera, *of_boxes, *of_motions)


def prepare_frames(tracker: Tracker, frames: Sequence[Frame], name: str) -> PreparedFrames:
    """The frames of one drive, from its beginning, as this tracker takes them.

    name: of the drive. Raises BadConfig for a frame that no detector looked at, and as
    `Tracker.cost_matrix` does.
    """
    memory, clock = ScoreMemory(), Clock()
    motions = [motion_row(tracker, np.eye(4), NO_COV, 0.0, False)]
    found, lifted = [Detections(np.zeros((0, 4)), np.zeros(0))], [NO_BELIEFS]
    for frame in frames:
        if not frame.looked_at:
            raise BadConfig(
                f"{name}: nothing looked at frame {frame.index}, and many drives at once are only "
                "tracked where a detector looks at every frame: take one tracker per drive"
            )
        given, memory = tracker.rescored(memory, frame)
        found.append(tracker.suppress(given, tracker.camera))
        lifted.append(tracker.lift(found[-1], tracker.camera))
        motion, dt = clock.since_look(frame)
        clock = clock.after(frame)
        known = motion.T_now_before, motion.covariance
        motions.append(motion_row(tracker, *known, dt, motion.is_known))
    counts = np.array([0, *(len(each) for each in found)])
    return PreparedFrames(
        np.cumsum(counts),
        Detections.concatenate(found),
        Beliefs.concatenate(lifted),
        FrameMotions.of(motions),
    )
