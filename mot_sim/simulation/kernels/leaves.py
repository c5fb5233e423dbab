"""The cells of space, aslant to all faces, that crowns break into: leaves, and tufts of them."""

import numpy as np

from tracker.kernels.compiling import inlined

TUFT = 9  # as in `renderers.view.Material`
LEAF_METRES = 0.085  # of the finest leaves, or tufts of them
LEAF_PIXELS = 2.2  # that leaves are at least wide


@inlined
def mixed_bits(x, y, z):
    """32 random bits of a cell of space, the same on every processor."""
    bits = (x * 0x8DA6B343 ^ y * 0xD8163841 ^ z * 0xCB1AB31F) & 0xFFFFFFFF
    bits = ((bits ^ (bits >> 15)) * 0x2C1B3C6D) & 0xFFFFFFFF
    bits = ((bits ^ (bits >> 12)) * 0x297A2D39) & 0xFFFFFFFF
    return bits ^ (bits >> 15)


@inlined
def leaf_side(side, pixel):
    """How wide leaves are, metres: the finest, or twice, four times ..., as large as is seen.

    side: of the leaf beside; pixel: a pixel's width there, metres.
    """
    least = LEAF_PIXELS * pixel
    while side < least:
        side *= 2.0
    while side > LEAF_METRES and 0.5 * side >= least:
        side *= 0.5
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
def cell_bits(axes, column, depth, side):
    """The bits of the leaf's cell at a pixel's depth."""
    inverse = 1.0 / side
    x = depth * (axes[0][0] * column + axes[0][1]) + axes[0][2]
    y = depth * (axes[1][0] * column + axes[1][1]) + axes[1][2]
    z = depth * (axes[2][0] * column + axes[2][1]) + axes[2][2]
    return mixed_bits(
        np.int64(np.floor(x * inverse)),
        np.int64(np.floor(y * inverse)),
        np.int64(np.floor(z * inverse)),
    )
