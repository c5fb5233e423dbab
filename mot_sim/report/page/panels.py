"""The charts of a result, by its kind; what has no columns to be drawn from has none."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace

from mot_sim.experiments.result_file import Result
from mot_sim.experiments.sweep.curves import axes_in, curve_charts, metrics_in
from mot_sim.plotting.charts import Chart, Kind, Panel, Series
from mot_sim.report.page.tables import shown_columns
from mot_sim.tables import Cell, Table, is_rate, show_value, title_of

MAX_CHART_ROWS = 40  # longer tables are better read than drawn
# The metrics that one looks at first.
FIRST_METRICS = ("HOTA", "MOTA", "IDF1", "AssA", "IDSW", "share", "switches per event")
QUOTED_MARK = "* "  # before a row that the paper prints
SUM_ROW = "all"  # the row that adds up the others
BOUND_COLOUR = 6  # the grey one of the chart's colours


def panels_of(result: Result) -> list[Panel]:
    """The charts of a result, those of one axis or table together."""
    return [panel for panel in PANELS.get(result.kind, _nothing)(result) if panel.charts]


def _nothing(result: Result) -> Iterator[Panel]:
    yield from ()


def _curves(result: Result) -> Iterator[Panel]:
    """A panel an axis of a table of means: `means` of a sweep, `curves` of breaking points."""
    for table in result.tables:
        if table.name not in ("means", "curves") or not table.has("tracker"):
            continue
        by_metric = {name: curve_charts(table, name) for name in _in_order(metrics_in(table))}
        for axis in axes_in(table):
            charts = tuple(
                (title_of(metric), chart)
                for metric, charts in by_metric.items()
                for chart in charts
                if chart.x_title == axis and metric != "fall"
            )
            yield Panel(f"{axis}", charts)


def _stress(result: Result) -> Iterator[Panel]:
    """What was reached in every suite beside the bound, and beside the baseline."""
    table = result.table("verdicts")
    if table is not None and table.has("suite", "tracker", "metric", "bound", "reached"):
        yield Panel("Reached and required", tuple(_suite_charts(table, "bound")))
    table = result.table("drifts")
    if table is not None and table.has("suite", "tracker", "metric", "baseline", "reached"):
        yield Panel("Now and the baseline", tuple(_suite_charts(table, "baseline")))


def _suite_charts(table: Table, beside: str) -> Iterator[tuple[str, Chart]]:
    """A chart a metric: what every tracker reached, suite by suite, and another column beside it.

    beside: the column of bounds, one a suite, or of what each tracker reached before.
    """
    rows = [row for row in table.as_records() if row["reached"] is not None]
    for metric in _in_order(list(dict.fromkeys(str(row["metric"]) for row in rows))):
        trackers: dict[str, list[dict[str, Cell]]] = {}
        for row in rows:
            if row["metric"] == metric:
                trackers.setdefault(str(row["tracker"]), []).append(row)
        scale = 100.0 if is_rate(metric) else 1.0
        series: list[Series] = []
        for place, (tracker, mine) in enumerate(trackers.items()):
            if beside == "baseline":
                before = _series(f"{tracker}, {beside}", mine, "suite", beside, scale, BOUND_COLOUR)
                series.append(before)
            series.append(_series(tracker, mine, "suite", "reached", scale, place))
        if beside == "bound":
            limits = {row["suite"]: row for mine in trackers.values() for row in mine}
            wanted = [row for row in limits.values() if row["bound"] is not None]
            bound = _series(beside, wanted, "suite", beside, scale, BOUND_COLOUR)
            series += [replace(bound, is_limit=True)] if wanted else []
        title = f"{metric}: reached, and the {beside}"
        name = "stress" if beside == "bound" else beside
        chart = _rows_chart(f"{name}-{metric}", title, metric, scale, series)
        yield title_of(metric), chart


def _break(result: Result) -> Iterator[Panel]:
    """The levels at which trackers break, then the curves."""
    table = result.table("points")
    if table is not None and table.has("tracker", "level"):
        yield _panel(table, table.title, "tracker", None, ("level",))
    yield from _curves(result)


def _compare(result: Result) -> Iterator[Panel]:
    """Trackers side by side, on all drives and drive by drive."""
    table = result.table("scores")
    if table is not None and table.has("tracker"):
        yield _panel(table, "All drives together", "tracker", None, _numbers(table), "bars")
    table = result.table("drives")
    if table is not None and table.has("drive", "tracker"):
        yield _panel(table, "Drive by drive", "drive", "tracker", _numbers(table))


def _tables(result: Result) -> Iterator[Panel]:
    """Ablations: a row a setting, by metric; rows that are quoted in grey."""
    for table in result.tables:
        if table.columns and len(table.rows) > 1:
            yield _panel(table, table.title.split(";")[0], table.names[0], None, _numbers(table))


def _tune(result: Result) -> Iterator[Panel]:
    """The weights."""
    table = result.table("weights")
    if table is not None and table.has("cost", "weight"):
        yield _panel(table, table.title, "cost", None, ("weight",), "bars")


def _diagnosis(result: Result) -> Iterator[Panel]:
    """Counts and rates by event, and by source, of every tracker."""
    for table in result.tables:
        names = [each.column.name for each in shown_columns(table) if not each.is_number]
        if table.name not in ("events", "causes") or not names:
            continue
        by = "tracker" if "tracker" in names and names != ["tracker"] else None
        words = next(name for name in names if name != by)
        place = table.names.index(words)
        rows = tuple(row for row in table.rows if row[place] != SUM_ROW)
        parts = replace(table, rows=rows)
        yield _panel(parts, table.title, words, by, _numbers(parts), "bars")


def _scenes(result: Result) -> Iterator[Panel]:
    """Scenes beside recorded drives: every statistic, then the cumulated distributions."""
    table = result.table("statistics")
    if table is not None and table.has("scene", "statistic", "value", "median low"):
        charts: list[tuple[str, Chart]] = []
        for name in dict.fromkeys(map(str, table.column("statistic"))):
            mine = [row for row in table.as_records() if row["statistic"] == name]
            drives = {**mine[0], "scene": "recorded drives"}
            series = [
                _series("recorded drives", [drives], "scene", "median", 1.0, BOUND_COLOUR),
                _series("scene", mine, "scene", "value", 1.0, 0),
            ]
            place = len(charts)
            charts.append((name, _rows_chart(f"statistic-{place}", name, name, 1.0, series)))
        yield Panel("Statistics of scenes and the range of recorded drives", tuple(charts))
    table = result.table("distributions")
    if table is not None and table.has("statistic", "of", "value", "share", "share low"):
        curves: list[tuple[str, Chart]] = []
        for name in dict.fromkeys(map(str, table.column("statistic"))):
            mine = [row for row in table.as_records() if row["statistic"] == name]
            sources = list(dict.fromkeys(str(row["of"]) for row in mine))
            shown = tuple(
                _curve(source, [row for row in mine if row["of"] == source], place)
                for place, source in enumerate(sources)
            )
            about = f"Cumulated distribution of: {name}; band: the recorded drives one by one"
            key = f"distribution-{len(curves)}"
            curves.append(
                (name, Chart(key, name, name, "share up to it", shown, about=about, y_range=(0, 1)))
            )
        yield Panel("Cumulated distributions", tuple(curves))


def _curve(source: str, rows: Sequence[dict[str, Cell]], place: int) -> Series:
    """A cumulated distribution; the first one, of the recorded drives, in grey with its band."""
    x, y, low, high = (
        tuple(each if isinstance(each, float) else None for each in (row[name] for row in rows))
        for name in ("value", "share", "share low", "share high")
    )
    dash, colour = divmod(place - 1, BOUND_COLOUR) if place else (0, BOUND_COLOUR)
    return Series(source, tuple(each or 0.0 for each in x), y, low, high, colour, dash)


PANELS: dict[str, Callable[[Result], Iterator[Panel]]] = {
    "sweep": _curves,
    "stress": _stress,
    "breaking-point": _break,
    "compare": _compare,
    "tables": _tables,
    "tune": _tune,
    "diagnosis": _diagnosis,
    "scenes": _scenes,
}


def _panel(
    table: Table, title: str, words: str, by: str | None, metrics: Sequence[str],
    kind: Kind = "rows",
) -> Panel:  # fmt: skip
    """Charts of a table whose column `words` names the rows; by: the column of the series."""
    rows = table.as_records()
    if len({str(row[words]) for row in rows}) > MAX_CHART_ROWS:
        return Panel(title, ())
    charts = []
    for metric in metrics:
        there = [row for row in rows if isinstance(row[metric], float | int)]
        scale = table.typed(metric).scale
        groups: dict[str, list[dict[str, Cell]]] = {}
        for row in there:
            quoted = str(row[words]).startswith(QUOTED_MARK)
            name = str(row[by]) if by else "quoted" if quoted else "measured"
            groups.setdefault(name, []).append(row)
        series = [
            _series(name, group, words, metric, scale, BOUND_COLOUR if name == "quoted" else place)
            for place, (name, group) in enumerate(groups.items())
        ]
        if series:
            shown = title_of(metric)
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
    return Series(
        name, tuple(show_value(row[words]) for row in rows), values(metric), low, high, place
    )


def _rows_chart(
    name: str, title: str, metric: str, scale: float, series: Sequence[Series], kind: Kind = "rows"
) -> Chart:
    """The chart, with its values in words for those who cannot see it."""
    shown = title_of(metric)
    said = [
        f"{each.name}, {x}: {show_value(y, low, high)}"
        for each in series
        for x, y, low, high in each.points()
    ][:MAX_CHART_ROWS]
    unit = f"{shown.removesuffix(' %')}, %" if scale > 1.0 else shown
    about = f"{shown}. {'; '.join(said)}."
    return Chart(name, title, "", unit, tuple(series), kind, about)


def _numbers(table: Table) -> list[str]:
    """The columns that hold numbers, those first that one looks at first."""
    return _in_order([each.column.name for each in shown_columns(table) if each.is_number])


def _in_order(names: Sequence[str]) -> list[str]:
    known = [name for name in FIRST_METRICS if name in names]
    return known + [name for name in names if name not in known]
