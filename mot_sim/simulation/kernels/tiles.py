"""The colours of a tile of the ground, mixed from what is painted on it and from noise."""

import numpy as np

from mot_sim.simulation.kernels.compiling import F32_2, OUT_F32_2, OUT_U32_2, U8_2, U32_2
from tracker.kernels.compiling import FLOAT, INT, inlined, kernel


@inlined
def drift_row(slow, shift, row, line, drifts):
    """Write the slow noise under a row, interpolated; line: room."""
    step, mask = np.float32(1.0) / np.float32(1 << shift), (1 << shift) - 1
    upper, lower = slow[row >> shift], slow[(row >> shift) + 1]
    down = np.float32(row & mask) * step
    for each in range(len(upper)):
        line[each] = upper[each] + down * (lower[each] - upper[each])
    for column in range(len(drifts)):
        left, right = np.uint32(column >> shift), np.float32(column & mask) * step
        drifts[column] = line[left] + right * (line[left + np.uint32(1)] - line[left])


@kernel(
    U32_2, U8_2, F32_2, U8_2, F32_2, F32_2, F32_2, INT, F32_2, FLOAT, OUT_F32_2, OUT_U32_2,
    allocates=False,
)  # fmt: skip
def mix_tile(weights, tone, slabs, shade, stones, blades, slow, shift, colours, wear, room, rgba):
    """Write the picture (t, t) of a tile, four bytes a texel; alpha is the weight of cars' ground.

    weights: of asphalt, pavement, kerb and line in each texel, a byte each, 255 all. tone: of the
    asphalt, 128 its own; slabs: of the pavement, 1 its own; shade: 255 no light. stones, blades:
    noise; slow: that of every so many texels, 1 << shift, and of the next one. colours (6, 3): of
    the four paints, grass and dry grass. wear: of lines, 0 to 1. room (9, t + 1): anything.
    """
    one, two55, half = np.float32(1.0), np.float32(1.0 / 255.0), np.float32(0.5)
    none, most, few = np.float32(0.0), np.float32(255.0), np.float32(0.85)
    loss, byte = np.float32(1.6 * wear - 2.6), np.uint32(255)
    size = len(rgba)
    asphalts, pavements, kerbs, lines = room[0, :size], room[1, :size], room[2, :size], room[3]
    greens, dries, light, drifts = room[4, :size], room[5, :size], room[6, :size], room[7, :size]
    # (Loops over whole rows, so that several texels are mixed at once.)
    for row in range(size):
        drift_row(slow, shift, row, room[8], drifts)
        paints, slab, dark, level = weights[row], slabs[row], shade[row], tone[row]
        grit, blade, mixed = stones[row], blades[row], rgba[row]
        for column in range(len(dark)):
            word = paints[column]
            asphalt = np.float32(np.int32(word & byte)) * two55
            pavement = np.float32(np.int32((word >> np.uint32(8)) & byte)) * two55
            kerb = np.float32(np.int32((word >> np.uint32(16)) & byte)) * two55
            line = np.float32(np.int32(word >> np.uint32(24))) * two55
            bare = one - min(asphalt + pavement + kerb + line, one)
            stone, drift = grit[column], drifts[column]
            worn = (stone + np.float32(0.9) * drift + loss) * np.float32(0.8)
            lost = line * min(max(worn, none), few)
            line, asphalt = line - lost, asphalt + lost
            asphalt *= np.float32(level[column]) * np.float32(1.0 / 128.0)
            asphalts[column] = asphalt * (one + np.float32(0.09) * stone + np.float32(0.08) * drift)
            pavements[column] = (
                pavement
                * slab[column]
                * (one + np.float32(0.05) * stone + np.float32(0.04) * drift)
            )
            gritty = one + np.float32(0.05) * stone
            kerbs[column], lines[column] = kerb * gritty, line * gritty
            grass = (one + np.float32(0.16) * blade[column]) * bare
            dry = min(max(np.float32(0.3) + np.float32(0.35) * drift, none), one) * grass
            greens[column], dries[column] = grass - dry, dry
            light[column] = one - np.float32(dark[column]) * two55
            # Alpha.
            drawn = max(word & byte, np.uint32(word >> np.uint32(24)))
            mixed[column] = np.uint32(drawn << np.uint32(24))
        for band in range(3):
            a, b, c, d = colours[0, band], colours[1, band], colours[2, band], colours[3, band]
            e, f, place = colours[4, band], colours[5, band], np.uint32(8 * band)
            for column in range(len(dark)):
                value = asphalts[column] * a + pavements[column] * b + kerbs[column] * c
                value += lines[column] * d + greens[column] * e + dries[column] * f
                value = min(abs(value * light[column]) + half, most)  # as OpenCV scales pictures
                mixed[column] |= np.uint32(np.uint32(np.int32(value)) << place)
