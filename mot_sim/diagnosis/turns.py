"""When the camera turns, and when cars do: from headings in the world."""

from collections.abc import Iterator

import numpy as np
from jaxtyping import Float, Int
from numpy import ndarray as Array

from mot_sim.diagnosis.context_events import NO_PARTNER, EventRow
from mot_sim.diagnosis.runs_of_frames import by_id, runs_of_frames
from tracker.geometry import invert
from tracker.types import Tracks

RATE_HALF_WINDOW_FRAMES = 3  # frames before and after, over which a rate is measured: labels jitter
MIN_TURN_RATE = (
    0.1  # radians a second; KITTI's road bends stay below, a junction is taken with .3 and more
)
MIN_TURN_ANGLE = 0.2  # radians: a turn turns so far at least
MAX_TURN_GAP_FRAMES = 5  # frames below the rate that do not end a turn


def headings_of(Ts_world_cam: Float[Array, "m 4 4"]) -> Float[Array, " m"]:
    """How far the camera has turned right since the first frame, radians."""
    if not len(Ts_world_cam):
        return np.zeros(0)
    ahead = (invert(Ts_world_cam[:-1]) @ Ts_world_cam[1:])[:, :3, 2]
    return np.concatenate(([0.0], np.cumsum(np.arctan2(ahead[:, 0], ahead[:, 2]))))


def camera_turns(
    cars: Tracks, headings: Float[Array, " m"], frame_rate: float
) -> Iterator[EventRow]:
    """Turns of the camera, a row for each car that is in the image meanwhile."""
    every = np.arange(len(headings))
    for first, last in _turns(every, headings, frame_rate):
        here = (cars.frames >= first) & (cars.frames <= last)
        for car, rows in by_id(cars.ids[here]):
            frames = cars.frames[here][rows]
            yield "camera turns", int(frames[0]), int(frames[-1]), car, NO_PARTNER, np.nan


def car_turns(cars: Tracks, headings: Float[Array, " m"], frame_rate: float) -> Iterator[EventRow]:
    """Turns of cars in the world; cars need cuboids, rows without one are passed over."""
    if cars.cuboids is None:
        return
    known = cars.select(np.isfinite(cars.cuboids.yaw))
    assert known.cuboids is not None
    # The road frame turns with the camera: yaw = heading of the car - heading of the camera - pi/2.
    yaw = known.cuboids.yaw + headings[known.frames]
    for car, rows in by_id(known.ids):
        for part in runs_of_frames(known.frames[rows], MAX_TURN_GAP_FRAMES):
            own = rows[part]
            for first, last in _turns(known.frames[own], np.unwrap(yaw[own]), frame_rate):
                yield "car turns", first, last, car, NO_PARTNER, np.nan


def _turns(
    frames: Int[Array, " k"], headings: Float[Array, " k"], frame_rate: float
) -> Iterator[tuple[int, int]]:
    """First and last frame of each time that a heading changes fast, and far enough."""
    if len(frames) < 2:
        return
    at = np.arange(len(frames))
    before, after = (
        np.maximum(at - RATE_HALF_WINDOW_FRAMES, 0),
        np.minimum(at + RATE_HALF_WINDOW_FRAMES, len(frames) - 1),
    )
    seconds = (frames[after] - frames[before]) / frame_rate
    fast = np.flatnonzero(np.abs(headings[after] - headings[before]) > MIN_TURN_RATE * seconds)
    for span in runs_of_frames(fast, MAX_TURN_GAP_FRAMES):
        part = fast[span]
        turned = headings[after[part[-1]]] - headings[before[part[0]]]
        if abs(float(turned)) >= MIN_TURN_ANGLE:
            yield int(frames[part[0]]), int(frames[part[-1]])


__all__ = ["camera_turns", "car_turns", "headings_of"]
