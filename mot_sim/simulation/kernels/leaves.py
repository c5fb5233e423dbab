"""The cells of space, aslant to all faces, that crowns break into: leaves, and tufts of them."""

import numpy as np

from tracker.kernels.compiling import inlined

TUFT = 9  # as in `renderers.view.Material`
LEAF_METRES = 0.085  # of the finest leaves, or tufts of them
LEAF_PIXELS = 2.2  # that leaves are at least wide


@inlined
def mixed_bits(x, y, z):
    """32 random bits of a cell of space, by whole numbers; the same on every processor."""
    # (What is not named uint32 would be counted in 64 bits, at half the speed.)
    bits = np.uint32(np.uint32(x) * np.uint32(0x8DA6B343))
    bits ^= np.uint32(np.uint32(y) * np.uint32(0xD8163841))
    bits ^= np.uint32(np.uint32(z) * np.uint32(0xCB1AB31F))
    bits = np.uint32(np.uint32(bits ^ (bits >> np.uint32(15))) * np.uint32(0x2C1B3C6D))
    bits = np.uint32(np.uint32(bits ^ (bits >> np.uint32(12))) * np.uint32(0x297A2D39))
    return np.uint32(bits ^ (bits >> np.uint32(15)))


@inlined
def leaf_side(depth, pixel):
    """How wide leaves are, metres: the finest, or twice, four times ..., as large as is seen.

    pixel: a pixel's width at 1 m, metres.
    """
    side, least = LEAF_METRES, LEAF_PIXELS * pixel * depth
    while side < least:
        side *= 2.0
    return side


@inlined
def axes_in_row(cells, row):
    """How a row's columns lead to cells: by step and start, times depth, and where the eye is."""
    return (
        (cells[0, 0], cells[0, 1] * row + cells[0, 2], cells[0, 3]),
        (cells[1, 0], cells[1, 1] * row + cells[1, 2], cells[1, 3]),
        (cells[2, 0], cells[2, 1] * row + cells[2, 2], cells[2, 3]),
    )


@inlined
def cell_bits(near, begun, axes, pixel, depths, sides, bits):
    """Write the bits of the leaves' cells at a row's pixels from the column `begun` on.

    near: the inverse depths of as many. depths, sides: room. (Loops over views from 0 on are done
    for several pixels at once.)
    """
    nearest, farthest = np.float32(0.0), np.float32(np.inf)
    for each in range(len(near)):
        nearest, farthest = max(nearest, near[each]), min(farthest, near[each])
    side, largest = leaf_side(1.0 / nearest, pixel), leaf_side(1.0 / farthest, pixel)
    for each in range(len(near)):
        depths[each], sides[each] = 1.0 / np.float64(near[each]), side
    while side < largest:
        side *= 2.0
        for each in range(len(near)):
            is_larger = sides[each] < LEAF_PIXELS * pixel * depths[each]
            sides[each] = side if is_larger else sides[each]
    for each in range(len(near)):
        depth, column, inverse = depths[each], float(begun + each), 1.0 / sides[each]
        x = depth * (axes[0][0] * column + axes[0][1]) + axes[0][2]
        y = depth * (axes[1][0] * column + axes[1][1]) + axes[1][2]
        z = depth * (axes[2][0] * column + axes[2][1]) + axes[2][2]
        bits[each] = mixed_bits(
            np.int32(np.floor(x * inverse)),
            np.int32(np.floor(y * inverse)),
            np.int32(np.floor(z * inverse)),
        )
