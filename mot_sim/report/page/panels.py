"""The charts of a result, by its kind; what has no columns to be drawn from has none."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace

from mot_sim.experiments.results.result_file import Cell, Result, ResultTable
from mot_sim.experiments.sweep.curves import axes_in, curve_charts, metrics_in
from mot_sim.plotting.charts import Chart, Kind, Panel, Series
from mot_sim.report.page.cells import TITLES, is_fraction, shown_columns, with_ends, word

MOST_WORDS = 40  # rows of a chart; longer tables are better read than drawn
# The metrics that one looks at first.
FIRST = ("HOTA", "MOTA", "IDF1", "AssA", "IDSW", "share", "switches per event")
QUOTED = "* "  # before a row that the paper prints
SUM = "all"  # the row that adds up the others
BOUND = 6  # the grey one of the colours


def panels_of(result: Result) -> list[Panel]:
    """The charts of a result, those of one axis or table together."""
    return [panel for panel in PANELS.get(result.kind, _nothing)(result) if panel.charts]


def _nothing(result: Result) -> Iterator[Panel]:
    yield from ()


def _curves(result: Result) -> Iterator[Panel]:
    """A panel an axis of a table of means: `means` of a sweep, `curves` of breaking points."""
    for table in result.tables:
        if table.name not in ("means", "curves") or "tracker" not in table.columns:
            continue
        by_metric = {name: curve_charts(table, name) for name in _in_order(metrics_in(table))}
        for axis in axes_in(table):
            charts = tuple(
                (TITLES.get(metric, metric), chart)
                for metric, charts in by_metric.items()
                for chart in charts
                if chart.x_title == axis and metric != "fall"
            )
            yield Panel(f"{axis}", charts)


def _stress(result: Result) -> Iterator[Panel]:
    """What was reached in every suite beside the bound, a chart a metric."""
    table = result.table("verdicts")
    if not _has(table, "suite", "tracker", "metric", "bound", "reached"):
        return
    assert table is not None
    rows = [dict(zip(table.columns, row, strict=True)) for row in table.rows]
    trackers = list(dict.fromkeys(str(row["tracker"]) for row in rows))
    charts = []
    for metric in _in_order(list(dict.fromkeys(str(row["metric"]) for row in rows))):
        mine = [row for row in rows if row["metric"] == metric and row["reached"] is not None]
        scale = 100.0 if is_fraction(metric, table) else 1.0
        series = [
            _series(tracker, [row for row in mine if row["tracker"] == tracker],
                    "suite", "reached", scale, place)
            for place, tracker in enumerate(trackers)
        ]  # fmt: skip
        limits = {row["suite"]: row for row in mine if row["bound"] is not None}
        if limits:
            bound = _series("bound", list(limits.values()), "suite", "bound", scale, BOUND)
            series.append(replace(bound, is_limit=True))
        charts.append((TITLES.get(metric, metric), _rows_chart(
            f"stress-{metric}", f"{metric}: reached, and the bound", metric, scale, series,
        )))  # fmt: skip
    yield Panel("Reached and required", tuple(charts))


def _break(result: Result) -> Iterator[Panel]:
    """The levels at which trackers break, then the curves."""
    table = result.table("points")
    if _has(table, "tracker", "level"):
        assert table is not None
        yield _panel(table, table.title, "tracker", None, ("level",))
    yield from _curves(result)


def _compare(result: Result) -> Iterator[Panel]:
    """Trackers side by side, on all drives and drive by drive."""
    table = result.table("scores")
    if _has(table, "tracker"):
        assert table is not None
        yield _panel(table, "All drives together", "tracker", None, _numbers(table), "bars")
    table = result.table("drives")
    if _has(table, "drive", "tracker"):
        assert table is not None
        yield _panel(table, "Drive by drive", "drive", "tracker", _numbers(table))


def _tables(result: Result) -> Iterator[Panel]:
    """Ablations: a row a setting, by metric; rows that are quoted in grey."""
    for table in result.tables:
        if table.columns and len(table.rows) > 1:
            yield _panel(table, table.title.split(";")[0], table.columns[0], None, _numbers(table))


def _tune(result: Result) -> Iterator[Panel]:
    """The weights."""
    table = result.table("weights")
    if _has(table, "cost", "weight"):
        assert table is not None
        yield _panel(table, table.title, "cost", None, ("weight",), "bars")


def _diagnosis(result: Result) -> Iterator[Panel]:
    """Counts and rates by event, and by source, of every tracker."""
    for table in result.tables:
        names = [shown.name for shown in shown_columns(table) if not shown.is_number]
        if table.name not in ("events", "causes") or not names:
            continue
        by = "tracker" if "tracker" in names and names != ["tracker"] else None
        words = next(name for name in names if name != by)
        place = table.columns.index(words)
        rows = tuple(row for row in table.rows if row[place] != SUM)
        parts = ResultTable(table.name, table.title, table.columns, rows)
        yield _panel(parts, table.title, words, by, _numbers(parts), "bars")


PANELS: dict[str, Callable[[Result], Iterator[Panel]]] = {
    "sweep": _curves,
    "stress": _stress,
    "breaking-point": _break,
    "compare": _compare,
    "tables": _tables,
    "tune": _tune,
    "diagnosis": _diagnosis,
}


def _panel(
    table: ResultTable, title: str, words: str, by: str | None, metrics: Sequence[str],
    kind: Kind = "rows",
) -> Panel:  # fmt: skip
    """Charts of a table whose column `words` names the rows; by: the column of the series."""
    rows = [dict(zip(table.columns, row, strict=True)) for row in table.rows]
    if len({str(row[words]) for row in rows}) > MOST_WORDS:
        return Panel(title, ())
    charts = []
    for metric in metrics:
        there = [row for row in rows if isinstance(row[metric], float | int)]
        scale = 100.0 if is_fraction(metric, table) else 1.0
        groups: dict[str, list[dict[str, Cell]]] = {}
        for row in there:
            quoted = str(row[words]).startswith(QUOTED)
            name = str(row[by]) if by else "quoted" if quoted else "measured"
            groups.setdefault(name, []).append(row)
        series = [
            _series(name, group, words, metric, scale, BOUND if name == "quoted" else place)
            for place, (name, group) in enumerate(groups.items())
        ]
        if series:
            shown = TITLES.get(metric, metric)
            chart = _rows_chart(f"{table.name}-{metric}", title, metric, scale, series, kind)
            charts.append((shown, chart))
    return Panel(title, tuple(charts))


def _series(
    name: str, rows: Sequence[dict[str, Cell]], words: str, metric: str, scale: float, place: int
) -> Series:
    """A series over words; the interval where there are columns for it."""

    def values(column: str) -> tuple[float | None, ...]:
        found = (row.get(column) for row in rows)
        return tuple(
            scale * float(each) if isinstance(each, float | int) else None for each in found
        )

    has_ends = bool(rows) and f"{metric} low" in rows[0]
    low, high = (values(f"{metric} {end}") if has_ends else () for end in ("low", "high"))
    return Series(name, tuple(word(row[words]) for row in rows), values(metric), low, high, place)


def _rows_chart(
    name: str, title: str, metric: str, scale: float, series: Sequence[Series], kind: Kind = "rows"
) -> Chart:
    """The chart, with its values in words for those who cannot see it."""
    shown = TITLES.get(metric, metric)
    said = [
        f"{each.name}, {x}: {with_ends(y, low, high)}"
        for each in series
        for x, y, low, high in each.points()
    ][:MOST_WORDS]
    unit = f"{shown.removesuffix(' %')}, %" if scale > 1.0 else shown
    about = f"{shown}. {'; '.join(said)}."
    return Chart(name, title, "", unit, tuple(series), kind, about)


def _numbers(table: ResultTable) -> list[str]:
    """The columns that hold numbers, those first that one looks at first."""
    return _in_order([shown.name for shown in shown_columns(table) if shown.is_number])


def _in_order(names: Sequence[str]) -> list[str]:
    known = [name for name in FIRST if name in names]
    return known + [name for name in names if name not in known]


def _has(table: ResultTable | None, *columns: str) -> bool:
    """Whether there is a table with these columns."""
    return table is not None and set(columns) <= set(table.columns)


__all__ = ["panels_of"]
