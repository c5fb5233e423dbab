"""A sweep as tables: means with intervals, differences, what failed, and what was run."""

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any

import pyarrow as pa

from mot_sim.experiments.sweep.curves import axes_in, metrics_in
from mot_sim.experiments.sweep.paths import Level
from mot_sim.experiments.sweep.summary import METRICS, SummaryRow
from mot_sim.tables import (
    NO_INTERVAL,
    Column,
    Interval,
    Row,
    Table,
    few_seeds_note,
    mean_column,
    with_ends,
)

PRINTED_METRICS = ("HOTA", "AssA", "MOTA", "IDF1", "IDSW")
MAX_ERRORS = 10  # different ones that are printed
INTERVAL_NOTE = (
    "Means over seeds with their 95 % intervals (Student's t); rates are fractions in the file."
)


def words(levels: Mapping[str, Level | None]) -> str:
    """A point as text: the axes that are set, by the last part of their names if that says it."""
    last = [axis.rpartition(".")[2] for axis in levels]
    names = last if len(set(last)) == len(last) else list(levels)
    return ", ".join(
        f"{name}={level:g}" if isinstance(level, float) else f"{name}={level}"
        for name, level in zip(names, levels.values(), strict=True)
        if level is not None
    )


def mean_table(lines: Sequence[SummaryRow], metrics: Sequence[str] = METRICS) -> Table:
    """A row a point and tracker: levels by axis (None: its own value), scores, seeds, failures."""
    table = _of_lines("means", "Scores", lines, metrics, lambda line: line.metrics)
    rows = [(*row, line.failed) for row, line in zip(table.rows, lines, strict=True)]
    return replace(table, columns=(*table.columns, Column.named("failed")), rows=tuple(rows))


def difference_table(lines: Sequence[SummaryRow], metrics: Sequence[str] = METRICS) -> Table | None:
    """The differences to the first tracker, paired by seed; None where there is only one."""
    others = [line for line in lines if line.less is not None]
    if not others:
        return None
    title = f"Differences to {_first(lines)}, seed by seed"
    return _of_lines("differences", title, others, metrics, lambda line: line.less or {})


def _of_lines(
    name: str, title: str, lines: Sequence[SummaryRow], metrics: Sequence[str],
    scores: Callable[[SummaryRow], Mapping[str, Interval]],
) -> Table:  # fmt: skip
    """A row a line, with the intervals that `scores` gives of it."""
    there = [each for each in metrics if each in scores(lines[0])]
    columns: tuple[str | Column, ...] = (
        *lines[0].levels, Column.named("tracker", "name"),
        *(column for each in there for column in with_ends(each)), "seeds",
    )  # fmt: skip
    rows: list[Row] = []
    for line in lines:
        found = scores(line)
        values = (cell for each in there for cell in found.get(each, NO_INTERVAL).cells)
        count = max((each.count for each in found.values()), default=0)
        rows.append((*line.levels.values(), line.tracker, *values, count))
    few = few_seeds_note(int(row[-1] or 0) for row in rows)
    return Table.of(name, title, columns, rows, f"{INTERVAL_NOTE} {few}".strip())


def printed_tables(
    lines: Sequence[SummaryRow], metrics: Sequence[str] = PRINTED_METRICS
) -> list[Table]:
    """Both for the terminal: points in words, a few scores."""
    means, less = mean_table(lines, metrics), difference_table(lines, metrics)
    told = "mean ± half of the 95 % interval, or its ends"
    found = [_printed(means, f"{told}, over the seeds (Student's t); rates in %")]
    if less is not None:
        title = f"less {_first(lines)}, seed by seed: {told}; rates in points"
        found.append(_printed(less, title, is_less=True))
    return found


def _first(lines: Sequence[SummaryRow]) -> str:
    """The tracker that the others are compared with."""
    return next((line.tracker for line in lines if line.less is None), "the first tracker")


def _printed(table: Table, title: str, is_less: bool = False) -> Table:
    """A table of means or differences, its axes in one column of words."""
    axes, metrics = axes_in(table), metrics_in(table)
    seeds = "pairs" if is_less else "seeds"
    columns = (
        Column("point", "name"), Column("tracker", "name"),
        *(each for name in metrics for each in with_ends(mean_column(name, is_signed=is_less))),
        Column(seeds, "count"), *([] if is_less else [Column("failed", "count")]),
    )  # fmt: skip
    place = len(axes)  # of the column `tracker`
    rows: list[Row] = []
    for row in table.rows:
        point = words(dict(zip(axes, row, strict=False)))
        rest = row[place:] if is_less else (*row[place:-1], row[-1] or None)
        rows.append((point, *rest))
    few = few_seeds_note((int(count or 0) for count in table.column("seeds")), seeds[:-1])
    return Table(columns, tuple(rows), title, note=few)


def failure_table(table: pa.Table) -> Table | None:
    """Each different error, its tracker, and how often it came; None where nothing failed."""
    rows = table.select(["tracker", "error"]).to_pylist()
    counted = Counter((row["tracker"], row["error"]) for row in rows if row["error"] is not None)
    if not counted:
        return None
    found = [(tracker, count, error) for (tracker, error), count in counted.most_common()]
    return Table.of("failures", "Trials that failed", ("tracker", "trials", "error"), found)


def failure_lines(table: pa.Table) -> list[str]:
    """Each different error with its tracker and how often it came, the most frequent first."""
    failed = failure_table(table)
    rows = () if failed is None else failed.rows
    lines = [
        f"{tracker}: {count} trial{'s' * (count != 1)} failed: {error}"
        for tracker, count, error in rows[:MAX_ERRORS]
    ]
    more = len(rows) - len(lines)
    return lines + [f"and {more} other errors: see the table's column error"] * (more > 0)


def design_table(design: Mapping[str, Any]) -> Table:
    """The settings of a sweep, from `Design.description()`."""
    plain = ("scene", "frames", "seeds", "first_seed", "mode", "samples", "rules")
    rows: list[Row] = [(name.replace("_", " "), design[name]) for name in plain if design.get(name)]
    for axis, levels in design["axes"].items():
        told = (
            f"{levels['low']:g} to {levels['high']:g}"
            if isinstance(levels, Mapping)
            else ", ".join(f"{each:g}" if isinstance(each, float) else str(each) for each in levels)
        )
        rows.append((f"axis {axis}", told))
    rows += [(f"fixed {axis}", level) for axis, level in design["fixed"].items()]
    for name, settings in design["trackers"].items():
        told = ", ".join(f"{key}={settings[key]}" for key in settings if key != "made_by")
        rows.append((f"tracker {name}", f"{settings['made_by']}{told and ': ' + told}"))
    return Table.of("design", "What was run", ("setting", "value"), rows)


def sweep_tables(
    table: pa.Table, lines: Sequence[SummaryRow], design: Mapping[str, Any]
) -> tuple[Table, ...]:
    """The tables of a sweep: means, differences, failures, and the design."""
    found = (mean_table(lines), difference_table(lines), failure_table(table), design_table(design))
    return tuple(each for each in found if each is not None)


def summary_content(lines: Sequence[SummaryRow]) -> list[dict[str, Any]]:
    """The summary in plain values, ready for JSON."""
    return [
        {
            "levels": line.levels,
            "tracker": line.tracker,
            "failed": line.failed,
            "first_error": line.first_error,
            "metrics": {name: vars(each) for name, each in line.metrics.items()},
            "differences": None
            if line.less is None
            else {name: vars(each) for name, each in line.less.items()},
        }
        for line in lines
    ]
