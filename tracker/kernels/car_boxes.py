"""The boxes that cars fill in the image, with their derivatives by the state."""

from math import cos, exp, inf, isfinite, sin

import numpy as np

from tracker.kernels.compiling import (
    A2,
    BOOL,
    F2,
    FLOAT,
    I2,
    OUT2,
    OUT3,
    inlined,
    inlined_with_arrays,
    kernel,
)

# Corners nearer to the camera than this are taken to be this far, m.
MIN_CORNER_DEPTH = 0.5


@inlined
def car_axes(state):
    """Cosine and sine of the yaw; length, height, width of a car."""
    return cos(state[3]), sin(state[3]), exp(state[5]), exp(state[6]), exp(state[7])


@inlined
def put_corners(state, axes, P, signs, pixels):
    """Homogeneous pixels of the eight corners into `pixels` (8, 3)."""
    c, s, length, height, width = axes
    for row in range(3):
        centre = P[row, 0] * state[0] + P[row, 1] * state[1] + P[row, 2] * state[2] + P[row, 3]
        along = 0.5 * length * (c * P[row, 0] - s * P[row, 2])
        down = height * P[row, 1]
        across = 0.5 * width * (s * P[row, 0] + c * P[row, 2])
        for corner in range(8):
            pixels[corner, row] = centre + (
                signs[corner, 0] * along + signs[corner, 1] * down + signs[corner, 2] * across
            )


@inlined
def add_by_state(jacobian, gx, gy, gz, signs, axes):
    """Add the derivatives by the state of what depends so on a corner, per metre."""
    c, s, length, height, width = axes
    along, across = c * gx - s * gz, s * gx + c * gz
    by_length, by_width = signs[0] * (0.5 * length), signs[2] * (0.5 * width)
    jacobian[0] += gx
    jacobian[1] += gy
    jacobian[2] += gz
    jacobian[3] += by_width * along - by_length * across
    jacobian[5] += by_length * along
    jacobian[6] += signs[1] * height * gy
    jacobian[7] += by_width * across


@inlined
def add_by_pixel(jacobian, x, y, z, P, signs, axes):
    """The same of what depends so on the homogeneous pixel of a corner."""
    gx = x * P[0, 0] + y * P[1, 0] + z * P[2, 0]
    gy = x * P[0, 1] + y * P[1, 1] + z * P[2, 1]
    gz = x * P[0, 2] + y * P[1, 2] + z * P[2, 2]
    add_by_state(jacobian, gx, gy, gz, signs, axes)


@inlined
def put_edge(which, corner, edge, depth, P, signs, axes, jacobian):
    """The derivatives of an edge of the box, that of this corner."""
    row = which % 2
    gx = (P[row, 0] - edge * P[2, 0]) / depth
    gy = (P[row, 1] - edge * P[2, 1]) / depth
    gz = (P[row, 2] - edge * P[2, 2]) / depth
    jacobian[which] = 0.0
    add_by_state(jacobian[which], gx, gy, gz, signs[corner], axes)


@inlined
def inward_of(pixel, side, far_x):
    """How far a homogeneous pixel lies inside of the left (0) or right side, times its depth."""
    return pixel[0] if side == 0 else far_x * pixel[2] - pixel[0]


@inlined
def levels_inside(pixels, far_x, edges):
    """Highest and lowest row between the image's sides, and the points they are of.

    A point: a corner, or 8 + 12 x side + edge where an edge of the cuboid crosses a side. inf and
    -inf where nothing is seen there.
    """
    high, low, highest, lowest = inf, -inf, 0, 0
    for corner in range(8):
        pixel = pixels[corner]
        inside = pixel[0] > 0.0 and far_x * pixel[2] - pixel[0] > 0.0
        if inside and pixel[2] > MIN_CORNER_DEPTH:
            level = pixel[1] / pixel[2]
            if level < high:
                high, highest = level, corner
            if level > low:
                low, lowest = level, corner
    for side in range(2):
        for edge in range(len(edges)):
            first, second = pixels[edges[edge, 0]], pixels[edges[edge, 1]]
            a, b = inward_of(first, side, far_x), inward_of(second, side, far_x)
            if a * b < 0.0:
                share = a / (a - b)
                depth = first[2] + share * (second[2] - first[2])
                if depth > MIN_CORNER_DEPTH:
                    level = (first[1] + share * (second[1] - first[1])) / depth
                    point = 8 + len(edges) * side + edge
                    if level < high:
                        high, highest = level, point
                    if level > low:
                        low, lowest = level, point
    return high, low, highest, lowest


