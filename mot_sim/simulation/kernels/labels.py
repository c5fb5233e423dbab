"""What is nearest at each pixel, as labels; which triangles are seen, also through crowns."""

import numpy as np

from mot_sim.simulation.kernels.compiling import (
    F32_2,
    I32_1,
    OUT_F32_2,
    OUT_I32_2,
    OUT_U8_2,
    OUT_U32_1,
    U8_2,
)
from mot_sim.simulation.kernels.leaves import axes_in_row, cell_bits
from tracker.kernels.compiling import BOOL, F3, FLOAT, INT, OUT2, OUT_B1, inlined, kernel


@inlined
def put_behind(numbers, nearness, numbers_tufts, nearness_tufts):
    """Exchange tufts that are nearest with what is behind them; the others become -1.

    Gives whether there is any.
    """
    highest = np.int32(0)
    for column in range(len(numbers)):
        highest = max(highest, numbers_tufts[column])
    if highest == 0:
        return False
    for column in range(len(numbers)):
        number, near = numbers[column], nearness[column]
        tuft, near_tuft = numbers_tufts[column], nearness_tufts[column]
        is_nearest = near_tuft > near or (near_tuft == near and 0 < tuft < number)
        numbers[column] = tuft if is_nearest else number
        nearness[column] = near_tuft if is_nearest else near
        numbers_tufts[column] = number if is_nearest else np.int32(-1)
        nearness_tufts[column] = near
    return True


@inlined
def lay_row(numbers, nearness, plane, codes, ids, nobody, seen, depth, instances, semantics):
    """Write what is nearest in a row; semantic ids only where there is a triangle."""
    for column in range(len(numbers)):
        near = nearness[column]
        depth[column] = np.float32(1.0) / near if near > 0.0 else plane[column]
    for column in range(len(numbers)):
        triangle = numbers[column] - 1
        if triangle >= 0:
            semantics[column], instances[column] = codes[triangle, 3], ids[triangle]
            seen[triangle] = True
        else:
            instances[column] = nobody


@inlined
def open_row(
    numbers, nearness, behind, nearness_behind, row, objects, As_cell_ray, pixel, share, seen,
    depths, bits,
):  # fmt: skip
    """Show what is behind the gaps between the tufts of a row."""
    column = 0
    while column < len(numbers):
        if behind[column] < 0:
            column += 1
            continue
        thing, begun = objects[numbers[column] - 1], column
        while (
            column < len(numbers) and behind[column] >= 0 and objects[numbers[column] - 1] == thing
        ):
            column += 1
        near, axes = nearness[begun:column], axes_in_row(As_cell_ray[thing], row)
        cell_bits(near, begun, axes, pixel, depths[0], depths[1], bits)
        for each in range(len(near)):
            if np.int64((bits[each] >> np.uint32(16)) & np.uint32(255)) < share:
                other = behind[begun + each]
                numbers[begun + each] = other if other > 0 else np.int32(-1)
                near[each] = nearness_behind[begun + each]
                if other > 0:
                    seen[other - 1] = True


@kernel(
    OUT_I32_2, OUT_F32_2, OUT_I32_2, OUT_F32_2, F32_2, U8_2, I32_1, I32_1, INT, F3, FLOAT, INT,
    BOOL, OUT_B1, OUT_F32_2, OUT_I32_2, OUT_U8_2, OUT_I32_2, OUT2, OUT_U32_1, allocates=False,
)  # fmt: skip
def lay_labels(
    numbers, nearness, numbers_tufts, nearness_tufts, plane, codes, objects, ids, nobody,
    As_cell_ray, pixel, share, has_tufts, seen, depth, instances, semantics, spans, depths, bits,
):  # fmt: skip
    """Write depth, ids and semantic ids of the nearest triangles, then open the crowns, in place.

    plane: depth where there are none, nobody: the id; semantic ids are there already.
    numbers, nearness: the nearest triangles that are no tufts of leaves, 1 + row, and 1 / m, and
    those that are, if there are any; of equal depths the lower number is nearer. The first become
    those that are seen, also through the gaps between tufts; -1 where nothing is behind a gap; the
    second may become anything. As_cell_ray (n, 3, 4): see `renderers.materials`. share: of 256
    cells, how many are open. seen (t,): the triangles that are seen. spans (h, 2): of each row,
    the first column where the backdrop is seen, and the last one plus one. depths (2, w), bits (w):
    room.
    """
    for row in range(len(numbers)):
        found, near = numbers[row], nearness[row]
        behind, near_behind = numbers_tufts[row], nearness_tufts[row]
        is_leafy = has_tufts and put_behind(found, near, behind, near_behind)
        labels = depth[row], instances[row], semantics[row]
        lay_row(found, near, plane[row], codes, ids, nobody, seen, *labels)
        if is_leafy:
            open_row(
                found, near, behind, near_behind, row, objects, As_cell_ray, pixel, share, seen,
                depths, bits,
            )  # fmt: skip
        first, last = 0, len(found)
        while first < last and found[first] > 0:
            first += 1
        while last > first and found[last - 1] > 0:
            last -= 1
        spans[row, 0], spans[row, 1] = first, last
