"""Charts in plain values, and as figures for papers (PNG, SVG, PDF), drawn by matplotlib."""

import io
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from mot_sim.files.writing import require_writable, whole_file
from tracker.errors import BadConfig

Place = float | int | str
Kind = Literal["lines", "points", "rows", "bars"]

# Okabe and Ito's colours, which most people can tell apart on light and on dark paper; the
# shapes and dashes beside them carry the same meaning without any colour.
COLOURS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#8c8c8c")
SYMBOLS = ("circle", "square", "diamond", "triangle-up", "x", "triangle-down", "cross")
DASHES = ("solid", "dash", "dot", "dashdot")

ROW_SHARE = 0.7  # of the height of a row that its series take
LINE_WIDTHS = (3.2, 2.4, 1.6)  # the first below: of two that are equal both are seen
MIN_LOG_RATIO = 30.0  # of levels, for a logarithmic axis
FIGURE_ENDINGS = (".png", ".svg", ".pdf")
CHART_INCHES = (4.6, 3.1)
ROW_INCHES = 0.28  # of a row of words and series
DOTS_PER_INCH = 200  # of a PNG
MARKERS = ("o", "s", "D", "^", "X", "v", "P")
LINE_STYLES = ("-", "--", ":", "-.")
# What a figure needs no matter how matplotlib is set up here; the salt and the missing dates
# make the same chart the same bytes.
RC_SETTINGS = {
    "font.family": "sans-serif",
    "font.size": 9.0,
    "axes.titlesize": 10.0,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "axes.axisbelow": True,
    "grid.color": "#dddddd",
    "grid.linewidth": 0.6,
    "legend.frameon": False,
    "svg.hashsalt": "mot-sim",
    "pdf.fonttype": 42,
}
METADATA = {".png": {"Software": "mot-sim"}, ".svg": {"Date": None}, ".pdf": {"CreationDate": None}}


@dataclass(frozen=True)
class Series:
    """Values of one tracker, source or setting."""

    name: str
    """Its name in the legend."""
    x: tuple[Place, ...]
    """Levels, or words in charts of rows and bars."""
    y: tuple[float | None, ...]
    """The value at each x; None: no point there."""
    low: tuple[float | None, ...] = ()
    """Lower end of each interval, None where there is none; as long as y, or empty."""
    high: tuple[float | None, ...] = ()
    """Upper end of each interval, None where there is none; as long as y, or empty."""
    place: int = 0
    """Number of its colour and symbol; beyond the last they begin again."""
    dash: int = 0
    """Number of its kind of line; beyond the last they begin again."""
    is_limit: bool = False
    """Whether these are values that the others are held against, in a chart of rows."""

    def points(self) -> Iterator[tuple[Place, float, float, float]]:
        """x, y and the ends of the interval, which are y where there is none."""
        lows, highs = self.low or self.y, self.high or self.y
        for x, y, low, high in zip(self.x, self.y, lows, highs, strict=True):
            if y is not None:
                yield x, y, y if low is None else low, y if high is None else high


