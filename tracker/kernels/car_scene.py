"""What boxes of cars tell beside their hypotheses: edges that tell nothing, the road under them."""

from math import hypot, log

from tracker.kernels.compiling import (
    A1,
    A2,
    B1,
    B2,
    F1,
    F2,
    FLOAT,
    OUT1,
    OUT2,
    OUT_B1,
    OUT_B2,
    inlined,
    kernel,
)  # fmt: skip


@inlined
def mark_hidden(box, other, least_share, margin_share, hidden):
    """Mark the edges of a box that lie behind another one."""
    for edge in range(4):
        along = 1 - edge % 2  # an upright edge is covered in y, a level one in x
        size = max(box[along + 2] - box[along], 1.0)
        shared = min(box[along + 2], other[along + 2]) - max(box[along], other[along])
        margin = margin_share * max(box[3] - box[1], 1.0)
        low, high = other[edge % 2] - margin, other[edge % 2 + 2] + margin
        if low < box[edge] < high and shared / size > least_share[edge]:
            hidden[edge] = True


@kernel(A2, A2, FLOAT, F1, FLOAT, OUT_B2)
def hide_edges(boxes, others, min_lower, least_share, margin_share, hidden):
    """Which edges of boxes (n, 4) lie behind one of the others (m, 4) that ends lower."""
    for car in range(len(boxes)):
        hidden[car] = False
        for nearer in range(len(others)):
            if others[nearer, 3] > boxes[car, 3] + min_lower:
                mark_hidden(boxes[car], others[nearer], least_share, margin_share, hidden[car])


@kernel(A2, A1, B2, F1, F1, FLOAT, FLOAT, OUT2, OUT2)
def weigh_edges_of_boxes(
    boxes, scores, hidden, bias, hidden_factors, edge_std, pixel_std, unbiased, variances
):
    """Boxes (n, 4) without the detector's bias, and the variances of their edges, px^2."""
    for car in range(len(boxes)):
        height = boxes[car, 3] - boxes[car, 1]
        for edge in range(4):
            unbiased[car, edge] = boxes[car, edge] - bias[edge] * height
        height = max(unbiased[car, 3] - unbiased[car, 1], 1.0)
        std = edge_std * height * (2.0 - min(max(scores[car], 0.0), 1.0))
        for edge in range(4):
            variances[car, edge] = std**2 + pixel_std**2
            if hidden[car, edge]:
                variances[car, edge] *= hidden_factors[edge] ** 2


@kernel(A2, A1, B2, F2, F1, FLOAT, F1, FLOAT, FLOAT, OUT1, OUT1, OUT_B1)
def place_bases(
    boxes, scores, hidden, per_pixel, at_origin, focal, far, min_gap, min_score,
    fall, reach, is_usable,
):  # fmt: skip
    """Where bases of cars seem to be, per metre of their height, see `SeenBases`."""
    for car in range(len(boxes)):
        depth = focal / max(boxes[car, 3] - boxes[car, 1], 1.0)
        u, v = 0.5 * boxes[car, 0] + 0.5 * boxes[car, 2], boxes[car, 3]
        fall[car] = (u * per_pixel[0, 1] + v * per_pixel[1, 1] + at_origin[1]) * depth
        x = (u * per_pixel[0, 0] + v * per_pixel[1, 0] + at_origin[0]) * depth
        z = (u * per_pixel[0, 2] + v * per_pixel[1, 2] + at_origin[2]) * depth
        reach[car] = hypot(x, z)
        gap = min(boxes[car, 0], boxes[car, 1], far[2] - boxes[car, 2], far[3] - boxes[car, 3])
        is_whole = gap > min_gap and not (hidden[car, 1] or hidden[car, 3])
        is_usable[car] = is_whole and scores[car] > min_score


@kernel(F1, F1, B1, FLOAT, A1, FLOAT, FLOAT, FLOAT, FLOAT)
def sum_slopes(
    fall, reach, is_usable, camera_height, heights, min_distance, base_std, residual_std, repetition
):
    """Information on the road's slope, and its product with the slope that each car tells."""
    information = weighted = 0.0
    for car in range(len(fall)):
        distance = reach[car] * heights[car]
        if is_usable[car] and distance > min_distance:
            below = fall[car] * heights[car] - camera_height
            told = 1.0 / (repetition * ((base_std / distance) ** 2 + residual_std**2))
            information += told
            weighted += told * below / distance
    return information, weighted


@kernel(F1, F1, B1, FLOAT, FLOAT, FLOAT, FLOAT, FLOAT, FLOAT)
def sum_flatness(
    fall, reach, is_usable, camera_height, height, min_distance, flat_std, rough_std, max_deviation
):
    """Twice how much likelier bases of cars of one height are on a flat road, nats."""
    told, most = 0.0, max_deviation**2
    for car in range(len(fall)):
        distance = reach[car] * height
        if is_usable[car] and distance > min_distance:
            square = (fall[car] * height - camera_height) ** 2
            flat = flat_std**2
            rough = flat + (rough_std * distance) ** 2
            told += log(rough / flat) + min(square / rough, most) - min(square / flat, most)
    return told
