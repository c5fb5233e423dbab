"""What pairs of tracks and detections cost: shares of areas, distances of looks."""

from math import cos, hypot, isfinite, nan, pi, sin

import numpy as np

from tracker.kernels.compiling import A1, A2, A_I1, F1, F2, F3, FLOAT, OUT1, inlined, kernel
from tracker.kernels.polygons import shared_areas


@inlined
def put_footprint(base, yaw, size, corners):
    """The bottom corners (4, 2) of a cuboid on the road plane, x and z, in one turning sense."""
    c, s = cos(yaw), sin(yaw)
    along, across = 0.5 * size[0], 0.5 * size[2]
    for corner in range(4):
        ahead = along if corner in (0, 3) else -along
        left = across if corner < 2 else -across
        corners[corner, 0] = base[0] + (ahead * c + left * s)
        corners[corner, 1] = base[2] + (left * c - ahead * s)


@kernel(A2, A1, A2, A2, A1, A2, A_I1, A_I1, OUT1)
def cost_of_volumes(
    base, yaw, size, seen_base, seen_yaw, seen_size, rows, columns, costs
):  # fmt: skip
    """1 - the share of the seen regions that the expected ones cover, pair by pair."""
    expected, seen = np.empty((len(rows), 4, 2)), np.empty((len(rows), 4, 2))
    for pair in range(len(rows)):
        row, column = rows[pair], columns[pair]
        put_footprint(base[row], yaw[row], size[row], expected[pair])
        put_footprint(seen_base[column], seen_yaw[column], seen_size[column], seen[pair])
    shared_areas(expected, seen, costs)
    for pair in range(len(rows)):
        column = columns[pair]
        share = costs[pair] / (seen_size[column, 0] * seen_size[column, 2])
        costs[pair] = 1.0 - (share if not share > 1.0 else 1.0)  # areas are off by a rounding


@inlined
def inside(box, far, edge):
    """An edge of a box, moved into the image."""
    return min(max(box[edge], 0.0), far[edge])


@kernel(F2, A2, F1, A_I1, A_I1, OUT1, allocates=False)
def cost_of_areas(areas, boxes, far, rows, columns, costs):
    """1 - the share of the boxes' parts inside the image that lies in the search areas."""
    for pair in range(len(rows)):
        area, box = areas[rows[pair]], boxes[columns[pair]]
        left, right = inside(box, far, 0), inside(box, far, 2)
        top, bottom = inside(box, far, 1), inside(box, far, 3)
        shared = max(min(area[2], right) - max(area[0], left), 0.0)
        shared *= max(min(area[3], bottom) - max(area[1], top), 0.0)
        costs[pair] = 1.0 - shared / (max(right - left, 0.0) * max(bottom - top, 0.0))


@kernel(A2, A2, A_I1, A_I1, OUT1, allocates=False)
def distance_of_boxes(expected, seen, rows, columns, distances):
    """d / (d + diagonal of the seen box) of the boxes' centres, pair by pair."""
    for pair in range(len(rows)):
        a, b = expected[rows[pair]], seen[columns[pair]]
        d = hypot(0.5 * (a[0] + a[2] - b[0] - b[2]), 0.5 * (a[1] + a[3] - b[1] - b[3]))
        distances[pair] = d / (d + hypot(b[2] - b[0], b[3] - b[1]))


@kernel(A2, A2, A_I1, A_I1, OUT1, allocates=False)
def square_distances(before, now, rows, columns, squares):
    """Squared distances of descriptors (n, d) and (m, d), pair by pair."""
    length = before.shape[1]
    for pair in range(len(rows)):
        a, b = before[rows[pair]], now[columns[pair]]
        even, odd = 0.0, 0.0  # two sums, since each waits for itself
        for place in range(0, length - 1, 2):
            even += (b[place] - a[place]) * (b[place] - a[place])
            odd += (b[place + 1] - a[place + 1]) * (b[place + 1] - a[place + 1])
        if length % 2:
            even += (b[length - 1] - a[length - 1]) ** 2
        squares[pair] = even + odd


@inlined
def eliminate(matrix, right, count):
    """Solve a system of so many equations in place, pivots by columns; the answer in `right`."""
    for step in range(count):
        best = step
        for row in range(step + 1, count):
            if abs(matrix[row, step]) > abs(matrix[best, step]):
                best = row
        if best != step:
            right[step], right[best] = right[best], right[step]
            for column in range(step, count):
                matrix[step, column], matrix[best, column] = (
                    matrix[best, column],
                    matrix[step, column],
                )
        for row in range(step + 1, count):
            factor = matrix[row, step] / matrix[step, step]
            right[row] -= factor * right[step]
            for column in range(step + 1, count):
                matrix[row, column] -= factor * matrix[step, column]
    for step in range(count - 1, -1, -1):
        for column in range(step + 1, count):
            right[step] -= matrix[step, column] * right[column]
        right[step] /= matrix[step, step]


@kernel(A2, A1, F3, A2, A1, F3, A_I1, A_I1, FLOAT, FLOAT, OUT1, OUT1)
def square_looks(
    shape, yaw, cov, now_shape, now_yaw, now_cov, rows, columns, shape_var, yaw_var, shapes, poses
):
    """Squared differences of shape and of pose in units of their variances, pair by pair.

    shape_var, yaw_var: what is added to variances. NaN where a shape or covariance is not known.
    """
    count = shape.shape[1]
    matrix, right, off = np.empty((count, count)), np.empty(count), np.empty(count)
    for pair in range(len(rows)):
        a, b, is_known = rows[pair], columns[pair], True
        for line in range(count + 1):
            for column in range(count + 1):
                total = cov[a, line, column] + now_cov[b, line, column]
                is_known = is_known and isfinite(total)
                if line > 0 and column > 0:
                    added = shape_var if line == column else 0.0
                    matrix[line - 1, column - 1] = total + added
        for line in range(count):
            off[line] = right[line] = now_shape[b, line] - shape[a, line]
            is_known = is_known and isfinite(off[line])
        shapes[pair] = nan
        if is_known:
            eliminate(matrix, right, count)
            shapes[pair] = 0.0
            for line in range(count):
                shapes[pair] += off[line] * right[line]
        angle = (now_yaw[b] - yaw[a] + pi) % (2.0 * pi) - pi
        poses[pair] = angle * angle / (cov[a, 0, 0] + now_cov[b, 0, 0] + yaw_var)
