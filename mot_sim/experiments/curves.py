"""A sweep as curves: a row of panels a metric, a panel an axis, a line a tracker."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, UInt8
from numpy import ndarray as Array

from mot_sim.experiments.summary import Interval, Line
from mot_sim.report.canvas import fill, line, text
from mot_sim.report.grid import RATES
from tracker.errors import BadConfig

PANEL = (400, 300)  # width, height in pixels
LEFT, RIGHT, TOP, BOTTOM = 52, 16, 34, 44
LEGEND = 34
INK, GRID, PAPER = (60, 60, 60), (225, 225, 225), (255, 255, 255)
# Okabe and Ito's colours, which most people can tell apart.
COLOURS = (
    (0, 114, 178), (213, 94, 0), (0, 158, 115), (204, 121, 167), (230, 159, 0), (86, 180, 233),
    (90, 90, 90),
)  # fmt: skip
PALE = 0.85  # of what is below, that shows through the bands of the intervals


@dataclass(frozen=True)
class Curve:
    """A tracker over an axis: levels, and the mean with the ends of its interval at each."""

    tracker: str
    levels: Float[Array, " k"]
    middle: Float[Array, " k"]
    low: Float[Array, " k"]
    high: Float[Array, " k"]


def curves_of(lines: Sequence[Line], axis: str, metric: str) -> list[Curve]:
    """The curves of the points at which this axis alone is set, by tracker.

    Rates in percent; points where every seed failed are left out.
    """
    scale = 100.0 if metric in RATES.values() else 1.0
    found: dict[str, list[tuple[float, Interval]]] = {}
    for each in lines:
        set_here = [name for name, level in each.levels.items() if level is not None]
        level, interval = each.levels[axis], each.metrics.get(metric)
        if set_here != [axis] or interval is None or interval.mean is None:
            continue
        if isinstance(level, bool) or not isinstance(level, float | int):
            continue
        found.setdefault(each.tracker, []).append((float(level), interval))
    curves = []
    for tracker, rows in found.items():
        rows.sort(key=lambda row: row[0])
        ends = [
            (each.mean, each.mean if each.low is None else each.low,
             each.mean if each.high is None else each.high)
            for _, each in rows
        ]  # fmt: skip
        middle, low, high = scale * np.array(ends, float).T
        curves.append(Curve(tracker, np.array([level for level, _ in rows]), middle, low, high))
    return curves


def sweep_picture(
    lines: Sequence[Line], metrics: Sequence[str] = ("HOTA", "IDF1")
) -> UInt8[Array, "h w 3"]:
    """The curves of every axis of numbers. Raises BadConfig where there is none.

    For designs with one axis, or one at a time; shaded: the 95 % intervals of the means.
    """
    axes = [axis for axis in lines[0].levels if curves_of(lines, axis, metrics[0])]
    if not axes:
        raise BadConfig("no curves: a design of one axis of numbers, or of one at a time, has some")
    width, height = PANEL
    shape = LEGEND + len(metrics) * height, len(axes) * width, 3
    picture = np.full(shape, PAPER, np.uint8)
    for row, metric in enumerate(metrics):
        panels = [curves_of(lines, axis, metric) for axis in axes]
        every = [each for panel in panels for each in panel]
        scale = _ends(np.concatenate([np.concatenate((each.low, each.high)) for each in every]))
        for column, (axis, panel) in enumerate(zip(axes, panels, strict=True)):
            top, left = LEGEND + row * height, column * width
            part = picture[top : top + height, left : left + width]
            part[:] = _panel(part.copy(), axis, metric, panel, scale)
    picture[:LEGEND] = _legend(picture[:LEGEND].copy(), lines)
    return picture


def _ends(values: Float[Array, " n"]) -> tuple[float, float]:
    """The ends of an axis that holds all values."""
    low, high = float(values.min()), float(values.max())
    room = 0.05 * max(high - low, 1e-9)
    return low - room, high + room


def _panel(
    image: UInt8[Array, "h w 3"],
    axis: str,
    metric: str,
    curves: Sequence[Curve],
    scale: tuple[float, float],
) -> UInt8[Array, "h w 3"]:
    """Axes with numbers, bands, lines."""
    width, height = PANEL
    first, last = _ends(np.concatenate([each.levels for each in curves]))
    low, high = scale

    def place(x: Float[Array, " k"], y: Float[Array, " k"]) -> Float[Array, "k 2"]:
        u = LEFT + (width - LEFT - RIGHT) * (x - first) / (last - first)
        v = TOP + (height - TOP - BOTTOM) * (high - y) / (high - low)
        return np.stack((u, v), axis=1)

    for y in _ticks(low, high):
        line(image, place(np.array([first, last]), np.array([y, y])), GRID)
        text(image, f"{y:g}", (8, int(place(np.array([first]), np.array([y]))[0, 1]) + 5), INK, 12)
    for x in sorted({float(x) for each in curves for x in each.levels}):
        at = int(place(np.array([x]), np.array([low]))[0, 0])
        text(image, f"{x:g}", (at - 8, height - BOTTOM + 18), INK, 12)
    for number, each in enumerate(curves):
        above, below = place(each.levels, each.high), place(each.levels, each.low)
        image = _band(image, above, below, COLOURS[number % len(COLOURS)])
    for number, each in enumerate(curves):
        line(image, place(each.levels, each.middle), COLOURS[number % len(COLOURS)], 2)
    line(image, place(np.array([first, first, last]), np.array([high, low, low])), INK)
    text(image, metric, (LEFT, TOP - 10), INK, 14)
    text(image, axis, (LEFT, height - 8), INK, 14)
    return image


def _band(
    image: UInt8[Array, "h w 3"],
    above: Float[Array, "k 2"],
    below: Float[Array, "k 2"],
    colour: tuple[int, int, int],
) -> UInt8[Array, "h w 3"]:
    """The image with what lies between two lines tinted."""
    tinted = image.copy()
    for k in range(len(above) - 1):
        fill(tinted, np.array([above[k], above[k + 1], below[k + 1], below[k]]), colour)
    return (PALE * image + (1.0 - PALE) * tinted).round().astype(np.uint8)


def _legend(image: UInt8[Array, "h w 3"], lines: Sequence[Line]) -> UInt8[Array, "h w 3"]:
    """The trackers in their colours."""
    x = LEFT
    for number, name in enumerate(dict.fromkeys(each.tracker for each in lines)):
        colour = COLOURS[number % len(COLOURS)]
        line(image, np.array([[x, 17.0], [x + 22.0, 17.0]]), colour, 2)
        x = text(image, name, (x + 28, 22), INK, 14) + 24
    return image


def _ticks(low: float, high: float) -> list[float]:
    """Round numbers between the ends, four to nine."""
    step = 10.0 ** np.floor(np.log10(high - low))
    while (high - low) / step < 4.0:
        step /= 2.0
    first, last = int(np.ceil(low / step)), int(np.floor(high / step))
    return [float(step * number) for number in range(first, last + 1)]
