"""Search areas, the pairs inside them, overlaps, and which boxes are kept beside others."""

from math import cos, inf, sin, sqrt

import numpy as np

from tracker.kernels.compiling import (
    A1,
    A2,
    A_I1,
    F1,
    F2,
    F3,
    FLOAT,
    I1,
    OUT1,
    OUT2,
    OUT_I1,
    OUT_I2,
    inlined,
    inlined_with_arrays,
    kernel,
)


@kernel(A1, A2, F3, FLOAT, OUT2)
def stretch(yaw, size, covs, sigmas, stretched):
    """Sizes (n, 3) that are larger by so many standard deviations of the places."""
    for car in range(len(yaw)):
        c, s = cos(yaw[car]), sin(yaw[car])
        xx, zz = covs[car, 0, 0], covs[car, 1, 1]
        along = c * (c * xx - 2.0 * s * covs[car, 0, 1]) + s * s * zz
        across = xx + zz - along  # a covariance's trace does not turn
        stretched[car, 0] = size[car, 0] + 2.0 * sigmas * sqrt(max(along, 0.0))
        stretched[car, 1] = size[car, 1]
        stretched[car, 2] = size[car, 2] + 2.0 * sigmas * sqrt(max(across, 0.0))


@kernel(A2, A1, A2, F2, F1, F1, F2, FLOAT, FLOAT, OUT2)
def box_cuboids(base, yaw, size, P, centre, far, signs, min_corner_depth, min_depth, boxes):
    """The upright boxes around projected cuboids, clipped to the image, see `project_cuboids`."""
    half, at = np.empty((3, 3)), np.empty(3)  # homogeneous pixels of half axes, of the base
    for car in range(len(base)):
        c, s = cos(yaw[car]), sin(yaw[car])
        for row in range(3):
            half[0, row] = 0.5 * size[car, 0] * (c * P[row, 0] - s * P[row, 2])
            half[1, row] = size[car, 1] * P[row, 1]
            half[2, row] = 0.5 * size[car, 2] * (s * P[row, 0] + c * P[row, 2])
            at[row] = base[car, 0] * P[row, 0] + base[car, 1] * P[row, 1] + base[car, 2] * P[row, 2]
            at[row] += P[row, 3]
        deepest = -inf
        for edge in range(4):
            boxes[car, edge] = inf if edge < 2 else -inf
        for corner in range(8):
            a, b, d = signs[corner, 0], signs[corner, 1], signs[corner, 2]
            depth = at[2] + (a * half[0, 2] + b * half[1, 2] + d * half[2, 2])
            deepest = max(deepest, depth)
            for row in range(2):
                pixel = at[row] + (a * half[0, row] + b * half[1, row] + d * half[2, row])
                pixel = pixel / max(depth, min_corner_depth) + centre[row]
                boxes[car, row] = min(boxes[car, row], pixel)
                boxes[car, 2 + row] = max(boxes[car, 2 + row], pixel)
        for edge in range(4):
            boxes[car, edge] = min(max(boxes[car, edge], 0.0), far[edge])
            if deepest < min_depth:
                boxes[car, edge] = 0.0


@inlined
def share_area(a, b):
    """Whether two boxes share area."""
    return (
        min(a[2], b[2]) > max(a[0], b[0])
        and min(a[3], b[3]) > max(a[1], b[1])
    )  # fmt: skip


@kernel(
    A2, A1, A2, F3, FLOAT, F2, F1, F1, F2, FLOAT, FLOAT, A2, I1, I1, OUT2, OUT2, OUT_I1, OUT_I1
)  # fmt: skip
def gate(
    base, yaw, size, covs, sigmas, P, centre, far, signs, min_corner_depth, min_depth, seen,
    starts, seen_starts, stretched, areas, rows, columns,
):  # fmt: skip
    """Regions and search areas of beliefs, and the pairs of these and boxes seen (m, 4) that meet.

    starts, seen_starts: where the rows and boxes of each drive begin. Gives how many pairs there
    are.
    """
    stretch(yaw, size, covs, sigmas, stretched)
    box_cuboids(base, yaw, stretched, P, centre, far, signs, min_corner_depth, min_depth, areas)
    count = 0
    for drive in range(len(starts) - 1):
        for row in range(starts[drive], starts[drive + 1]):
            for column in range(seen_starts[drive], seen_starts[drive + 1]):
                if share_area(areas[row], seen[column]):
                    rows[count], columns[count] = row, column
                    count += 1
    return count


