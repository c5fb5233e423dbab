"""Convex patches of ground by the place they are at, and how they are filled into a tile."""

from dataclasses import dataclass
from functools import cached_property

import cv2
import numpy as np
from jaxtyping import Float, Int, Int32, UInt8
from numpy import ndarray as Array

from mot_sim.simulation.renderers.triangles import clip_polygon

SUBTEXEL_BITS = 4  # fractional bits of the corners
SQUARE_METRES = 16.0  # metres: patches are looked up by squares of this size
MAX_SQUARES = 1 << 24  # more than there are squares in a column
HALVES = (slice(0, 2), slice(2, 4))
MAX_TEXELS_OUTSIDE = 4000.0  # texels beyond an image at which polygons are cut


@dataclass(frozen=True, eq=False)
class Patches:
    """Convex polygons on the ground, each with the value that it is filled with."""

    corners: tuple[Float[Array, "_ 2"], ...]
    """Corners x, y of each polygon in world, metres."""
    values: tuple[tuple[int, ...], ...]
    """What each polygon is filled with: one number per channel, 0 to 255."""

    @cached_property
    def boxes(self) -> Float[Array, "n 4"]:
        """The smallest and largest x, y of each."""
        if not self.corners:
            return np.zeros((0, 4))
        return np.array([(*one.min(axis=0), *one.max(axis=0)) for one in self.corners])

    @cached_property
    def _squares(self) -> tuple[Int[Array, " k"], Int[Array, " k"]]:
        """Keys of the squares that boxes touch, ascending, and which box each is of."""
        first, last = (
            np.floor(self.boxes / SQUARE_METRES).astype(np.int64)[:, side] for side in HALVES
        )
        wide, high = (last - first + 1).T
        rows = np.repeat(np.arange(len(first)), wide * high)
        start = np.repeat(np.cumsum(wide * high) - wide * high, wide * high)
        step = np.arange(len(rows)) - start
        keys = (
            (first[rows, 0] + step % wide[rows]) * MAX_SQUARES + first[rows, 1] + step // wide[rows]
        )
        order = np.argsort(keys, kind="stable")
        return keys[order], rows[order]

    def within(self, low: Float[Array, "2"], high: Float[Array, "2"]) -> Int[Array, " k"]:
        """Which ones may touch a rectangle, in their order."""
        if not self.corners:
            return np.zeros(0, np.int64)
        keys, rows = self._squares
        columns = np.arange(np.floor(low[0] / SQUARE_METRES), np.floor(high[0] / SQUARE_METRES) + 1)
        starts = columns.astype(np.int64) * MAX_SQUARES
        begin = np.searchsorted(keys, starts + int(np.floor(low[1] / SQUARE_METRES)), "left")
        end = np.searchsorted(keys, starts + int(np.floor(high[1] / SQUARE_METRES)), "right")
        found = [rows[a:b] for a, b in zip(begin.tolist(), end.tolist(), strict=True)]
        near = np.sort(np.concatenate(found))
        if not len(near):
            return near
        near = near[np.append(True, near[1:] != near[:-1])]  # (np.unique takes twice the time)
        boxes = self.boxes[near]
        return near[((boxes[:, :2] < high) & (boxes[:, 2:] > low)).all(axis=1)]

    def fill(
        self,
        image: UInt8[Array, "h w *c"],
        low: Float[Array, "2"],
        texel: float,
        rows: Int[Array, " k"] | None = None,
    ) -> UInt8[Array, "h w *c"]:
        """The image, with those that touch it filled in, in their order.

        low: x, y of the outer corner of the first texel. texel: metres. rows: which may touch it,
        where that is known.
        """
        size = np.array(image.shape[1::-1], dtype=float)
        rows = self.within(low, low + size * texel) if rows is None else rows
        if not len(rows):
            return image
        points, ends = self._points
        lengths = ends[rows + 1] - ends[rows]
        stops = np.cumsum(lengths)
        chosen = np.arange(stops[-1]) + np.repeat(ends[rows] - stops + lengths, lengths)
        texels = (points[chosen] - low) / texel - 0.5
        outside = np.maximum(-texels, texels - size).max(axis=1) > MAX_TEXELS_OUTSIDE
        far = np.maximum.reduceat(outside, stops - lengths).tolist()
        fixed = fixed_points(texels)
        starts = (stops - lengths).tolist()
        for row, a, b, is_far in zip(rows.tolist(), starts, stops.tolist(), far, strict=True):
            outline = fixed_points(_cut(texels[a:b], size)) if is_far else fixed[a:b]
            if len(outline) >= 3:
                cv2.fillConvexPoly(image, outline, self.values[row], cv2.LINE_8, SUBTEXEL_BITS)
        return image

    @cached_property
    def _points(self) -> tuple[Float[Array, "k 2"], Int[Array, " m"]]:
        """All corners, and where those of each polygon begin; the last one's end."""
        ends = np.cumsum([0, *(len(one) for one in self.corners)])
        return np.concatenate(self.corners), ends


def fill_fixed(image: UInt8[Array, "h w"], corners: Int32[Array, "n 2"]) -> None:
    """Fill one convex outline with 255, in place; it lies in the image or not far beside it.

    corners: see `fixed_points`.
    """
    cv2.fillConvexPoly(image, corners, (255,), cv2.LINE_8, SUBTEXEL_BITS)


def fixed_points(texels: Float[Array, "*n 2"]) -> Int32[Array, "*n 2"]:
    """Points x, y in texels, the first one's centre at 0, as OpenCV fills with fractions."""
    return np.round(texels * (1 << SUBTEXEL_BITS)).astype(np.int32)


def _cut(texels: Float[Array, "n 2"], size: Float[Array, "2"]) -> Float[Array, "m 2"]:
    for axis in (0, 1):
        for distance in (MAX_TEXELS_OUTSIDE + texels[:, axis], None):
            if not len(texels):
                return texels
            inside = (
                size[axis] + MAX_TEXELS_OUTSIDE - texels[:, axis] if distance is None else distance
            )
            texels = clip_polygon(texels, inside)
    return texels
