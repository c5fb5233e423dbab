"""Errors of cuboids from above: where cars stand and where they were believed, as figures."""

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np
from jaxtyping import Float
from numpy import ndarray as Array

from mot_sim.plotting.charts import COLOURS, styled

if TYPE_CHECKING:
    import matplotlib.figure

MAX_DRAWN = 4000  # rows; of more every so many-th is drawn
PANEL_INCHES = (5.2, 5.6)
BIN_METRES = 5.0  # of the distances over which errors are summed up
MIN_IN_BIN = 10  # rows
COLOUR_METRES = 4.0  # the error from which on the colour is the same


def birds_eye_figure(
    places: Float[Array, "n 2"], found: Float[Array, "n 2"], title: str = ""
) -> "matplotlib.figure.Figure":
    """Every car from above, and where it was believed.

    places, found: metres right of and ahead of the camera. Rows with NaN are left out.
    """
    known = np.isfinite(places).all(axis=1) & np.isfinite(found).all(axis=1)
    return _figure(lambda axes: _draw_from_above(axes, places[known], found[known]), title)


def distance_figure(
    places: Float[Array, "n 2"],
    found: Float[Array, "n 2"],
    stated_std: Float[Array, " n"] | None = None,
    title: str = "",
) -> "matplotlib.figure.Figure":
    """Radial errors over distance.

    places, found: see `birds_eye_figure`. stated_std: of each radial error, m; None or NaN: not
    stated.
    """
    known = np.isfinite(places).all(axis=1) & np.isfinite(found).all(axis=1)
    std = np.full(len(places), np.nan) if stated_std is None else stated_std
    return _figure(
        lambda axes: _draw_over_distance(axes, places[known], found[known], std[known]), title
    )


def _figure(draw: Callable[[Any], None], title: str) -> "matplotlib.figure.Figure":
    """One panel under a title."""
    from matplotlib.figure import Figure  # noqa: PLC0415, importing mot_sim waits for no plots

    with styled():
        figure = Figure(figsize=PANEL_INCHES, layout="constrained")
        draw(figure.subplots())
        if title:
            figure.suptitle(title, x=0.01, ha="left")
        figure.draw_without_rendering()
        figure.set_layout_engine("none")  # laid out once, for all that it is saved as
    return figure


def _draw_from_above(axes: Any, places: Float[Array, "n 2"], found: Float[Array, "n 2"]) -> None:
    """A line from every car to where it was believed."""
    from matplotlib.collections import LineCollection  # noqa: PLC0415

    step = max(1, -(-len(places) // MAX_DRAWN))
    lines = np.stack([places, found], axis=1)[::step]
    metres = np.linalg.norm(lines[:, 1] - lines[:, 0], axis=1)
    drawn = LineCollection(list(lines), array=metres, cmap="viridis", linewidths=0.8)
    drawn.set_clim(0.0, COLOUR_METRES)
    axes.add_collection(drawn)
    axes.plot(*places[::step].T, ".", markersize=1.6, color="#555555")
    axes.plot([0.0], [0.0], "^", color=COLOURS[1], markersize=7, label="camera")
    axes.legend(loc="lower right")
    axes.set_aspect("equal", adjustable="datalim")
    axes.autoscale_view()
    every = f", one row in {step}" if step > 1 else ""
    axes.set_title(f"From the car (dot) to where it was believed{every}", loc="left")
    axes.set_xlabel("right of the camera, m")
    axes.set_ylabel("ahead of the camera, m")
    axes.figure.colorbar(drawn, ax=axes, label="off by, m", shrink=0.7, extend="max")


def _draw_over_distance(
    axes: Any, places: Float[Array, "n 2"], found: Float[Array, "n 2"], std: Float[Array, " n"]
) -> None:
    """Median and 80 % of the radial errors, and what was stated, by distance."""
    distance = np.linalg.norm(places, axis=1)
    ray = places / np.maximum(distance, 1e-9)[:, None]
    radial = ((found - places) * ray).sum(axis=1)
    bins = (distance // BIN_METRES).astype(int)
    rows = []
    for number in np.unique(bins):
        here = bins == number
        if np.count_nonzero(here) < MIN_IN_BIN:
            continue
        told = std[here][np.isfinite(std[here])]
        stated = float(np.median(told)) if len(told) else np.nan
        middle = (number + 0.5) * BIN_METRES
        rows.append((middle, *np.quantile(radial[here], (0.1, 0.5, 0.9)), stated))
    if rows:
        middle, low, median, high, stated = np.array(rows).T
        axes.fill_between(middle, low, high, color=COLOURS[0], alpha=0.2, label="80 % of the rows")
        axes.plot(middle, median, "o-", color=COLOURS[0], markersize=4, label="median")
        if np.isfinite(stated).any():
            for sign in (1.0, -1.0):
                name = "stated: 1 sigma" if sign > 0 else "_"
                axes.plot(middle, sign * stated, "--", color=COLOURS[1], label=name)
        axes.legend(loc="upper left")
    axes.axhline(0.0, color="#555555", linewidth=1.0)
    axes.set_title("Too far (+) or too near (-) by distance", loc="left")
    axes.set_xlabel("distance of the car, m")
    axes.set_ylabel("error along the viewing ray, m")
