"""Charts: what is shown, and how it becomes a figure for a paper or a chart in a page."""

from mot_sim.plotting.charts.chart import Chart, Panel, Series
from mot_sim.plotting.charts.figures import (
    FIGURE_ENDINGS,
    figure_of,
    require_figure,
    save_figure,
    svg_of,
)

__all__ = [
    "FIGURE_ENDINGS",
    "Chart",
    "Panel",
    "Series",
    "figure_of",
    "require_figure",
    "save_figure",
    "svg_of",
]
