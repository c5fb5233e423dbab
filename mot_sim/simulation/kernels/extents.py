"""Boxes around what triangles cover, inside the image and beyond; what may hide it."""

from math import inf

from tracker.kernels.compiling import (
    F1,
    F2,
    F3,
    I2,
    OUT1,
    OUT2,
    OUT3,
    OUT_B1,
    inlined,
    kernel,
)


@inlined
def widen(box, u, v):
    """Let a box hold a point."""
    box[0], box[1] = min(box[0], u), min(box[1], v)
    box[2], box[3] = max(box[2], u), max(box[3], v)


@inlined
def widen_inside(box, u, v, far, rounding):
    """Let a box hold a point; one on the image's border, up to rounding, is exactly there."""
    u = 0.0 if u < rounding else (far[0] if u > far[0] - rounding else u)
    v = 0.0 if v < rounding else (far[1] if v > far[1] - rounding else v)
    widen(box, u, v)


@inlined
def is_around(u, v, triangle):
    """Whether a point lies inside a triangle (3, 2), not on its edges."""
    right, left = True, True
    for edge in range(3):
        a, b = triangle[edge], triangle[(edge + 1) % 3]
        turn = (a[0] - u) * (b[1] - v) - (a[1] - v) * (b[0] - u)
        right, left = right and turn > 0.0, left and turn < 0.0
    return right or left


@inlined
def enclose_inside(box, triangle, far, tolerances):
    """Let a box hold what a triangle (3, 2) covers of the image from (0, 0) to far.

    By Liang and Barsky's rule an edge is inside between its last entry and its first exit.
    """
    a, b, c = triangle[0], triangle[1], triangle[2]
    low_u, high_u = min(a[0], b[0], c[0]), max(a[0], b[0], c[0])
    low_v, high_v = min(a[1], b[1], c[1]), max(a[1], b[1], c[1])
    if high_u < 0.0 or high_v < 0.0 or low_u > far[0] or low_v > far[1]:
        return
    if low_u >= 0.0 and low_v >= 0.0 and high_u <= far[0] and high_v <= far[1]:
        widen(box, low_u, low_v)
        widen(box, high_u, high_v)
        return
    for edge in range(3):
        start, end = triangle[edge], triangle[(edge + 1) % 3]
        first, last = 0.0, 1.0
        for axis in range(2):
            along = end[axis] - start[axis]
            along = tolerances[0] if along == 0.0 else along
            enters, leaves = -start[axis] / along, (far[axis] - start[axis]) / along
            first = max(first, min(enters, leaves))
            last = min(last, max(enters, leaves))
        if first <= last:
            for share in (first, last):
                u = share * (end[0] - start[0]) + start[0]
                v = share * (end[1] - start[1]) + start[1]
                widen_inside(box, u, v, far, tolerances[1])
    for u in (0.0, far[0]):
        for v in (0.0, far[1]):
            if is_around(u, v, triangle):
                widen(box, u, v)


@kernel(F3, F1, F1, OUT2, allocates=False)
def enclose_triangles(triangles, far, tolerances, boxes):
    """Boxes (t, 4), so far inverted, around what triangles (t, 3, 2) cover of the image, pixels."""
    for row in range(len(triangles)):
        enclose_inside(boxes[row], triangles[row], far, tolerances)


@kernel(F3, I2, F2, F1, F1, OUT3, OUT2, OUT2, OUT1, allocates=False)
def extents(corners, parts, K, far, tolerances, pixels, boxes, clipped, farthest):
    """Where triangles' corners are seen, pixels (t, 3, 2), and boxes around parts of them.

    parts: rows (box, first triangle, last plus one). Widened are the boxes, those around what
    is inside the image, and the largest depths.
    """
    for row in range(len(corners)):
        for corner in range(3):
            x, y, z = corners[row, corner]
            for axis in range(2):
                pixels[row, corner, axis] = (K[axis, 0] * x + K[axis, 1] * y + K[axis, 2] * z) / z
    for part in range(len(parts)):
        box, first, end = parts[part]
        for row in range(first, end):
            for corner in range(3):
                widen(boxes[box], pixels[row, corner, 0], pixels[row, corner, 1])
                farthest[box] = max(farthest[box], corners[row, corner, 2])
    for part in range(len(parts)):
        box, first, end = parts[part]
        whole = boxes[box]
        if whole[0] >= 0.0 and whole[1] >= 0.0 and whole[2] <= far[0] and whole[3] <= far[1]:
            for edge in range(4):  # (the compiler takes seconds over a whole row)
                clipped[box, edge] = whole[edge]
        else:
            for row in range(first, end):
                enclose_inside(clipped[box], pixels[row], far, tolerances)


@inlined
def comes_close(low_u, low_v, high_u, high_v, box):
    """Whether an upright box comes within a pixel of another one."""
    across = low_u < box[2] + 1.0 and high_u > box[0] - 1.0
    return across and low_v < box[3] + 1.0 and high_v > box[1] - 1.0


@kernel(F3, F3, I2, F2, F1, OUT_B1, OUT1, allocates=False)
def mark_hiders(corners, pixels, parts, boxes, farthest, keep, over):
    """Which triangles of parts (as in `extents`) may hide something in boxes, up to these depths.

    over: a box, which is widened to hold them.
    """
    around, deepest = (inf, inf, -inf, -inf), -inf
    for box in range(len(boxes)):
        if farthest[box] > -inf:
            one = boxes[box]
            low = min(around[0], one[0], one[2]), min(around[1], one[1], one[3])
            high = max(around[2], one[0], one[2]), max(around[3], one[1], one[3])
            around, deepest = (*low, *high), max(deepest, farthest[box])
    for part in range(len(parts)):
        for row in range(parts[part, 1], parts[part, 2]):
            a, b, c = pixels[row, 0], pixels[row, 1], pixels[row, 2]
            low_u, high_u = min(a[0], b[0], c[0]), max(a[0], b[0], c[0])
            low_v, high_v = min(a[1], b[1], c[1]), max(a[1], b[1], c[1])
            nearest = min(corners[row, 0, 2], corners[row, 1, 2], corners[row, 2, 2])
            keep[row] = False
            if nearest < deepest and comes_close(low_u, low_v, high_u, high_v, around):
                for box in range(len(boxes)):
                    hides = nearest < farthest[box]
                    if hides and comes_close(low_u, low_v, high_u, high_v, boxes[box]):
                        keep[row] = True
                if keep[row]:
                    widen(over, low_u, low_v)
                    widen(over, high_u, high_v)
