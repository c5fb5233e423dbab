"""Points that are seen in two images: corners, followed by pyramidal optical flow."""

from dataclasses import dataclass
from typing import Protocol, runtime_checkable

import cv2
import numpy as np
from jaxtyping import Bool, Float, Float32, UInt8
from numpy import ndarray as Array

EDGE_PIXELS = 12  # pixels at the image's edge that give no corner: half a window of the flow


@runtime_checkable
class Features(Protocol):
    """What finds the same points in two grey images."""

    def __call__(
        self, before: UInt8[Array, "h w"], now: UInt8[Array, "h w"], free: Bool[Array, "h w"]
    ) -> tuple[Float[Array, "n 2"], Float[Array, "n 2"]]:
        """Pixels in `before`, all of them where `free`, and the same points in `now`."""
        ...


@dataclass(frozen=True)
class CornerFlow:
    """The strongest corners of every cell of a grid, followed by Lucas and Kanade's flow.

    On KITTI's images it beats ORB with a ratio test in accuracy and speed
    (benchmarks/odometry.py measures both).
    """

    cell: int = 48
    """Side of a cell, px; more: fewer corners."""
    per_cell: int = 4
    """Most corners of a cell; more: surer motions, more time."""
    spacing: int = 6
    """Least distance between two corners, px; more: fewer corners, better spread."""
    quality: float = 2e-3
    """Least strength of a corner, share of the best one's; more: fewer corners."""
    window: int = 17
    """Side of the window that the flow compares, px; more: surer flow, blurred at edges of
    objects."""
    levels: int = 4
    """Highest level of the flow's image pyramid; more: larger motions are followed."""

    def __call__(
        self, before: UInt8[Array, "h w"], now: UInt8[Array, "h w"], free: Bool[Array, "h w"]
    ) -> tuple[Float[Array, "n 2"], Float[Array, "n 2"]]:
        """Pixels in `before`, all of them where `free`, and the same points in `now`."""
        start = self.corners(before, free)
        if not len(start):
            return np.zeros((0, 2)), np.zeros((0, 2))
        stop = (cv2.TERM_CRITERIA_EPS | cv2.TERM_CRITERIA_COUNT, 20, 0.02)
        size = (self.window, self.window)
        end, found, _ = cv2.calcOpticalFlowPyrLK(
            before,
            now,
            start,
            np.zeros_like(start),
            winSize=size,
            maxLevel=self.levels,
            criteria=stop,
        )
        height, width = before.shape
        inside = ((end > 2.0) & (end < (width - 3.0, height - 3.0))).all(axis=1)
        good = inside & (found[:, 0] > 0)
        return start[good].astype(float), end[good].astype(float)

    def corners(
        self, image: UInt8[Array, "h w"], free: Bool[Array, "h w"]
    ) -> Float32[Array, "n 2"]:
        """Where corners are, found at half the image's size; in the order of the grid."""
        height, width = image.shape[0] // 2, image.shape[1] // 2
        if min(height, width) <= 2 * EDGE_PIXELS:
            return np.zeros((0, 2), np.float32)
        small = cv2.resize(image, (width, height), interpolation=cv2.INTER_AREA)
        strength = cv2.cornerMinEigenVal(small, 5, ksize=3)
        window = np.ones((self.spacing // 2 | 1, self.spacing // 2 | 1), np.uint8)
        peak = (strength == cv2.dilate(strength, window)) & free[: 2 * height : 2, : 2 * width : 2]
        peak &= strength > self.quality * float(strength.max())
        inner = slice(EDGE_PIXELS // 2, -(EDGE_PIXELS // 2))
        kept = np.zeros_like(peak)
        kept[inner, inner] = peak[inner, inner]
        v, u = np.nonzero(kept)
        side = max(self.cell // 2, 1)
        cells = (v // side) * (width // side + 1) + u // side
        order = np.lexsort((-strength[v, u], cells))
        rank = np.arange(len(order)) - np.searchsorted(cells[order], cells[order])
        chosen = order[rank < self.per_cell]
        return np.stack((2.0 * u[chosen] + 0.5, 2.0 * v[chosen] + 0.5), axis=1).astype(np.float32)
