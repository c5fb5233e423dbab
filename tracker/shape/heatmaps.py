"""From the network's maps to points: where each keypoint is, and how surely it is seen there."""

import numpy as np
from jaxtyping import Float, Float32
from numpy import ndarray as Array

# Cells around the peak whose mean is the point; `benchmarks.keypoints --synthetic` tries others.
PEAK_REACH = 2


def chances(heatmaps: Float32[Array, "n k h w"]) -> Float32[Array, "n k h w"]:
    """The probability that a keypoint is seen in a cell; what is left to 1: that it is not seen.

    heatmaps: log odds of each cell against `not seen`, whose own is 0.
    """
    top = np.maximum(heatmaps.max(axis=(2, 3), keepdims=True, initial=0.0), 0.0)
    raised = np.exp(heatmaps - top)
    raised /= raised.sum(axis=(2, 3), keepdims=True) + np.exp(-top)
    return raised


def decode(heatmaps: Float32[Array, "n k h w"], reach: int = PEAK_REACH) -> Float[Array, "n k 3"]:
    """The points of heatmaps: x, y as shares of the crop's sides, and a confidence.

    A point is the mean of the cells around the likeliest one, weighted by their chances; its
    confidence is the chance that the keypoint is seen in one of these. reach: how many cells
    around are taken.
    """
    n, k, h, w = heatmaps.shape
    maps = chances(heatmaps).reshape(n * k, h, w)
    peaks = maps.reshape(n * k, h * w).argmax(axis=1)
    rows, columns = np.divmod(peaks, w)
    around = np.arange(-reach, reach + 1)
    v = rows[:, None] + around
    u = columns[:, None] + around
    inside = ((v >= 0) & (v < h))[:, :, None] & ((u >= 0) & (u < w))[:, None, :]
    cells = maps[
        np.arange(n * k)[:, None, None], v.clip(0, h - 1)[:, :, None], u.clip(0, w - 1)[:, None, :]
    ]
    cells = np.where(inside, cells, 0.0).astype(np.float64)
    sums = cells.sum(axis=(1, 2))
    share = np.maximum(sums, 1e-300)
    x = ((cells.sum(axis=1) * u).sum(axis=1) / share + 0.5) / w
    y = ((cells.sum(axis=2) * v).sum(axis=1) / share + 0.5) / h
    return np.stack((x, y, sums), axis=1).reshape(n, k, 3)
