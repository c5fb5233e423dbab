"""The curves of a fit as one picture: real in blue, made in orange."""

from collections.abc import Mapping

import numpy as np
from jaxtyping import Float, UInt8
from numpy import ndarray as Array

from mot_sim.plotting.canvas import draw_line, draw_text

PANEL = (420, 300)  # width, height in pixels
MARGIN = 44
COLUMNS = 3
REAL, MADE, INK, PAPER = (31, 90, 180), (226, 110, 20), (60, 60, 60), (255, 255, 255)


def fit_picture(
    curves: Mapping[str, tuple[Array, Float[Array, "2 k"]]],
) -> UInt8[Array, "h w 3"]:
    """A panel a title, three in a row; see `curves`."""
    rows = -(-len(curves) // COLUMNS)
    width, height = PANEL
    picture = np.full((rows * height, COLUMNS * width, 3), PAPER, np.uint8)
    for number, (title, (x, pair)) in enumerate(curves.items()):
        left, top = number % COLUMNS * width, number // COLUMNS * height
        _panel(picture[top : top + height, left : left + width], title, x, pair)
    return picture


def _panel(image: UInt8[Array, "h w 3"], title: str, x: Array, pair: Float[Array, "2 k"]) -> None:
    """Axes with the numbers at their ends, and both curves."""
    width, height = PANEL
    known = pair[np.isfinite(pair)]
    low, high = (float(known.min()), float(known.max())) if len(known) else (0.0, 1.0)
    low, high = min(low, 0.0) if low < 0.5 else low, max(high, low + 1e-6)
    first, last = float(x[0]), float(x[-1])
    across, down = width - 2 * MARGIN, height - 2 * MARGIN

    canvas = image.copy()
    axes = np.array([[MARGIN, MARGIN], [MARGIN, MARGIN + down], [MARGIN + across, MARGIN + down]])
    draw_line(canvas, axes.astype(float), INK)
    for colour, y in ((REAL, pair[0]), (MADE, pair[1])):
        there = np.isfinite(y)
        u = MARGIN + across * (x[there] - first) / max(last - first, 1e-9)
        v = MARGIN + down * (1.0 - (y[there] - low) / (high - low))
        draw_line(canvas, np.stack((u, v), axis=1), colour, 2)
    draw_text(canvas, title, (MARGIN, MARGIN - 22), INK, 14)
    draw_text(canvas, "real", (width - 120, MARGIN - 6), REAL, 13)
    draw_text(canvas, "made", (width - 80, MARGIN - 6), MADE, 13)
    draw_text(canvas, f"{first:.3g}", (MARGIN, height - MARGIN + 18), INK, 12)
    draw_text(canvas, f"{last:.3g}", (width - MARGIN - 20, height - MARGIN + 18), INK, 12)
    draw_text(canvas, f"{low:.2f}", (4, height - MARGIN), INK, 12)
    draw_text(canvas, f"{high:.2f}", (4, MARGIN + 6), INK, 12)
    image[:] = canvas
