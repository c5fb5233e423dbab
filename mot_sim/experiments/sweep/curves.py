"""A sweep as curves: a chart an axis, a line a tracker, from the table of its means."""

from collections.abc import Sequence
from pathlib import Path

from mot_sim.plotting.charts import Chart, Series, figure_of, save_figure
from mot_sim.tables import Cell, Table, is_count, is_rate
from tracker.errors import BadConfig

TRACKER = "tracker"  # the column that stands behind those of the axes
MAX_LINES = 8  # in one chart
PICTURE_METRICS = ("HOTA", "IDF1")  # of those that a table has
CHARTS_A_ROW = 3  # of a picture

Row = dict[str, Cell]


def axes_in(table: Table) -> tuple[str, ...]:
    """The axes of a table of means: its columns before `tracker`."""
    return table.names[: table.names.index(TRACKER)]


def metrics_in(table: Table) -> tuple[str, ...]:
    """The scores of a table of means: its columns behind `tracker` that have an interval."""
    there = table.names[table.names.index(TRACKER) :]
    return tuple(name for name in there if f"{name} low" in there)


def curve_charts(table: Table, metric: str) -> list[Chart]:
    """A chart an axis, in the order of the table; axes with one level have none.

    Lines where other axes stay as they are; where they vary, a line a combination of theirs, or
    points where levels were drawn at random. Words are rows. Rates in percent. All charts share
    the range of the metric. Points where every seed failed are left out.
    """
    rows = [row for row in table.as_records() if row[metric] is not None]
    charts = []
    for axis in axes_in(table):
        there = [row for row in rows if row[axis] is not None]
        if len({row[axis] for row in there}) > 1:
            charts.append(_chart(there, axis, axes_in(table), metric))
    return _with_one_range(charts, is_rate(metric))


def _chart(rows: Sequence[Row], axis: str, axes: Sequence[str], metric: str) -> Chart:
    """The chart of an axis."""
    trackers = list(dict.fromkeys(str(row[TRACKER]) for row in rows))
    others = [name for name in axes if name != axis]
    groups: dict[tuple[Cell, ...], list[Row]] = {}
    for row in rows:
        groups.setdefault((row[TRACKER], *(row[name] for name in others)), []).append(row)
    is_words = any(isinstance(row[axis], str | bool) for row in rows)
    is_drawn = all(len(group) == 1 for group in groups.values())
    told = ""
    if is_drawn:
        groups = {(name,): [row for row in rows if row[TRACKER] == name] for name in trackers}
    elif len(groups) > MAX_LINES:
        groups = {(name,): _at_first(rows, name, others) for name in trackers}
        first = _at_first(rows, trackers[0], others)[0]
        told = f"; {_words(others, [first[name] for name in others])}"
    kinds = list(dict.fromkeys(key[1:] for key in groups))
    series = tuple(
        _series(
            ", ".join(part for part in (str(key[0]), _words(others, key[1:])) if part),
            group, axis, metric, trackers.index(str(key[0])), kinds.index(key[1:]),
        )
        for key, group in groups.items()
    )  # fmt: skip
    return Chart(
        f"{metric}-over-{axis}", f"{metric} over {axis}{told}", axis, _unit(metric), series,
        "rows" if is_words else "points" if is_drawn else "lines", _about(series, axis, metric),
    )  # fmt: skip


def _at_first(rows: Sequence[Row], tracker: str, others: Sequence[str]) -> list[Row]:
    """The rows of a tracker where the other axes are at their first levels."""
    mine = [row for row in rows if row[TRACKER] == tracker]
    return [row for row in mine if all(row[name] == mine[0][name] for name in others)]


def _words(axes: Sequence[str], levels: Sequence[Cell]) -> str:
    """Levels of the axes that are set, by the last part of their names."""
    return ", ".join(
        f"{axis.rpartition('.')[2]}={level:g}"
        if isinstance(level, float)
        else f"{axis.rpartition('.')[2]}={level}"
        for axis, level in zip(axes, levels, strict=False)
        if level is not None
    )


def _series(
    name: str, rows: Sequence[Row], axis: str, metric: str, place: int, dash: int
) -> Series:
    """The rows of a line, in the order of their levels."""
    scale = 100.0 if is_rate(metric) else 1.0
    levels = [row[axis] for row in rows]
    if not any(isinstance(level, str | bool) for level in levels):
        rows = sorted(rows, key=lambda row: float(row[axis] or 0.0))

    def values(column: str) -> tuple[float | None, ...]:
        found = [row[column] for row in rows]
        return tuple(None if each is None else scale * float(each) for each in found)

    return Series(
        name, tuple(_place(row[axis]) for row in rows), values(metric), values(f"{metric} low"),
        values(f"{metric} high"), place, dash,
    )  # fmt: skip


def _place(level: Cell) -> float | int | str:
    return str(level) if level is None or isinstance(level, str | bool) else level


def _about(series: Sequence[Series], axis: str, metric: str) -> str:
    """The ends of every line, in words."""
    said = []
    for each in series:
        points = list(each.points())
        (first, start, *_), (last, end, *_) = points[0], points[-1]
        said.append(f"{each.name} from {start:.1f} at {first} to {end:.1f} at {last}")
    return f"{metric} over {axis}: {'; '.join(said)}."


def _with_one_range(charts: Sequence[Chart], is_part: bool) -> list[Chart]:
    """The charts with the range that holds all their intervals, and a little room.

    is_part: percentages, of which those above 100 are no values but ends of wide intervals.
    """
    points = [point for chart in charts for each in chart.series for point in each.points()]
    if not points:
        return list(charts)
    low, high = min(point[2] for point in points), max(point[3] for point in points)
    if is_part:
        high = min(high, max(100.0, *(point[1] for point in points)))
    room = 0.05 * max(high - low, 1e-9)
    given = [vars(chart) for chart in charts]
    return [Chart(**{**each, "y_range": (low - room, high + room)}) for each in given]


def _unit(metric: str) -> str:
    """What stands beside the values."""
    if is_rate(metric):
        return f"{metric}, %"
    return f"{metric}, mean of a run" if is_count(metric) else metric


def save_curves(table: Table, path: Path, metrics: Sequence[str] = PICTURE_METRICS) -> Path:
    """The curves of some metrics as one PNG, SVG or PDF, metric by metric, three in a row.

    Raises BadConfig for a table without a curve and for another ending.
    """
    rows = [curve_charts(table, metric) for metric in metrics if metric in metrics_in(table)]
    rows = [row[at : at + CHARTS_A_ROW] for row in rows for at in range(0, len(row), CHARTS_A_ROW)]
    if not rows:
        raise BadConfig("no curves: a sweep has some over axes of two levels or more")
    return save_figure(figure_of(rows), path)