@dataclass(frozen=True)
class Chart:
    """Series over one axis.

    Rows and bars have their words down the side and their values across.
    """

    name: str
    """A short word for the names of files."""
    title: str
    """The heading above it."""
    x_title: str
    """The title of the axis of levels."""
    y_title: str
    """The title of the axis of values."""
    series: tuple[Series, ...]
    """The series, in the order of the legend."""
    kind: Kind = "lines"
    """lines with bands over levels; points with error bars; rows: a line of points per word; bars:
    bars per word."""
    about: str = ""
    """What the chart shows, for screen readers."""
    y_range: tuple[float, float] | None = None
    """Lower and upper end of the axis of values; None: what holds all intervals."""
    mark: float | None = None
    """Value at which a line is drawn; None: no line."""

    def shift(self, series: Series) -> float:
        """How far below the middle of its word a series stands, in rows; limits in the middle."""
        measured = [each for each in self.series if not each.is_limit]
        if series.is_limit or len(measured) < 2:
            return 0.0
        return (measured.index(series) - 0.5 * (len(measured) - 1)) * ROW_SHARE / len(measured)

    @property
    def span(self) -> tuple[float, float] | None:
        """The range of the values: its own, or what holds all intervals with a little room."""
        points = [point for each in self.series for point in each.points()]
        if self.y_range is not None or not points:
            return self.y_range
        low, high = min(point[2] for point in points), max(point[3] for point in points)
        room = 0.05 * max(high - low, 1e-9)
        return low - room, high + room

    def width(self, series: Series) -> float:
        """How wide the line of one of its series is."""
        return LINE_WIDTHS[min(self.series.index(series), len(LINE_WIDTHS) - 1)]

    @property
    def is_sideways(self) -> bool:
        """Whether the values run across."""
        return self.kind in ("rows", "bars")

    @property
    def words(self) -> tuple[str, ...]:
        """The words of all series, each once, in order."""
        return tuple(dict.fromkeys(str(x) for each in self.series for x in each.x))

    @property
    def is_logarithmic(self) -> bool:
        """Whether levels are better shown by their logarithm: all above 0, and far apart."""
        levels = [x for each in self.series for x in each.x if not isinstance(x, str)]
        if self.is_sideways or not levels or min(levels) <= 0.0:
            return False
        return max(levels) / min(levels) >= MIN_LOG_RATIO


@dataclass(frozen=True)
class Panel:
    """Charts of which one is shown at a time."""

    title: str
    """The heading above them."""
    charts: tuple[tuple[str, Chart], ...]
    """Labels and their charts; the first one is shown first."""


if TYPE_CHECKING:
    import matplotlib.figure


def require_figure(path: Path) -> None:
    """Raise BadConfig for another ending than PNG, SVG, PDF, BadOutput if it cannot be written."""
    if path.suffix.lower() not in FIGURE_ENDINGS:
        raise BadConfig(f"{path}: give a file that ends in {', '.join(FIGURE_ENDINGS)}")
    require_writable(path)


def figure_of(rows: Sequence[Sequence[Chart]]) -> "matplotlib.figure.Figure":
    """A figure with one row of panels per row of charts, and one legend for all."""
    from matplotlib.figure import Figure  # noqa: PLC0415, importing mot_sim waits for no plots

    with styled():
        across = max(len(row) for row in rows)
        heights = [max(_height(chart) for chart in row) for row in rows]
        figure = Figure(figsize=(CHART_INCHES[0] * across, sum(heights)), layout="constrained")
        grid = figure.subplots(
            len(rows), across, squeeze=False, gridspec_kw={"height_ratios": heights}
        )
        named: dict[str, Any] = {}
        for places, row in zip(grid, rows, strict=True):
            for axes in places[len(row) :]:
                axes.set_visible(False)
            for axes, chart in zip(places, row, strict=False):
                named = {**named, **_draw(axes, chart)}
        if len(named) > 1:
            figure.legend(
                named.values(), named.keys(), loc="outside upper left", ncols=min(len(named), 4)
            )
        figure.draw_without_rendering()
        figure.set_layout_engine("none")  # laid out once, for all that it is saved as
        return figure


def save_figure(figure: "matplotlib.figure.Figure", path: Path) -> Path:
    """Write a figure by the file's ending, as a whole or not at all; see `require_figure`."""
    require_figure(path)
    ending = path.suffix.lower()
    with styled(), whole_file(path) as half:
        figure.savefig(half, format=ending[1:], dpi=DOTS_PER_INCH, metadata=METADATA[ending])
    return path


def svg_of(chart: Chart) -> bytes:
    """A chart as SVG whose text is text: small, for a page."""
    held = io.BytesIO()
    figure = figure_of([[chart]])
    with styled({"svg.fonttype": "none"}):
        figure.savefig(held, format="svg", metadata=METADATA[".svg"])
    return held.getvalue()


