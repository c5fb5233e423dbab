"""The check of a drive while it is tracked: frames are collected, and judged many at a time."""

import sys
import warnings
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy import ndarray as Array

from tracker.errors import MotionWarning
from tracker.motion_check.causes import (
    MAX_SIZES,
    Contradiction,
    contradiction,
    judge_focal_length,
    judge_rotations,
    judge_short_drive,
    judge_sizes,
    judge_translations,
)
from tracker.motion_check.leaps import find_leap
from tracker.motion_check.observations import Observations, observe
from tracker.types import Camera, Frame

# Frames that are looked at together: the first few soon, later ones when it is cheap.
FIRST_FRAMES, BATCH_FRAMES = 24, 80
# A verdict is asked for whenever there are so many times more frames; after the last, what
# belongs to the whole drive has been judged, and only leaps are looked for.
LOOK_FACTOR = 1.6
LAST_LOOK = 512


@dataclass(frozen=True, eq=False)
class MotionCheck:
    """What was gathered of a drive; never modified, so keeping it is a copy."""

    frames: tuple[tuple[int, float, Float[Array, "_ 4"], Float[Array, "4 4"] | None], ...] = ()
    """Index, time, boxes and T_now_before of the frames that are not yet looked at, after the
    last one that is."""
    seen: tuple[Observations, ...] = ()
    """What the frames before them told."""
    count: int = 0
    """How many frames there were."""
    next_look: float = float(FIRST_FRAMES)
    """From how many frames on a verdict is due."""
    found: Contradiction | None = None
    """What contradicts; after it nothing is looked for."""

    def after(
        self,
        frame: Frame,
        T_now_before: Float[Array, "4 4"] | None,
        boxes: Float[Array, "n 4"],
        camera: Camera,
        car_height: float,
    ) -> "MotionCheck":
        """The check after a frame with these boxes; a MotionWarning when they contradict it.

        T_now_before: since the last call's frame, between which others may lie that nothing
        looked at; None: unknown. car_height: of a usual one, metres.
        """
        if self.found is not None:
            return self
        T_kept = None if T_now_before is None else T_now_before.copy()
        frames = (*self.frames, (frame.index, frame.time, boxes, T_kept))
        count = self.count + 1
        due = FIRST_FRAMES if count <= 2 * FIRST_FRAMES else BATCH_FRAMES
        if len(frames) <= due:
            return MotionCheck(frames, self.seen, count, self.next_look, None)
        indices, times, all_boxes, Ts = zip(*frames, strict=True)
        found = find_leap(indices, times, all_boxes, Ts, camera, car_height)
        seen, next_look = self.seen, self.next_look
        if count - len(frames) < LAST_LOOK:
            seen = (*seen, observe(times, all_boxes, Ts, camera, car_height))
            if found is None and count >= next_look:
                found = judge(seen, camera, car_height)
                next_look = LOOK_FACTOR * count
        else:
            seen = ()
        if found is not None:
            text = f"up to frame {frame.index}: {found.text}"
            warnings.warn(text, MotionWarning, stacklevel=1 + _calls_inside())
        return MotionCheck(frames[-1:], seen, count, next_look, found)

    def verdict(self, camera: Camera, car_height: float) -> Contradiction | None:
        """What all frames so far contradict, with those that are not yet looked at."""
        seen = self.seen
        if self.found is not None or self.count > LAST_LOOK:
            return self.found
        if len(self.frames) > 1:
            indices, times, boxes, Ts = zip(*self.frames, strict=True)
            found = find_leap(indices, times, boxes, Ts, camera, car_height)
            if found is not None:
                return found
            seen = (*seen, observe(times, boxes, Ts, camera, car_height))
        if not seen:
            return None
        found = judge(seen, camera, car_height)
        return found if found or self.seen else judge_short_drive(seen[0].depths)


def _calls_inside() -> int:
    """How many calls up the stack the caller of this package is."""
    calls, call = 1, sys._getframe(1)
    while call.f_back is not None and str(call.f_globals.get("__name__")).startswith("tracker."):
        calls, call = calls + 1, call.f_back
    return calls - 1


def judge(
    seen: tuple[Observations, ...], camera: Camera, car_height: float
) -> Contradiction | None:
    """What the observations contradict most plainly, if anything."""
    shifts = np.concatenate([part.shifts for part in seen])
    depths = np.concatenate([part.depths for part in seen])
    sizes = np.concatenate([part.sizes for part in seen])
    sizes = sizes[:: 1 + len(sizes) // MAX_SIZES]
    by_size = judge_sizes(sizes, camera, car_height)
    if by_size is not None:
        return by_size
    cause = judge_rotations(shifts, depths)
    if cause is not None:
        return contradiction(cause)
    return judge_translations(depths) or judge_focal_length(shifts)