@inlined
def put_level(jacobian, level, point, pixels, far_x, edges, P, signs, axes):
    """The derivatives of a row between the image's sides, that of this point."""
    jacobian[:] = 0.0
    if point < 8:
        depth = pixels[point, 2]
        add_by_pixel(jacobian, 0.0, 1.0 / depth, -level / depth, P, signs[point], axes)
        return
    side, edge = (point - 8) // len(edges), (point - 8) % len(edges)
    one, two = edges[edge, 0], edges[edge, 1]
    first, second = pixels[one], pixels[two]
    a, b = inward_of(first, side, far_x), inward_of(second, side, far_x)
    share = a / (a - b)
    depth = first[2] + share * (second[2] - first[2])
    y, z = 1.0 / depth, -level / depth
    # along the edge, since the place where it crosses the side moves
    moves = (y * (second[1] - first[1]) + z * (second[2] - first[2])) / (a - b) ** 2
    nx, nz = (moves, 0.0) if side == 0 else (-moves, moves * far_x)
    rest = 1.0 - share
    add_by_pixel(jacobian, -b * nx, rest * y, rest * z - b * nz, P, signs[one], axes)
    add_by_pixel(jacobian, a * nx, share * y, share * z + a * nz, P, signs[two], axes)


@inlined
def put_box(state, P, far_x, signs, edges, pixels, box, jacobian, is_derived):
    """The upright box around a projected cuboid, and its derivatives if `is_derived`."""
    axes = car_axes(state)
    put_corners(state, axes, P, signs, pixels)
    left, top, right, bottom = 0, 0, 0, 0
    box[0] = box[1] = inf
    box[2] = box[3] = -inf
    for corner in range(8):
        depth = max(pixels[corner, 2], MIN_CORNER_DEPTH)
        u, v = pixels[corner, 0] / depth, pixels[corner, 1] / depth
        if u < box[0]:
            box[0], left = u, corner
        if v < box[1]:
            box[1], top = v, corner
        if u > box[2]:
            box[2], right = u, corner
        if v > box[3]:
            box[3], bottom = v, corner
    if is_derived:
        touched = (left, top, right, bottom)
        for which in range(4):
            corner = touched[which]
            depth = max(pixels[corner, 2], MIN_CORNER_DEPTH)
            put_edge(which, corner, box[which], depth, P, signs, axes, jacobian)
    if box[0] < 0.0 or box[2] > far_x:  # it reaches beyond the image's sides
        high, low, highest, lowest = levels_inside(pixels, far_x, edges)
        if isfinite(high) and isfinite(low):
            box[1], box[3] = high, low
            if is_derived:
                put_level(jacobian[1], high, highest, pixels, far_x, edges, P, signs, axes)
                put_level(jacobian[3], low, lowest, pixels, far_x, edges, P, signs, axes)


@kernel(F2, F2, FLOAT, F2, I2, OUT2, OUT3, BOOL)
def project_cars(states, P, far_x, signs, edges, boxes, jacobians, is_derived):
    """Boxes (h, 4) and Jacobians (h, 4, 9) of cars; of Jacobians none if not `is_derived`."""
    pixels = np.empty((8, 3))
    none = np.empty((4, 9))
    for car in range(len(states)):
        jacobian = jacobians[car] if is_derived else none
        put_box(states[car], P, far_x, signs, edges, pixels, boxes[car], jacobian, is_derived)


@inlined_with_arrays
def room_to_carry():
    """Arrays that `carry_in_room` writes to."""
    return np.empty((8, 3)), np.empty((4, 9)), np.empty(4), np.empty(4)


@inlined
def carry_in_room(boxes, before, after, P, far_x, signs, edges, max_growth, carried, room):
    """What `carry_boxes` does."""
    pixels, none, old, new = room
    for car in range(len(boxes)):
        put_box(before[car], P, far_x, signs, edges, pixels, old, none, False)
        put_box(after[car], P, far_x, signs, edges, pixels, new, none, False)
        for low in range(2):
            high = low + 2
            growth = (new[high] - new[low]) / max(old[high] - old[low], 1.0)
            growth = min(max(growth, 1.0 / max_growth), max_growth)
            off = boxes[car, low] + boxes[car, high] - old[low] - old[high]
            middle = 0.5 * (new[low] + new[high] + off * growth)
            half = 0.5 * (boxes[car, high] - boxes[car, low]) * growth
            carried[car, low], carried[car, high] = middle - half, middle + half


@kernel(A2, F2, F2, F2, FLOAT, F2, I2, FLOAT, OUT2)
def carry_boxes(boxes, before, after, P, far_x, signs, edges, max_growth, carried):
    """Boxes (n, 4) moved and scaled as the cuboids of their cars are, see `carried_boxes`."""
    room = room_to_carry()
    carry_in_room(boxes, before, after, P, far_x, signs, edges, max_growth, carried, room)
