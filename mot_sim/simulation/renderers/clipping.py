"""Polygons, cut by a plane."""

import numpy as np
from jaxtyping import Float
from numpy import ndarray as Array


def clip_polygon(
    points: Float[Array, "n d"], depth: Float[Array, " n"], near: float = 0.0
) -> Float[Array, "m d"]:
    """The part of a convex polygon where `depth`, linear over it, is at least `near`.

    Sutherland and Hodgman's rule for one plane; no point is left of what lies wholly behind.
    """
    inside = depth >= near
    if inside.all():
        return points
    if not inside.any():
        return points[:0]
    after, depth_after = np.roll(points, -1, axis=0), np.roll(depth, -1)
    kept: list[Float[Array, " d"]] = []
    for i, leaves in enumerate(inside != np.roll(inside, -1)):
        if inside[i]:
            kept.append(points[i])
        if leaves:
            share = (near - depth[i]) / (depth_after[i] - depth[i])
            kept.append(points[i] + share * (after[i] - points[i]))
    return np.array(kept)
