"""What a sweep says: means over seeds with intervals, differences seed by seed; its tables."""

import json
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pyarrow as pa
from jaxtyping import Float
from numpy import ndarray as Array

from mot_sim.experiments.sweep.paths import Level
from mot_sim.tables import (
    NO_INTERVAL,
    Column,
    Interval,
    Row,
    Table,
    few_seeds_note,
    limits_of,
    mean_column,
    with_ends,
)

SPATIAL_METRICS = (
    "sAMOTA@0.25", "MOTA3D@0.25", "MOTA3D@2m", "HOTA3D", "centre_median", "within_2m",
    "heading_over_90", "parked_over_1mps",
)  # fmt: skip
METRICS = (
    "HOTA",
    "DetA",
    "AssA",
    "MOTA",
    "IDF1",
    "CLR_FP",
    "CLR_FN",
    "IDSW",
    "Frag",
    *SPATIAL_METRICS,
)
PRINTED_METRICS = ("HOTA", "AssA", "MOTA", "IDF1", "IDSW", *SPATIAL_METRICS)
PRINTED_AS = "mean ± half of the 95 % interval, or its ends"
DIFFERENCES = "differences"  # the name of their table
MAX_ERRORS = 10  # different ones that are printed
INTERVAL_NOTE = (
    "Means over seeds with their 95 % intervals (Student's t); rates are fractions in the file."
)


@dataclass(frozen=True)
class SummaryRow:
    """The scores of one tracker at one point of a sweep."""

    point: int
    """Place of the point in the design, from 0."""
    levels: dict[str, Level | None]
    """Levels by the axis's name; None: the axis keeps its own value."""
    tracker: str
    """The tracker's name."""
    metrics: dict[str, Interval]
    """By metric, the mean over the seeds without an error."""
    less: dict[str, Interval] | None
    """By metric, the mean difference to the first tracker, paired over the seeds that both
    finished; None for the first tracker itself."""
    failed: int
    """Number of trials with an error."""
    first_error: str | None
    """Message of the first error; None: no trial failed."""


def axes_of(table: pa.Table) -> list[str]:
    """The axes of a sweep's table."""
    return list(_design(table)["axes"])


def _design(table: pa.Table) -> dict[str, Any]:
    about = json.loads((table.schema.metadata or {})[b"mot-sim sweep"])
    return about["design"]


def summary(table: pa.Table, metrics: Sequence[str] = METRICS) -> list[SummaryRow]:
    """A line a point and tracker, in the order of the table; metrics that it lacks are left out."""
    axes = axes_of(table)
    rows: dict[tuple[int, str], list[dict[str, Any]]] = {}
    for row in table.to_pylist():
        rows.setdefault((row["point"], row["tracker"]), []).append(row)
    there = [name for name in metrics if name in table.column_names]
    # A half-finished sweep may lack the first tracker at some points.
    first = next(iter(_design(table).get("trackers", {})), next(iter(rows))[1])
    lines = []
    for (point, tracker), trials in rows.items():
        errors = [row["error"] for row in trials if row["error"] is not None]
        rivals = rows.get((point, first), [])
        less = None
        if tracker != first:
            less = {
                name: Interval.of(_differences(trials, rivals, name), limits_of(name, True))
                for name in there
            }
        lines.append(
            SummaryRow(
                point,
                {axis: trials[0][axis] for axis in axes},
                tracker,
                {name: Interval.of(_values(trials, name), limits_of(name)) for name in there},
                less,
                len(errors),
                errors[0] if errors else None,
            )
        )
    return lines


def _values(trials: list[dict[str, Any]], name: str) -> Float[Array, " n"]:
    """A metric of the trials without an error; those in which it is not known are left out."""
    values = [row[name] for row in trials if row["error"] is None]
    return np.array([float(value) for value in values if value is not None])


def _differences(
    trials: list[dict[str, Any]], rivals: list[dict[str, Any]], name: str
) -> Float[Array, " n"]:
    """A metric less that of the rival, of the seeds that both finished."""
    ours, theirs = (
        {row["seed"]: row[name] for row in rows if row["error"] is None and row[name] is not None}
        for rows in (trials, rivals)
    )
    return np.array([float(ours[seed] - theirs[seed]) for seed in ours if seed in theirs])


def words(levels: Mapping[str, Level | None]) -> str:
    """A point as text: the axes that are set, by the last part of their names if that says it."""
    last = [axis.rpartition(".")[2] for axis in levels]
    names = last if len(set(last)) == len(last) else list(levels)
    return ", ".join(
        f"{name}={level:g}" if isinstance(level, float) else f"{name}={level}"
        for name, level in zip(names, levels.values(), strict=True)
        if level is not None
    )


def mean_table(
    lines: Sequence[SummaryRow], metrics: Sequence[str] = METRICS, is_printed: bool = False
) -> Table:
    """A row a point and tracker: levels by axis (None: its own value), scores, seeds, failures.

    is_printed: for the terminal, with the levels in one column of words.
    """
    printed = f"{PRINTED_AS}, over the seeds (Student's t); rates in %"
    table = _of_lines("means", printed if is_printed else "Scores", lines, metrics, is_printed)
    failed = (line.failed or (None if is_printed else 0) for line in lines)
    rows = tuple((*row, count) for row, count in zip(table.rows, failed, strict=True))
    return replace(table, columns=(*table.columns, Column.named("failed")), rows=rows)


def difference_table(
    lines: Sequence[SummaryRow], metrics: Sequence[str] = METRICS, is_printed: bool = False
) -> Table | None:
    """The differences to the first tracker, paired by seed; None where there is only one."""
    others = [line for line in lines if line.less is not None]
    first = next((line.tracker for line in lines if line.less is None), "the first tracker")
    title = f"Differences to {first}, seed by seed"
    if is_printed:
        title = f"less {first}, seed by seed: {PRINTED_AS}; rates in points"
    return _of_lines(DIFFERENCES, title, others, metrics, is_printed) if others else None


def _of_lines(
    name: str, title: str, lines: Sequence[SummaryRow], metrics: Sequence[str], is_printed: bool
) -> Table:
    """A row a line, with the intervals of its scores, or of their differences."""
    is_less = name == DIFFERENCES
    found = [(line.less or {}) if is_less else line.metrics for line in lines]
    there = [each for each in metrics if each in found[0]]
    scores = [mean_column(each, is_signed=is_less) if is_printed else each for each in there]
    seeds = "pairs" if is_less and is_printed else "seeds"
    levels: list[str | Column] = [Column("point", "name")] if is_printed else [*lines[0].levels]
    ends = (column for each in scores for column in with_ends(each))
    columns = (*levels, Column.named("tracker", "name"), *ends, seeds)
    rows: list[Row] = []
    for line, scored in zip(lines, found, strict=True):
        at = [words(line.levels)] if is_printed else line.levels.values()
        values = (cell for each in there for cell in scored.get(each, NO_INTERVAL).cells)
        count = max((each.count for each in scored.values()), default=0)
        rows.append((*at, line.tracker, *values, count))
    few = few_seeds_note((int(row[-1] or 0) for row in rows), seeds[:-1])
    note = few if is_printed else f"{INTERVAL_NOTE} {few}".strip()
    return Table.of(name, title, columns, rows, note)


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
