"""Boxes mixed with predicted ones, by gains that are learned."""

from math import isfinite, nan

import numpy as np

from tracker.kernels.compiling import A2, F1, F2, FLOAT, I1, OUT2, inlined, kernel


@inlined
def learn(gains, pairs, power, old_gains, prior, sums, limits):
    """Shift gains towards white innovations: sum of products / sum of squares, see `BoxFilter`."""
    for size in range(3):
        worth = 1.0 + prior / max(pairs[size, 0], 1.0)
        for side in range(4):
            by = power[size, side] * worth + limits[3]
            gain = old_gains[size, side] + sums[size, side] / by
            gains[size, side] = min(max(gain, limits[2]), 1.0)


@kernel(
    F2, F2, F2, F1, A2, A2, I1, F1, F2, FLOAT, F1, FLOAT, FLOAT, F1, OUT2, OUT2, OUT2, OUT2, OUT2
)
def filter_boxes(
    old_gains, old_pairs, old_power, sizes, expected, boxes, hits, since, before, dt, far,
    border, prior, limits, filtered, innovations, gains, pairs, power,
):  # fmt: skip
    """The filtered boxes (k, 4) of tracks, their innovations, and what was learned.

    limits: of innovations, of successive steps, the least gain and power.
    """
    off, sums, is_learned = np.empty(4), np.zeros((3, 4)), False
    for size in range(3):
        pairs[size, 0] = old_pairs[size, 0]
        for side in range(4):
            gains[size, side], power[size, side] = old_gains[size, side], old_power[size, side]
    for car in range(len(boxes)):
        width, height = expected[car, 2] - expected[car, 0], expected[car, 3] - expected[car, 1]
        size = int(min(width, height) > sizes[0]) + int(min(width, height) > sizes[1])
        is_cut = boxes[car, 0] < border or boxes[car, 1] < border
        is_cut = is_cut or boxes[car, 2] > far[0] - border or boxes[car, 3] > far[1] - border
        skipped = since[car] > limits[1] * dt
        is_usable = isfinite(before[car, 0])
        for axis in range(2):
            low = boxes[car, axis] - expected[car, axis]
            high = boxes[car, axis + 2] - expected[car, axis + 2]
            off[axis], off[axis + 2] = 0.5 * low + 0.5 * high, high - low
        for side in range(4):
            innovation = min(max(off[side] / max(height, 1.0), -limits[0]), limits[0])
            innovations[car, side] = nan if skipped or is_cut else innovation
            gain = max(old_gains[size, side], 1.0 / (hits[car] + 1.0))
            if skipped and dt > 0.0:
                gain = 1.0 - (1.0 - gain) ** (since[car] / dt)
            off[side] *= 1.0 if is_cut else gain
        for axis in range(2):
            filtered[car, axis] = expected[car, axis] + (off[axis] - 0.5 * off[axis + 2])
            filtered[car, axis + 2] = expected[car, axis + 2] + (off[axis] + 0.5 * off[axis + 2])
        if is_usable and isfinite(innovations[car, 0]):
            is_learned = True
            pairs[size, 0] += 1.0
            for side in range(4):
                a, b = before[car, side], innovations[car, side]
                power[size, side] += 0.5 * (a * a + b * b)
                sums[size, side] += a * b
    if is_learned:
        learn(gains, pairs, power, old_gains, prior, sums, limits)
