"""The colours of a tile of the ground, mixed from what is painted on it and from noise."""

import numpy as np

from mot_sim.simulation.kernels.compiling import F32_2, OUT_F32_2, OUT_U8_2, U8_2
from tracker.kernels.compiling import FLOAT, kernel


@kernel(
    U8_2, U8_2, F32_2, U8_2, F32_2, F32_2, F32_2, F32_2, FLOAT, OUT_F32_2, OUT_U8_2,
    allocates=False,
)  # fmt: skip
def mix_tile(weights, tone, slabs, shade, stones, blades, slow, colours, wear, room, rgba):
    """Write the picture (t, 4 t) of a tile; alpha is the weight of what cars drive on.

    weights: of asphalt, pavement, kerb and line in each texel, 255 all. tone: of the asphalt, 128
    its own; slabs: of the pavement, 1 its own; shade: 255 no light. stones, blades, slow: noise.
    colours (6, 3): of the four paints, grass and dry grass. wear: of lines, 0 to 1. room (7, t):
    anything.
    """
    one, two55, half = np.float32(1.0), np.float32(1.0 / 255.0), np.float32(0.5)
    none, most, few = np.float32(0.0), np.float32(255.0), np.float32(0.85)
    loss = np.float32(1.6 * wear - 2.6)
    asphalts, pavements, kerbs, lines = room[0], room[1], room[2], room[3]
    greens, dries, light = room[4], room[5], room[6]
    # (Loops over whole rows, so that several texels are mixed at once.)
    for row in range(len(rgba)):
        paints, slab, dark, level = weights[row], slabs[row], shade[row], tone[row]
        grit, blade, drifts, mixed = stones[row], blades[row], slow[row], rgba[row]
        for column in range(len(dark)):
            asphalts[column] = np.float32(paints[4 * column]) * two55
            pavements[column] = np.float32(paints[4 * column + 1]) * two55
            kerbs[column] = np.float32(paints[4 * column + 2]) * two55
            lines[column] = np.float32(paints[4 * column + 3]) * two55
        for column in range(len(dark)):
            asphalt, pavement, kerb, line = (
                asphalts[column], pavements[column], kerbs[column], lines[column]
            )  # fmt: skip
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
        for band in range(3):
            a, b, c, d = colours[0, band], colours[1, band], colours[2, band], colours[3, band]
            e, f = colours[4, band], colours[5, band]
            for column in range(len(dark)):
                value = asphalts[column] * a + pavements[column] * b + kerbs[column] * c
                value += lines[column] * d + greens[column] * e + dries[column] * f
                value = abs(value * light[column])  # as OpenCV scales pictures
                mixed[4 * column + band] = np.uint8(np.int32(min(value + half, most)))
        for column in range(len(dark)):
            mixed[4 * column + 3] = max(paints[4 * column], paints[4 * column + 3])
