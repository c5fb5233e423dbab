"""What boxes tell of the camera's motion, from many frames at once: shifts, depths, sizes.

Detections of neighbouring frames are matched here by their overlap alone: the tracker's own
matches depend on the motion that is to be judged.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, Int
from numpy import ndarray as Array

from tracker.types import Camera

# Boxes of one frame that are looked at, the tallest of them.
MAX_BOXES = 12
# Boxes of two frames that overlap less are not taken for the same car.
MIN_IOU = 0.3
# Rotations that shift pixels by more are also tried, forwards and backwards, to match boxes.
TURNING_PIXELS = 4.0
# Nearer to the image's border a box may be cut.
BORDER_PIXELS = 3.0
# Depths are compared over this time, seconds.
BASELINE_SECONDS = 0.5
# Boxes that are lower have no useful size, pixels.
MIN_HEIGHT_PIXELS = 20.0
# The sizes of one frame in so many are kept.
SIZE_STRIDE = 4
# Std of the ratio of a box's heights in two frames (edges of 2.5 to 3 %, partly shared).
HEIGHT_STD = 0.045
# A pixel that goes behind the camera by a rotation stays where this depth puts it.
MIN_SCALE = 0.2


@dataclass(frozen=True, eq=False)
class Observations:
    """What was seen in some frames."""

    shifts: Float[Array, "t 4"]
    """For every frame the shift of the boxes' centres since the one before, u and v, and the one
    that the rotation predicts, pixels: medians over the cars; NaN where there are none."""
    depths: Float[Array, "k 5"]
    """For a car and a baseline: how much nearer it came, how much the camera moved ahead, the
    std of their difference, in metres, the seconds that it took, and how much the camera moved
    to the right, metres: ahead by the axes of vehicles."""
    sizes: Float[Array, "s 2"]
    """Of whole boxes: height, and how far the bottom is below the image's principal point."""


def observe(
    times: Sequence[float],
    boxes: Sequence[Float[Array, "_ 4"]],
    Ts_now_before: Sequence[Float[Array, "4 4"] | None],
    camera: Camera,
    car_height: float,
) -> Observations:
    """What the boxes of these frames tell; all but the first have a motion since the one before."""
    table = _padded(boxes)
    count = len(times)
    known = np.array([T is not None for T in Ts_now_before])
    Ts = np.array([np.eye(4) if T is None else T for T in Ts_now_before])
    centres = 0.5 * (table[:, :, :2] + table[:, :, 2:])
    heights = table[:, :, 3] - table[:, :, 1]
    predicted = _rotated(centres[:-1], Ts[1:, :3, :3], camera) - centres[:-1]
    partners = _matched(table, predicted)
    partners[~known[1:]] = -1
    is_whole = _whole(table, camera)
    shifts = np.full((count - 1, 4), np.nan)
    frames, now = np.nonzero(partners >= 0)
    before = partners[frames, now]
    both = is_whole[frames, before] & is_whole[frames + 1, now]
    frames, now, before = frames[both], now[both], before[both]
    if len(frames):
        moved = centres[frames + 1, now] - centres[frames, before]
        columns = np.column_stack((moved, predicted[frames, before]))
        shifts = _medians(frames, columns, count - 1)
    step = (times[-1] - times[0]) / max(count - 1, 1)
    base = max(1, round(BASELINE_SECONDS / step)) if step > 0.0 else count
    depths = _depths(base, np.asarray(times), Ts, known, partners, heights, is_whole,
                     camera.K[1, 1] * car_height)  # fmt: skip
    tall = is_whole[1::SIZE_STRIDE] & (heights[1::SIZE_STRIDE] > MIN_HEIGHT_PIXELS)
    below = table[1::SIZE_STRIDE, :, 3] - camera.K[1, 2]
    sizes = np.column_stack((heights[1::SIZE_STRIDE][tall], below[tall]))
    return Observations(shifts, depths, sizes)


def _padded(boxes: Sequence[Float[Array, "_ 4"]]) -> Float[Array, "t m 4"]:
    """The boxes of every frame, the tallest first where there are too many; the rest is 0."""
    most = min(MAX_BOXES, max(1, *(len(rows) for rows in boxes)))
    table = np.zeros((len(boxes), most, 4))
    for row, found in zip(table, boxes, strict=True):
        if len(found) > most:
            row[:] = found[np.argsort(found[:, 1] - found[:, 3], kind="stable")[:most]]
        else:
            row[: len(found)] = found
    return table


def _rotated(
    centres: Float[Array, "t m 2"], Rs: Float[Array, "t 3 3"], camera: Camera
) -> Float[Array, "t m 2"]:
    """Where a rotation of the camera alone puts pixels."""
    H = camera.K @ Rs @ camera.K_inverse
    pixels = centres @ H[:, :, :2].swapaxes(1, 2) + H[:, None, :, 2]
    return pixels[:, :, :2] / np.maximum(pixels[:, :, 2:], MIN_SCALE)


