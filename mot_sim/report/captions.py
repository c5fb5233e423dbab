"""What a film says about itself: the title bar, and the legend of its marks."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from mot_sim.plotting.canvas import Image, draw_text, text_width
from mot_sim.plotting.colours import FAINT_COLOUR, PANEL_COLOUR, TEXT_COLOUR

TITLE_PIXELS = 32  # pixels
LINE_PIXELS = 19  # pixels
LEGEND_TEXT_PIXELS = 14  # pixels
MARGIN_PIXELS = 12  # pixels


@dataclass(frozen=True)
class Layers:
    """What is drawn. truth: true boxes, missed cars, false boxes, switches, true outlines.

    wireframes: as fitted to the image; true_wireframes: as they are, of a simulated drive.
    follow: the top view moves and turns with us; else it stays where the film begins.
    """

    detections: bool = True
    truth: bool = False
    search_areas: bool = False
    wireframes: bool = False
    true_wireframes: bool = False
    top_view: bool = True
    follow: bool = True


def title_words(name: str, index: int, seconds: float, switches: int | None) -> str:
    """Which frame it is, and how many switches there were until now, if anybody knows."""
    words = f"{name}   frame {index:03d}   {seconds:4.1f} s"
    if switches is not None:
        words += f"   {switches} switch{'es' * (switches != 1)} so far"
    return words


def title(width: int, left: str, tracker: str, detections: bool) -> Image:
    """The bar above a frame; who tracked stands on the right where there is room."""
    bar = plain_bar(width, TITLE_PIXELS)
    draw_text(bar, left, (MARGIN_PIXELS, 22), TEXT_COLOUR, 18)
    right = f"colour and number: tracks of '{tracker}'"
    if detections:
        right = f"thin grey: detections (without: predicted)   {right}"
    start = width - text_width(right, 15) - MARGIN_PIXELS
    if start > MARGIN_PIXELS + text_width(left, 18):
        draw_text(bar, right, (start, 22), FAINT_COLOUR, 15)
    return bar


def marks(layers: Layers, outlines: bool) -> list[str]:
    """What the marks mean, one by one. outlines: whether the true ones are seen from above."""
    parts = []
    if layers.search_areas:
        parts.append("tinted: where a track is expected (1 sigma)")
    if layers.truth:
        parts += ["dashed white: true box", "grey: one that need not be found (van, hidden, cut)",
                  "red: missed", "red cross: false box", "yellow: new id"]  # fmt: skip
    if layers.wireframes:
        parts.append("wires: fitted shape")
    if layers.true_wireframes:
        parts.append("white wires: true shape")
    if layers.top_view:
        true = "true outlines white, " if outlines else ""
        parts.append(f"from above: {true}tracks with their doubt (1 sigma) and trails")
    return parts


def legend(width: int, parts: Sequence[str]) -> Image:
    """A bar of as many lines as the parts take."""
    lines = wrap(parts, width - 2 * MARGIN_PIXELS)
    bar = plain_bar(width, LINE_PIXELS * len(lines) + 6)
    for number, words in enumerate(lines):
        draw_text(
            bar,
            words,
            (MARGIN_PIXELS, LINE_PIXELS * (number + 1) - 2),
            TEXT_COLOUR,
            LEGEND_TEXT_PIXELS,
        )
    return bar


def wrap(parts: Sequence[str], width: int) -> list[str]:
    """The parts on lines of at most so many pixels, as long as a part fits on a line."""
    lines: list[str] = []
    for part in parts:
        longer = f"{lines[-1]}    {part}" if lines else part
        if lines and text_width(longer, LEGEND_TEXT_PIXELS) <= width:
            lines[-1] = longer
        else:
            lines.append(part)
    return lines


def plain_bar(width: int, height: int) -> Image:
    """A bar with nothing on it."""
    bar = np.empty((height, width, 3), np.uint8)
    bar[:] = PANEL_COLOUR
    return bar
