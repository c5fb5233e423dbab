"""What a camera's sensor makes of the light in a drawn frame, pixel by pixel."""

import numpy as np

from mot_sim.simulation.kernels.compiling import I8_3, OUT_U8_3, U8_3, U32_2
from tracker.kernels.compiling import INT, kernel


@kernel(U8_3, U32_2, U32_2, I8_3, INT, INT, OUT_U8_3)
def develop_pixels(image, lens, curves, noise, top, left, seen):
    """Write what is seen of an image: dimmed by the lens, through the curves, with noise.

    lens: what is left of the drawn levels, 65536 all. curves (3, n): of each colour, for the drawn
    levels 0, 1 / 4, 2 / 4, ...: the grey level in steps of 1 / 256, times 65536, and the noise's
    factor in steps of 1 / 4096. noise: a larger picture, of which the piece at (top, left) counts.
    """
    for row in range(image.shape[0]):
        for column in range(image.shape[1]):
            through = lens[row, column]
            for band in range(3):
                at = np.uint32(np.uint32(image[row, column, band]) * through + np.uint32(8192))
                entry = curves[band, at >> np.uint32(14)]
                level = np.int32(entry >> np.uint32(16)) + np.int32(128)
                grain = np.int32(noise[top + row, left + column, band])
                level += (np.int32(entry & np.uint32(65535)) * grain) >> np.int32(4)
                seen[row, column, band] = min(max(level >> np.int32(8), np.int32(0)), np.int32(255))
