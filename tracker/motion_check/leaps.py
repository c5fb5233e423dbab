"""Motions that leap: far off those of the frames around them, while the boxes stay in place."""

from collections.abc import Sequence

import numpy as np
from jaxtyping import Float
from numpy import ndarray as Array

from tracker.geometry import box_iou
from tracker.motion_check.causes import Contradiction, contradiction
from tracker.types import Camera

# Frames before and after that a motion is compared with.
AROUND = 3
# What a motion may differ by: from frame to frame, and by the fiercest braking and steering.
MAX_METRES, MAX_ACCELERATION = 1.0, 30.0
MAX_RADIANS, MAX_TURN_ACCELERATION = np.radians(3.0), np.radians(100.0)
# A box that is where it is predicted, and one that is not.
MIN_SUPPORT, MAX_SUPPORT = 0.4, 0.1
MIN_DEPTH = 1.0


def find_leap(
    indices: Sequence[int],
    times: Sequence[float],
    boxes: Sequence[Float[Array, "_ 4"]],
    Ts_now_before: Sequence[Float[Array, "4 4"] | None],
    camera: Camera,
    car_height: float,
) -> Contradiction | None:
    """The first leap among the frames that the boxes contradict; all but the first are judged."""
    seconds = np.diff(times)
    known = np.array([T is not None for T in Ts_now_before[1:]]) & (seconds > 0.0)
    if np.count_nonzero(known) < 2 * AROUND:
        return None
    rows = np.flatnonzero(known)
    Ts = np.array([Ts_now_before[row + 1] for row in rows.tolist()])
    dt = seconds[rows]
    R = Ts[:, :3, :3]
    turns = 0.5 * np.column_stack(
        (R[:, 2, 1] - R[:, 1, 2], R[:, 0, 2] - R[:, 2, 0], R[:, 1, 0] - R[:, 0, 1])
    )
    rates = np.column_stack((Ts[:, :3, 3], turns)) / dt[:, None]
    limits = np.column_stack((
        MAX_METRES + MAX_ACCELERATION * dt**2, MAX_RADIANS + MAX_TURN_ACCELERATION * dt**2,
    ))  # fmt: skip
    if not (_lengths(np.diff(rates, axis=0)) * dt[1:, None] > limits[1:]).any():
        return None
    padded = np.pad(rates, ((AROUND, AROUND), (0, 0)), mode="reflect")
    windows = np.lib.stride_tricks.sliding_window_view(padded, 2 * AROUND + 1, axis=0)
    usual = np.median(windows, axis=2)
    off = _lengths(rates - usual) * dt[:, None]
    is_more = ((off > limits) & (_lengths(rates) > _lengths(usual))).any(axis=1)
    metres, radians = off.T
    for place in np.flatnonzero(is_more):
        row = int(rows[place])
        calm = np.flatnonzero(~is_more)
        if len(calm) == 0:
            return None
        neighbour = calm[np.abs(calm - place).argmin()]
        before, now = boxes[row], boxes[row + 1]
        by_leap = _support(before, now, Ts[place], camera, car_height)
        without = _support(before, now, Ts[neighbour], camera, car_height)
        if ((without > MIN_SUPPORT) & (by_leap < MAX_SUPPORT)).any() and not (
            (by_leap > MIN_SUPPORT) & (without < MAX_SUPPORT)
        ).any():
            return contradiction(
                "leap",
                frame=indices[row + 1],
                metres=float(metres[place]),
                degrees=float(np.degrees(radians[place])),
            )
    return None


def _lengths(rates: Float[Array, "n 6"]) -> Float[Array, "n 2"]:
    """Lengths of the translations and of the rotations."""
    return np.sqrt((rates.reshape(-1, 2, 3) ** 2).sum(axis=2))


def _support(
    before: Float[Array, "n 4"],
    now: Float[Array, "m 4"],
    T_now_before: Float[Array, "4 4"],
    camera: Camera,
    car_height: float,
) -> Float[Array, " n"]:
    """How well each box, of a car that stands, is found again: its best IoU."""
    if len(now) == 0 or len(before) == 0:
        return np.zeros(len(before))
    heights = np.maximum(before[:, 3] - before[:, 1], 1.0)
    depth = camera.K[1, 1] * car_height / heights
    centres = camera.rays(0.5 * (before[:, :2] + before[:, 2:])) * depth[:, None]
    moved = centres @ T_now_before[:3, :3].T + T_now_before[:3, 3]
    ahead = np.maximum(moved[:, 2], MIN_DEPTH)
    half = 0.5 * (before[:, 2:] - before[:, :2]) * (depth / ahead)[:, None]
    pixels = (moved @ camera.K.T)[:, :2] / ahead[:, None]
    predicted = np.concatenate((pixels - half, pixels + half), axis=1)
    return box_iou(predicted[:, None], now[None]).max(axis=1)
