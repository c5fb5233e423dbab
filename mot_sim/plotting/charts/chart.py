"""A chart in plain values: who draws it, and with what, is decided elsewhere."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal

Place = float | int | str
Kind = Literal["lines", "points", "rows", "bars"]

# Okabe and Ito's colours, which most people can tell apart on light and on dark paper; the
# shapes and dashes beside them carry the same meaning without any colour.
COLOURS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#8c8c8c")
SYMBOLS = ("circle", "square", "diamond", "triangle-up", "x", "triangle-down", "cross")
DASHES = ("solid", "dash", "dot", "dashdot")

ROW_SHARE = 0.7  # of the height of a row that its series take
LINE_WIDTHS = (3.2, 2.4, 1.6)  # of lines, the first below: of two that are equal both are seen


@dataclass(frozen=True)
class Series:
    """Values of one tracker, source or setting. x: levels or words; y: values there.

    low, high: ends of the intervals, of the length of y, or empty. place: its colour and symbol.
    dash: its kind of line. is_limit: values that the others are held against, in a chart of rows.
    """

    name: str
    x: tuple[Place, ...]
    y: tuple[float | None, ...]
    low: tuple[float | None, ...] = ()
    high: tuple[float | None, ...] = ()
    place: int = 0
    dash: int = 0
    is_limit: bool = False

    def points(self) -> Iterator[tuple[Place, float, float, float]]:
        """Where it stands, its value and the ends of the interval; both are y where it has none."""
        lows, highs = self.low or self.y, self.high or self.y
        for x, y, low, high in zip(self.x, self.y, lows, highs, strict=True):
            if y is not None:
                yield x, y, y if low is None else low, y if high is None else high


@dataclass(frozen=True)
class Chart:
    """Series over one axis.

    name: a short word for files. kind: lines with bands over levels; points with bars; rows: a
    line a word, with points and bars; bars: a line a word. Rows and bars have their words down
    the side and their values across. y_range: of the values, where charts share one. mark: a
    value that is worth a line. about: what is to be seen, for those who cannot see it.
    """

    name: str
    title: str
    x_title: str
    y_title: str
    series: tuple[Series, ...]
    kind: Kind = "lines"
    about: str = ""
    y_range: tuple[float, float] | None = None
    mark: float | None = None

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


MIN_LOG_RATIO = 30.0  # the ratio of levels from which on an axis is logarithmic


@dataclass(frozen=True)
class Panel:
    """Charts of which one is shown at a time, by label; the first one to begin with."""

    title: str
    charts: tuple[tuple[str, Chart], ...]


__all__ = ["COLOURS", "DASHES", "SYMBOLS", "Chart", "Panel", "Series"]
