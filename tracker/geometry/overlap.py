"""Overlaps: axis-aligned boxes in the image, convex polygons on the road. No area, no overlap."""

import numpy as np
from jaxtyping import Float
from numpy import ndarray as Array

from tracker.kernels import Kernel

SHARED_AREAS = Kernel("tracker.kernels.polygons", "shared_areas")
# Divides no shared area without a warning.
MIN_AREA = np.finfo(float).tiny


def box_area(boxes: Float[Array, "*n 4"]) -> Float[Array, "*n"]:
    """Areas of boxes x_min, y_min, x_max, y_max; 0 for inverted ones."""
    sides = boxes[..., 2:] - boxes[..., :2]
    np.maximum(sides, 0.0, out=sides)
    return sides[..., 0] * sides[..., 1]


def box_intersection(a: Float[Array, "*#n 4"], b: Float[Array, "*#n 4"]) -> Float[Array, "..."]:
    """The shared area of boxes, broadcast: a[:, None], b[None] gives every pair."""
    sides = np.minimum(a[..., 2:], b[..., 2:])
    sides -= np.maximum(a[..., :2], b[..., :2])
    np.maximum(sides, 0.0, out=sides)
    return sides[..., 0] * sides[..., 1]


def box_iou(a: Float[Array, "*#n 4"], b: Float[Array, "*#n 4"]) -> Float[Array, "..."]:
    """Intersection over union, broadcast like `box_intersection`; 0 where there is no area."""
    shared = box_intersection(a, b)
    union = box_area(a) + box_area(b)
    union -= shared
    np.maximum(union, MIN_AREA, out=union)
    return shared / union


def covered_share(boxes: Float[Array, "n 4"], others: Float[Array, "m 4"]) -> Float[Array, " n"]:
    """The largest share of each box that one of the others, ending lower (nearer), covers."""
    if len(boxes) == 0 or len(others) == 0:
        return np.zeros(len(boxes))
    shared = box_intersection(boxes[:, None], others[None])
    shares = shared / np.maximum(box_area(boxes), 1e-6)[:, None]
    return np.where(others[None, :, 3] > boxes[:, None, 3], shares, 0.0).max(axis=1).clip(0.0, 1.0)


def polygon_area(polygons: Float[Array, "n k 2"]) -> Float[Array, " n"]:
    """Areas of simple polygons (the shoelace formula), whichever way they turn."""
    x, y = polygons[..., 0], polygons[..., 1]
    doubled = x * np.roll(y, -1, axis=-1) - y * np.roll(x, -1, axis=-1)
    return 0.5 * np.abs(doubled.sum(axis=-1))


def convex_intersection(a: Float[Array, "n k 2"], b: Float[Array, "n m 2"]) -> Float[Array, " n"]:
    """The area that polygon i of a shares with polygon i of b.

    A kernel cuts one at the sides of the other. OpenCV's intersectConvexConvex is slower, and wrong
    by up to 47 m^2 for every 50th pair of nearly parallel rectangles, which cars on one road are
    (`python -m benchmarks.overlap`).
    """
    shared = np.empty(len(a))
    SHARED_AREAS(np.ascontiguousarray(a), np.ascontiguousarray(b), shared)
    return shared