@contextmanager
def styled(more: dict[str, Any] | None = None) -> Iterator[None]:
    """While it lasts, matplotlib is set up as here, whatever the user's own style."""
    import matplotlib as mpl  # noqa: PLC0415

    settings: Any = {**RC_SETTINGS, **(more or {})}
    with mpl.rc_context():
        mpl.rcdefaults()
        mpl.rcParams.update(settings)
        yield


def _height(chart: Chart) -> float:
    """Inches; of rows of words as many as they need."""
    if not chart.is_sideways:
        return CHART_INCHES[1]
    return max(1.4, 1.0 + ROW_INCHES * len(chart.words) * max(1.0, 0.6 * len(chart.series)))


def _draw(axes: Any, chart: Chart) -> dict[str, Any]:
    """Draw a chart; what the legend shows, by name."""
    axes.set_title(chart.title, loc="left")
    if chart.is_sideways:
        named = _draw_rows(axes, chart)
    else:
        named = {each.name: _draw_levels(axes, each, chart) for each in chart.series}
        axes.set_xlabel(chart.x_title)
        axes.set_ylabel(chart.y_title)
        if chart.is_logarithmic:
            axes.set_xscale("log")
        if chart.y_range is not None:
            axes.set_ylim(*chart.y_range)
    if chart.mark is not None:
        line = axes.axvline if chart.is_sideways else axes.axhline
        line(chart.mark, color="#555555", linewidth=1.0)
    return named


def _draw_levels(axes: Any, series: Series, chart: Chart) -> Any:
    """A line with its band, or points with their bars."""
    x = [point[0] for point in series.points()]
    y, low, high = _values(series)
    width = 0.7 * chart.width(series)
    look = {"color": COLOURS[series.place % len(COLOURS)], "markersize": 3.0 + width}
    marker, style = (
        MARKERS[series.place % len(MARKERS)],
        LINE_STYLES[series.dash % len(LINE_STYLES)],
    )
    if chart.kind == "points":
        spans = [_below(y, low), _below(high, y)]
        return axes.errorbar(x, y, spans, fmt=marker, elinewidth=0.8, **look)
    axes.fill_between(x, low, high, color=look["color"], alpha=0.15, linewidth=0)
    return axes.plot(x, y, marker=marker, linestyle=style, linewidth=width, **look)[0]


def _draw_rows(axes: Any, chart: Chart) -> dict[str, Any]:
    """A line a word; series of a word lie below one another."""
    words, count = chart.words, len(chart.series)
    named = {}
    for each in chart.series:
        shift = chart.shift(each)
        place = [words.index(str(point[0])) + shift for point in each.points()]
        y, low, high = _values(each)
        spans = [_below(y, low), _below(high, y)]
        colour = COLOURS[each.place % len(COLOURS)]
        if chart.kind == "bars":
            named[each.name] = axes.barh(place, y, ROW_SHARE / count, color=colour)
            if any(low != high for low, high in zip(*spans, strict=True)):
                axes.errorbar(y, place, xerr=spans, fmt="none", ecolor="#333333", elinewidth=0.8)
        else:
            marker = "|" if each.is_limit else MARKERS[each.place % len(MARKERS)]
            look: dict[str, Any] = {"color": colour, "markersize": 4.5, "elinewidth": 1.2}
            if each.is_limit:
                look |= {"markersize": 16.0, "markeredgewidth": 2.0}
            named[each.name] = axes.errorbar(y, place, xerr=spans, fmt=marker, **look)
    axes.set_yticks(range(len(words)), words)
    axes.set_ylim(len(words) - 0.5, -0.5)
    axes.set_xlabel(chart.y_title)
    if chart.kind == "rows" and chart.span is not None:
        axes.set_xlim(*chart.span)
    return named


def _values(series: Series) -> tuple[list[float], list[float], list[float]]:
    """The values and the ends of their intervals."""
    points = list(series.points())
    return [each[1] for each in points], [each[2] for each in points], [each[3] for each in points]


def _below(upper: Sequence[float], lower: Sequence[float]) -> list[float]:
    """Lengths of the halves of intervals; never negative, as rounding can make them."""
    return [max(a - b, 0.0) for a, b in zip(upper, lower, strict=True)]
