"""Objects drawn alone, laid over one another, and what their pixels say."""

from math import floor

import numpy as np

from mot_sim.simulation.kernels.compiling import (
    F32_1,
    I32_2,
    OUT_F32_1,
    OUT_F32_2,
    OUT_I32_2,
    OUT_U8_2,
)
from mot_sim.simulation.kernels.filling import fill_triangle
from tracker.kernels.compiling import (
    B1,
    B2,
    F2,
    F3,
    FLOAT,
    I1,
    I2,
    OUT2,
    OUT_B2,
    OUT_I1,
    OUT_I2,
    inlined,
    kernel,
)


@inlined
def place_in(starts, boxes, layer, row, column):
    """Where a pixel of the image stands among the crops' nearness, in a layer that holds it."""
    box = boxes[layer]
    return starts[layer] + (row - box[1]) * (box[2] - box[0]) + column - box[0]


@kernel(F3, B1, I2, F2, I2, I1, OUT_F32_1, OUT_F32_2, OUT_I32_2, allocates=False)
def draw_layers(corners, keep, parts, K, boxes, starts, alone, nearness, numbers):
    """Draw each layer alone, in its crop, and lay the crops over one another.

    parts: rows (layer, first triangle, last plus one), by layer; of their triangles those of `keep`
    are drawn. boxes (k, 4): first column and row, last ones plus one, of the crops. alone: the
    crops' nearness, 1 / m, layer after layer from `starts` on, and PIXELS more, as in `filling`.
    nearness and numbers, of the image, are so far 0 and become those of the nearest layer, 1 + its
    row, the first of equally near ones.
    """
    part = 0
    for layer in range(len(boxes)):
        left, top, right, bottom = boxes[layer]
        box = left, top, right, bottom
        rows, columns = max(bottom - top, 0), max(right - left, 0)
        crop = alone[starts[layer] : starts[layer] + rows * columns].reshape((rows, columns))
        crop[:] = 0.0
        while part < len(parts) and parts[part, 0] == layer:
            for row in range(parts[part, 1], parts[part, 2]):
                if keep[row] and crop.size:
                    fill_triangle(corners[row], K, box, starts[layer], alone, None, 0)
            part += 1
        number = np.int32(layer + 1)
        for row in range(rows):
            own, near = crop[row], nearness[top + row, left:right]
            found = numbers[top + row, left:right]
            for column in range(len(own)):
                is_nearer = own[column] > near[column]
                near[column] = own[column] if is_nearer else near[column]
                found[column] = number if is_nearer else found[column]


@kernel(F32_1, I1, I2, I32_2, OUT_I1, OUT_I1, OUT2, OUT_I2, allocates=False)
def measure_layers(alone, starts, boxes, numbers, whole, visible, visible_boxes, hidden):
    """Count the pixels of layers 1 on: all, those seen and their box, and who hides the rest.

    hidden (k, k): pixels of the first that show the second. All are so far 0, the boxes inverted.
    """
    for layer in range(1, len(boxes)):
        left, top, right, bottom = boxes[layer]
        at = starts[layer]
        for row in range(top, bottom):
            for column in range(left, right):
                if alone[at] > 0.0:
                    whole[layer] += 1
                    shown = numbers[row, column] - 1
                    if shown == layer:
                        visible[layer] += 1
                        box = visible_boxes[layer]
                        box[0], box[1] = min(box[0], column), min(box[1], row)
                        box[2], box[3] = max(box[2], column), max(box[3], row)
                    else:
                        hidden[layer, shown] += 1
                at += 1


@inlined
def is_behind(alone, starts, boxes, layer, u, v, depth):
    """Whether all that a layer shows in the nine pixels around one is nearer than a depth."""
    box, deepest = boxes[layer], np.float32(0.0)
    for row in range(max(v - 1, box[1]), min(v + 2, box[3])):
        for column in range(max(u - 1, box[0]), min(u + 2, box[2])):
            near = alone[place_in(starts, boxes, layer, row, column)]
            if near > 0.0:
                deepest = max(deepest, np.float32(1.0) / near)
    return 0.0 < deepest < depth


@kernel(
    F3, B2, I1, F2, FLOAT, F32_1, I1, I2, I32_2, FLOAT, FLOAT, OUT_U8_2, allocates=False
)  # fmt: skip
def judge_keypoints(
    points_cam, faces_us, layers, K, near, alone, starts, boxes, numbers, thickness, slant, states
):
    """Whether points (n, k, 3) of cars are seen (0), or hidden by their own car (1) or others (2).

    3: outside the image, or not past the near plane. faces_us: whether a point lies on a face that
    looks at the camera. layers: those of the cars. A car's own surface hides a point that lies
    more than thickness, m, and slant, shares of its depth, behind it.
    """
    height, width = numbers.shape
    for car in range(len(points_cam)):
        layer = layers[car]
        for point in range(points_cam.shape[1]):
            x, y, z = points_cam[car, point]
            states[car, point] = 3
            if not z > near:
                continue
            u = floor((K[0, 0] * x + K[0, 1] * y + K[0, 2] * z) / z + 0.5)
            v = floor((K[1, 0] * x + K[1, 1] * y + K[1, 2] * z) / z + 0.5)
            if not (0 <= u < width and 0 <= v < height):
                continue
            column, row = int(u), int(v)
            shown = numbers[row, column]
            states[car, point] = 2 if shown > 0 and shown != layer + 1 else 0
            depth = z - (thickness + slant * z)
            if not faces_us[car, point] or is_behind(
                alone, starts, boxes, layer, column, row, depth
            ):
                states[car, point] = 1


@kernel(F3, I1, F2, I1, OUT_B2, allocates=False)
def look_at_eyes(planes, cars, eyes, starts, facing):
    """Whether any face around each keypoint looks at the eye (n, 3) of a car.

    planes (m, p, 4): of the faces of all cars, normals and how far along them. cars: which of them.
    starts: where the faces of each keypoint begin, and the last ones end.
    """
    for row in range(len(cars)):
        x, y, z = eyes[row, 0], eyes[row, 1], eyes[row, 2]
        for point in range(len(starts) - 1):
            facing[row, point] = False
            for face in range(starts[point], starts[point + 1]):
                plane = planes[cars[row], face]
                if plane[0] * x + plane[1] * y + plane[2] * z > plane[3]:
                    facing[row, point] = True
                    break
