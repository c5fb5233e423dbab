"""Light that the air takes and adds, pixel by pixel."""

import numpy as np

from mot_sim.simulation.kernels.compiling import F32_2, OUT_U8_3, U8_3
from tracker.kernels.compiling import F1, kernel


@kernel(U8_3, F32_2, F32_2, F1, OUT_U8_3)
def dim_and_add(image, left, whole, colour, seen):
    """Write what is seen of an image through air that leaves `left` of the light, 0 to 1.

    The air's own colour fills that up to `whole`, what the lens lets through. Both are rounded to
    grey levels before they are added.
    """
    one, two = np.float32(255.0), np.float32(0.0)
    for row in range(image.shape[0]):
        for column in range(image.shape[1]):
            share = np.int64(np.rint(min(max(left[row, column] * one, two), one)))
            added = whole[row, column] - left[row, column]
            for band in range(3):
                light = (2 * np.int64(image[row, column, band]) * share + 255) // 510
                own = np.rint(min(abs(added * np.float32(colour[band])), one))
                seen[row, column, band] = min(light + np.int64(own), 255)
