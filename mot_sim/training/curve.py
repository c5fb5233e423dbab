"""The learning curve as a picture."""

from collections.abc import Sequence

import numpy as np
from jaxtyping import UInt8
from numpy import ndarray as Array

from mot_sim.plotting.canvas import draw_line, draw_text

CURVE_PANEL_PIXELS = (420, 260)  # pixels
CURVE_MARGIN_PIXELS = 44  # pixels
INK_COLOUR = (60, 60, 60)
PAPER_COLOUR = (255, 255, 255)
LINE_COLOUR = (31, 90, 180)


def curve_picture(rows: Sequence[dict[str, float]]) -> UInt8[Array, "h w 3"]:
    """A panel for each column after the first, over the first; see `KeypointTrainer.curve`."""
    over, *columns = rows[0]
    x = np.array([row[over] for row in rows])
    panels = [_panel(name, over, x, np.array([row[name] for row in rows])) for name in columns]
    return np.ascontiguousarray(np.hstack(panels))


def _panel(name: str, over: str, x: Array, y: Array) -> UInt8[Array, "h w 3"]:
    """One column."""
    width, height = CURVE_PANEL_PIXELS
    canvas = np.full((height, width, 3), PAPER_COLOUR, np.uint8)
    across, down = width - 2 * CURVE_MARGIN_PIXELS, height - 2 * CURVE_MARGIN_PIXELS
    low, high = min(0.0, float(y.min())), max(float(y.max()), 1e-6)
    axes = np.array(
        [
            [CURVE_MARGIN_PIXELS, CURVE_MARGIN_PIXELS],
            [CURVE_MARGIN_PIXELS, CURVE_MARGIN_PIXELS + down],
            [CURVE_MARGIN_PIXELS + across, CURVE_MARGIN_PIXELS + down],
        ]
    )
    draw_line(canvas, axes.astype(float), INK_COLOUR)
    u = CURVE_MARGIN_PIXELS + across * x / max(float(x.max()), 1e-9)
    v = CURVE_MARGIN_PIXELS + down * (1.0 - (y - low) / (high - low))
    draw_line(canvas, np.stack((u, v), axis=1), LINE_COLOUR, 2)
    draw_text(
        canvas,
        f"{name}, at last {y[-1]:.4g}",
        (CURVE_MARGIN_PIXELS, CURVE_MARGIN_PIXELS - 16),
        INK_COLOUR,
        14,
    )
    draw_text(canvas, f"{high:.3g}", (4, CURVE_MARGIN_PIXELS + 6), INK_COLOUR, 12)
    draw_text(
        canvas,
        f"{over} {x.max():.4g}",
        (width - CURVE_MARGIN_PIXELS - 50, height - CURVE_MARGIN_PIXELS + 18),
        INK_COLOUR,
        12,
    )
    return canvas
