"""The learning curve as a picture."""

from collections.abc import Sequence

import numpy as np
from jaxtyping import UInt8
from numpy import ndarray as Array

from mot_sim.plotting.canvas import draw_line, draw_text

PANEL, MARGIN = (420, 260), 44  # pixels
INK, PAPER, LINE = (60, 60, 60), (255, 255, 255), (31, 90, 180)


def curve_picture(rows: Sequence[dict[str, float]]) -> UInt8[Array, "h w 3"]:
    """A panel for each column after the first, over the first; see `Learner.curve`."""
    over, *columns = rows[0]
    x = np.array([row[over] for row in rows])
    panels = [_panel(name, over, x, np.array([row[name] for row in rows])) for name in columns]
    return np.ascontiguousarray(np.hstack(panels))


def _panel(name: str, over: str, x: Array, y: Array) -> UInt8[Array, "h w 3"]:
    """One column."""
    width, height = PANEL
    canvas = np.full((height, width, 3), PAPER, np.uint8)
    across, down = width - 2 * MARGIN, height - 2 * MARGIN
    low, high = min(0.0, float(y.min())), max(float(y.max()), 1e-6)
    axes = np.array([[MARGIN, MARGIN], [MARGIN, MARGIN + down], [MARGIN + across, MARGIN + down]])
    draw_line(canvas, axes.astype(float), INK)
    u = MARGIN + across * x / max(float(x.max()), 1e-9)
    v = MARGIN + down * (1.0 - (y - low) / (high - low))
    draw_line(canvas, np.stack((u, v), axis=1), LINE, 2)
    draw_text(canvas, f"{name}, at last {y[-1]:.4g}", (MARGIN, MARGIN - 16), INK, 14)
    draw_text(canvas, f"{high:.3g}", (4, MARGIN + 6), INK, 12)
    draw_text(canvas, f"{over} {x.max():.4g}", (width - MARGIN - 50, height - MARGIN + 18), INK, 12)
    return canvas