def _matched(table: Float[Array, "t m 4"], predicted: Float[Array, "p m 2"]) -> Int[Array, "p m"]:
    """For every box the row of the same car in the frame before, or -1.

    They are the ones that overlap each other most. Where the camera is said to turn, boxes are
    also shifted as it says, and against it; what overlaps most in all is taken.
    """
    before, now = table[:-1], table[1:]
    partners, overlap = _best(before, now)
    turns = np.flatnonzero(np.abs(predicted[:, :, 0]).max(axis=1, initial=0.0) > TURNING_PIXELS)
    for sign in (1.0, -1.0) if len(turns) else ():
        shifted = before[turns] + sign * np.tile(predicted[turns], 2)
        others, total = _best(shifted, now[turns])
        better = total > overlap[turns]
        partners[turns[better]] = others[better]
        overlap[turns[better]] = total[better]
    return partners


def _best(
    before: Float[Array, "t m 4"], now: Float[Array, "t m 4"]
) -> tuple[Int[Array, "t m"], Float[Array, " t"]]:
    """For every box of now the one before that it shares most with, mutually; the sum of IoUs."""
    a, b = before[:, :, None], now[:, None]
    width = np.minimum(a[..., 2], b[..., 2]) - np.maximum(a[..., 0], b[..., 0])
    height = np.minimum(a[..., 3], b[..., 3]) - np.maximum(a[..., 1], b[..., 1])
    shared = np.maximum(width, 0.0) * np.maximum(height, 0.0)
    area_before = (before[..., 2] - before[..., 0]) * (before[..., 3] - before[..., 1])
    area_now = (now[..., 2] - now[..., 0]) * (now[..., 3] - now[..., 1])
    iou = shared / np.maximum(area_before[:, :, None] + area_now[:, None] - shared, 1e-9)
    partners, backwards = iou.argmax(axis=1), iou.argmax(axis=2)
    frame, row = np.ogrid[: len(iou), : iou.shape[1]]
    best = iou[frame, partners, row]
    mutual = backwards[frame, partners] == row
    is_same = mutual & (best > MIN_IOU)
    partners[~is_same] = -1
    return partners, np.where(is_same, best, 0.0).sum(axis=1)


def _whole(table: Float[Array, "t m 4"], camera: Camera) -> Bool[Array, "t m"]:
    """Which boxes are not cut by the image's border; none of the padding."""
    low, high = table[:, :, :2].min(axis=2), camera.far_corner[2:] - table[:, :, 2:]
    inside = (low >= BORDER_PIXELS) & (high.min(axis=2) >= BORDER_PIXELS)
    return inside & (table[:, :, 3] > table[:, :, 1])


def _medians(
    groups: Int[Array, " n"], columns: Float[Array, "n c"], count: int
) -> Float[Array, "t c"]:
    """Medians of the columns by groups 0 ... count - 1, which come in order; NaN of none."""
    sizes = np.bincount(groups, minlength=count)
    starts = np.cumsum(sizes) - sizes
    medians = np.full((count, columns.shape[1]), np.nan)
    some = sizes > 0
    low = (starts + (sizes - 1) // 2)[some]
    high = (starts + sizes // 2)[some]
    for number, column in enumerate(columns.T):
        ordered = column[np.lexsort((column, groups))]
        medians[some, number] = 0.5 * (ordered[low] + ordered[high])
    return medians


def _depths(
    base: int,
    times: Float[Array, " t"],
    Ts: Float[Array, "t 4 4"],
    known: Bool[Array, " t"],
    partners: Int[Array, "p m"],
    heights: Float[Array, "t m"],
    is_whole: Bool[Array, "t m"],
    metres_by_pixels: float,
) -> Float[Array, "k 5"]:
    """Of cars that were seen throughout a baseline of some frames: see `Observations.depths`.

    A car's depth is that of its height; baselines do not share frames.
    """
    ends = np.arange(base, len(times), base)
    if len(ends) == 0 or partners.shape[1] == 0:
        return np.zeros((0, 5))
    rows = np.tile(np.arange(partners.shape[1]), (len(ends), 1))
    is_known = np.ones(len(ends), bool)
    Ts_end = np.tile(np.eye(4), (len(ends), 1, 1))
    for back in range(base):
        at = ends - back
        rows = np.where(rows >= 0, partners[at[:, None] - 1, rows], -1)
        Ts_end = Ts_end @ Ts[at]
        is_known &= known[at]
    right, ahead = -Ts_end[:, 0, 3], -Ts_end[:, 2, 3]
    at, car = np.nonzero((rows >= 0) & is_known[:, None])
    first, now = (ends[at] - base, rows[at, car]), (ends[at], car)
    whole = is_whole[first] & is_whole[now]
    at, first, now = at[whole], tuple(p[whole] for p in first), tuple(p[whole] for p in now)
    z_first, z_now = metres_by_pixels / heights[first], metres_by_pixels / heights[now]
    seconds = times[ends[at]] - times[ends[at] - base]
    std = HEIGHT_STD * z_first
    return np.column_stack((z_first - z_now, ahead[at], std, seconds, right[at]))
