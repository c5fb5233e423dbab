"""Light that the air takes and adds, pixel by pixel."""

import numpy as np

from mot_sim.simulation.kernels.compiling import (
    F32_2,
    OUT_F32_1,
    OUT_I32_2,
    OUT_U8_2,
    U8_2,
)
from tracker.kernels.compiling import F1, FLOAT, kernel

MOST_AIR = 12.0  # extinctions: of the light 6e-6 are left


@kernel(
    U8_2, F32_2, F32_2, F32_2, FLOAT, F1, OUT_F32_1, OUT_I32_2, OUT_U8_2, allocates=False
)  # fmt: skip
def dim_and_add(image, depth, farthest, lens, extinction, colour, room, counts, seen):
    """Write what is seen of an image (h, 3 w) through so much air, and through the lens.

    depth, farthest: metres, the smaller one counts. lens: what it lets through, 0 to 1. Of the
    light exp(-extinction) is left after a metre of air, whose own colour, below 512, fills that
    up. Both are rounded to grey levels before they are added. room (w), counts (2, 3 w): anything.
    """
    white, none, half = np.float32(255.0), np.float32(0.0), np.float32(0.5)
    loss, most, one = np.float32(extinction / 64.0), np.float32(MOST_AIR / 64.0), np.float32(1.0)
    third = np.float32(1.0 / 3.0)
    whole, eight, byte = np.float32(65535.0), np.int32(8), np.int32(255)
    middle, round_up = np.int32(128), np.int32(1 << 21)
    left, both, airs = room, counts[0], counts[1]
    for each in range(len(airs)):
        airs[each] = np.int32(64.0 * colour[each % 3] + 0.5)
    for row in range(len(image)):
        deep, far, through = depth[row], farthest[row], lens[row]
        for column in range(len(deep)):
            # The 64th power of exp(-x / 64), which four terms give to a millionth, by products
            # alone: the same bits everywhere.
            x = min(min(deep[column], far[column]) * loss, most)
            power = one - x * (one - half * x * (one - third * x))
            power *= power
            power *= power
            power *= power
            power *= power
            power *= power
            power *= power
            left[column] = power * through[column]
        for column in range(len(deep)):
            share = np.int32(min(max(left[column] * white, none), white) + half)
            added = np.int32(min(abs(through[column] - left[column]) * whole + half, whole))
            word = np.int32(np.int32(added << eight) + share)
            for band in range(3):
                both[3 * column + band] = word
        # (What is not named int32 would be counted in 64 bits, at half the speed.)
        drawn, result = image[row], seen[row]
        for each in range(len(drawn)):
            light = np.int32(np.int32(np.int32(drawn[each]) * np.int32(both[each] & byte)) + middle)
            light = np.int32(np.int32(light + np.int32(light >> eight)) >> eight)  # by 255, rounded
            own = np.int32(np.int32(both[each] >> eight) * airs[each])
            own = min(np.int32(np.int32(own + round_up) >> np.int32(22)), byte)
            result[each] = min(np.int32(light + own), byte)
