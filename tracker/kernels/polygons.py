"""The shared area of convex polygons, by cutting one at the sides of the other."""

from math import inf, isnan, nan

import numpy as np

from tracker.kernels.compiling import F3, OUT1, inlined, kernel


@inlined
def twice_area(polygon, count):
    """Twice the signed area of a polygon with so many corners (the shoelace formula)."""
    doubled = 0.0
    for corner in range(count):
        after = corner + 1 if corner + 1 < count else 0
        doubled += polygon[corner, 0] * polygon[after, 1] - polygon[after, 0] * polygon[corner, 1]
    return doubled


@inlined
def cut(polygon, count, x, y, to_x, to_y, left):
    """The part of a polygon on the left of a line into `left`; how many corners it has."""
    kept = 0
    for corner in range(count):
        after = corner + 1 if corner + 1 < count else 0
        px, py, qx, qy = (
            polygon[corner, 0],
            polygon[corner, 1],
            polygon[after, 0],
            polygon[after, 1],
        )
        here = to_x * (py - y) - to_y * (px - x)
        there = to_x * (qy - y) - to_y * (qx - x)
        if here >= 0.0:
            left[kept, 0], left[kept, 1] = px, py
            kept += 1
        if (here > 0.0 and there < 0.0) or (here < 0.0 and there > 0.0):
            share = here / (here - there)
            left[kept, 0], left[kept, 1] = px + share * (qx - px), py + share * (qy - py)
            kept += 1
    return kept


@inlined
def reach_of(polygon, axis):
    """Where a polygon begins and ends along an axis; NaN if a corner is."""
    low, high = inf, -inf
    for corner in range(len(polygon)):
        place = polygon[corner, axis]
        if isnan(place):
            return nan, nan
        low, high = min(low, place), max(high, place)
    return low, high


@inlined
def boxes_meet(a, b):
    """Whether the upright boxes around two polygons share area; False if a corner is NaN."""
    for axis in range(2):
        one, other = reach_of(a, axis), reach_of(b, axis)
        if not (one[0] < one[1] and other[0] < other[1]):
            return False
        if not (one[0] < other[1] and other[0] < one[1]):
            return False
    return True


@kernel(F3, F3, OUT1)
def shared_areas(a, b, shared):
    """The area that each polygon of a (n, k, 2) shares with that of b (n, m, 2), both convex."""
    corners, sides = a.shape[1], b.shape[1]
    one, other = np.empty((corners + 2 * sides, 2)), np.empty((corners + 2 * sides, 2))
    by = np.empty((sides, 2))
    for pair in range(len(a)):
        shared[pair] = 0.0
        if corners == 0 or sides == 0 or not boxes_meet(a[pair], b[pair]):
            continue
        x, y, count = a[pair, 0, 0], a[pair, 0, 1], corners  # near the origin nothing is lost
        for corner in range(corners):
            one[corner, 0], one[corner, 1] = a[pair, corner, 0] - x, a[pair, corner, 1] - y
        for corner in range(sides):
            by[corner, 0], by[corner, 1] = b[pair, corner, 0] - x, b[pair, corner, 1] - y
        turn = 1.0 if twice_area(by, sides) > 0.0 else -1.0
        for side in range(sides):
            after = side + 1 if side + 1 < sides else 0
            x, y = by[side, 0], by[side, 1]
            count = cut(
                one, count, x, y, turn * (by[after, 0] - x), turn * (by[after, 1] - y), other
            )
            one, other = other, one
        shared[pair] = 0.5 * abs(twice_area(one, count))
