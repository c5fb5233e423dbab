"""What a sweep's table says: means over seeds with intervals, and differences seed by seed."""

import json
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import pyarrow as pa
from jaxtyping import Float
from numpy import ndarray as Array

from mot_sim.experiments.sweep.paths import Level
from mot_sim.tables import Interval, limits_of

METRICS = ("HOTA", "DetA", "AssA", "MOTA", "IDF1", "CLR_FP", "CLR_FN", "IDSW", "Frag")


@dataclass(frozen=True)
class SummaryRow:
    """A point and tracker of a sweep. levels: by axis, None: its own value.

    metrics: over the seeds without an error. less: the differences to the first tracker, of the
    seeds that both finished, paired; None for the first tracker itself. failed: trials with an
    error, first_error: of the first of them.
    """

    point: int
    levels: dict[str, Level | None]
    tracker: str
    metrics: dict[str, Interval]
    less: dict[str, Interval] | None
    failed: int
    first_error: str | None


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
    """A metric of the trials without an error."""
    return np.array([float(row[name]) for row in trials if row["error"] is None])


def _differences(
    trials: list[dict[str, Any]], rivals: list[dict[str, Any]], name: str
) -> Float[Array, " n"]:
    """A metric less that of the rival, of the seeds that both finished."""
    theirs = {row["seed"]: row[name] for row in rivals if row["error"] is None}
    return np.array(
        [
            float(row[name] - theirs[row["seed"]])
            for row in trials
            if row["error"] is None and row["seed"] in theirs
        ]
    )