@inlined
def overlap(a, b, fraction, min_area):
    """IoU of two boxes, both widened by a fraction of their sides."""
    shared, one, other = 1.0, 1.0, 1.0
    for axis in range(2):
        wide, beside = fraction * (a[axis + 2] - a[axis]), fraction * (b[axis + 2] - b[axis])
        low, low_beside = a[axis] - wide, b[axis] - beside
        high, high_beside = a[axis + 2] + wide, b[axis + 2] + beside
        shared *= max(min(high, high_beside) - max(low, low_beside), 0.0)
        one *= max(high - low, 0.0)
        other *= max(high_beside - low_beside, 0.0)
    return shared / max(one + other - shared, min_area)


@kernel(A2, A2, A_I1, A_I1, FLOAT, FLOAT, OUT1)
def cost_of_overlaps(a, b, rows, columns, fraction, min_area, costs):
    """1 - IoU of the boxes of these pairs."""
    for pair in range(len(rows)):
        costs[pair] = 1.0 - overlap(a[rows[pair]], b[columns[pair]], fraction, min_area)


@inlined
def has_area_inside(box, far):
    """Whether the part of a box inside the image has area."""
    wide = min(max(box[2], 0.0), far[2]) > min(max(box[0], 0.0), far[0])
    return wide and min(max(box[3], 0.0), far[3]) > min(max(box[1], 0.0), far[1])


@inlined
def is_close(box, other, limit):
    """Whether the IoU of two boxes is larger than a limit."""
    shared, one, two = 1.0, 1.0, 1.0
    for axis in range(2):
        side = min(box[axis + 2], other[axis + 2]) - max(box[axis], other[axis])
        shared *= max(side, 0.0)
        one *= max(box[axis + 2] - box[axis], 0.0)
        two *= max(other[axis + 2] - other[axis], 0.0)
    return (1.0 + limit) * shared > limit * (one + two)  # shared > limit (both - shared)


@inlined_with_arrays
def from_highest(scores):
    """Rows by falling scores; the earlier row first where two are equal."""
    order = np.empty(len(scores), np.int64)
    for row in range(len(scores)):
        at = row
        while at > 0 and scores[order[at - 1]] < scores[row]:
            order[at] = order[at - 1]
            at -= 1
        order[at] = row
    return order


@kernel(A2, A1, F1, FLOAT, FLOAT, FLOAT, FLOAT, OUT_I1)
def suppress_boxes(boxes, scores, far, min_score, max_iou, max_iou_of_sure, sure_score, rows):
    """The rows of boxes that are kept, ascending, see `Suppression`; how many."""
    kept, count = np.empty(len(boxes), np.bool_), 0
    for row in range(len(boxes)):
        kept[row] = scores[row] >= min_score and has_area_inside(boxes[row], far)
    for row in from_highest(scores):
        if kept[row]:
            for other in range(len(boxes)):
                if kept[other] and other != row:
                    is_sure = scores[other] >= sure_score or scores[row] == scores[other]
                    limit = max_iou_of_sure if is_sure else max_iou
                    kept[other] = not is_close(boxes[row], boxes[other], limit)
    for row in range(len(boxes)):
        if kept[row]:
            rows[count] = row
            count += 1
    return count


@kernel(A2, FLOAT, OUT_I2, OUT_I1, OUT_I1)
def pair_clearly(costs, max_cost, pairs, lost, new):
    """Each row with its cheapest column, if no two rows want the same; else -1.

    That is then the optimal match, the only one. pairs: rows and columns that cost less than
    `max_cost`. lost, new: the rows and the columns that are left. Gives how many pairs there are;
    -1 also where a row has two cheapest columns, or costs are no numbers.
    """
    count = 0
    for column in range(costs.shape[1]):
        new[column] = 0
    for row in range(costs.shape[0]):
        best, least, is_tied = -1, 0.0, False
        for column in range(costs.shape[1]):
            gain = costs[row, column] - max_cost
            if not gain > -inf:
                return -1
            if gain < least:
                best, least, is_tied = column, gain, False
            elif gain == least and best >= 0:
                is_tied = True
        if best < 0:
            lost[row - count] = row
        elif is_tied or new[best] > 0:
            return -1
        else:
            pairs[0, count], pairs[1, count] = row, best
            new[best] = 1
            count += 1
    left = 0
    for column in range(costs.shape[1]):
        if new[column] == 0:
            new[left] = column
            left += 1
    return count
