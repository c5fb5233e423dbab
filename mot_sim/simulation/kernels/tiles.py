"""The colours of a tile of the ground, mixed from what is painted on it and from noise."""

import numpy as np

from mot_sim.simulation.kernels.compiling import A32_2, F32_2, OUT_U8_3, U8_2, U8_3
from tracker.kernels.compiling import FLOAT, kernel


@kernel(U8_3, U8_2, F32_2, U8_2, A32_2, A32_2, A32_2, F32_2, FLOAT, OUT_U8_3)
def mix_tile(weights, tone, slabs, shade, stones, blades, slow, colours, wear, rgba):
    """Write the picture (t, t, 4) of a tile; alpha is the weight of what cars drive on.

    weights: of asphalt, pavement, kerb and line in each texel, 255 all. tone: of the asphalt, 128
    its own; slabs: of the pavement, 1 its own; shade: 255 no light. stones, blades, slow: noise.
    colours (6, 3): of the four paints, grass and dry grass. wear: of lines, 0 to 1.
    """
    one, two55, half = np.float32(1.0), np.float32(1.0 / 255.0), np.float32(0.5)
    loss = np.float32(1.6 * wear - 2.6)
    for row in range(rgba.shape[0]):
        for column in range(rgba.shape[1]):
            asphalt = np.float32(weights[row, column, 0]) * two55
            line = np.float32(weights[row, column, 3]) * two55
            stone, drift = stones[row, column], slow[row, column]
            worn = (stone + np.float32(0.9) * drift + loss) * np.float32(0.8)
            lost = line * min(max(worn, np.float32(0.0)), np.float32(0.85))
            line, asphalt = line - lost, asphalt + lost
            asphalt *= (
                np.float32(tone[row, column]) * np.float32(1.0 / 128.0)
                * (one + np.float32(0.09) * stone + np.float32(0.08) * drift)
            )  # fmt: skip
            pavement = np.float32(weights[row, column, 1]) * two55 * slabs[row, column]
            pavement *= one + np.float32(0.05) * stone + np.float32(0.04) * drift
            kerb = np.float32(weights[row, column, 2]) * two55
            gritty = one + np.float32(0.05) * stone
            kerb, line = kerb * gritty, line * gritty
            painted = np.int64(weights[row, column, 0]) + np.int64(weights[row, column, 1])
            painted += np.int64(weights[row, column, 2]) + np.int64(weights[row, column, 3])
            bare = np.float32(255 - min(painted, 255)) * two55
            grass = (one + np.float32(0.16) * blades[row, column]) * bare
            dry = min(max(np.float32(0.3) + np.float32(0.35) * drift, np.float32(0.0)), one) * grass
            light = one - np.float32(shade[row, column]) * two55
            for band in range(3):
                value = asphalt * colours[0, band] + pavement * colours[1, band]
                value += kerb * colours[2, band] + line * colours[3, band]
                value += grass * colours[4, band]
                value += dry * (colours[5, band] - colours[4, band])
                value = abs(value * light)  # as OpenCV scales pictures
                rgba[row, column, band] = np.uint8(min(np.rint(value), np.float32(255.0)) + half)
            rgba[row, column, 3] = max(weights[row, column, 0], weights[row, column, 3])
