"""What a camera's sensor makes of the light in a drawn frame, pixel by pixel."""

import numpy as np

from mot_sim.simulation.kernels.compiling import I8_2, OUT_I32_2, OUT_U8_2, U8_2, U32_1, U32_2
from tracker.kernels.compiling import INT, kernel


@kernel(U8_2, U32_2, U32_1, I8_2, INT, INT, OUT_I32_2, OUT_U8_2, allocates=False)
def develop_pixels(image, lens, curves, noise, top, left, room, seen):
    """Write what is seen of an image (h, 3 w): dimmed by the lens, through the curves, with noise.

    lens (h, w): what is left of the drawn levels, 65536 all. curves (3 n): of each colour, for the
    drawn levels 0, 1 / 4, 2 / 4, ...: the grey level in steps of 1 / 256, times 65536, and the
    noise's factor in steps of 1 / 4096. noise (., 3 .): a larger picture, of which the piece at
    (top, left) counts. room (2, 3 w): anything.
    """
    count = np.uint32(len(curves) // 3)
    half, none, most = np.int32(128), np.int32(0), np.int32(255)
    places, entries = room[0].view(np.uint32), room[1].view(np.uint32)
    for row in range(len(image)):
        drawn, through, result = image[row], lens[row], seen[row]
        grains = noise[top + row, 3 * left : 3 * left + len(drawn)]
        for column in range(len(through)):
            share = through[column]
            for band in range(3):
                places[3 * column + band] = share
        # (What is not named int32 would be counted in 64 bits, at half the speed.)
        for each in range(len(drawn)):
            light = np.uint32(np.uint32(np.uint32(drawn[each]) * places[each]) + np.uint32(8192))
            places[each] = light >> np.uint32(14)
        for column in range(len(through)):
            for band in range(3):
                entries[3 * column + band] = curves[band * count + places[3 * column + band]]
        for each in range(len(drawn)):
            entry = entries[each]
            grain = np.int32(np.int32(entry & np.uint32(65535)) * np.int32(grains[each]))
            level = np.int32(np.int32(entry >> np.uint32(16)) + half)
            level = np.int32(np.int32(level + np.int32(grain >> np.int32(4))) >> np.int32(8))
            result[each] = min(max(level, none), most)
