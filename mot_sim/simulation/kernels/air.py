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
    white, none, half = np.float32(255.0), np.float32(0.0), np.int32(128)
    red, green, blue = np.float32(colour[0]), np.float32(colour[1]), np.float32(colour[2])
    for row in range(image.shape[0]):
        for column in range(image.shape[1]):
            through = left[row, column]
            share = np.int32(np.rint(min(max(through * white, none), white)))
            added = abs(whole[row, column] - through)
            for band in range(3):
                air = red if band == 0 else (green if band == 1 else blue)
                light = np.int32(image[row, column, band]) * share + half
                light = (light + (light >> np.int32(8))) >> np.int32(8)  # by 255, rounded
                own = np.int32(np.rint(min(added * air, white)))
                seen[row, column, band] = np.uint8(min(light + own, np.int32(255)))
