"""Tables that were made to be looked at, as plain values."""

import re
from typing import Any

from mot_sim.experiments.results.result_file import Cell, ResultTable
from mot_sim.tables.grid import RATES, Table

# What `mot_sim.experiments.sweep.summary_tables.shown` writes: a mean, and half of its interval.
MEAN = re.compile(r"^([+-]?[\d.]+) ±([\d.]+)$")


def ends(name: str) -> tuple[str, str, str]:
    """The columns of a value and of the ends of its interval."""
    return name, f"{name} low", f"{name} high"


def result_table(name: str, table: Table) -> ResultTable:
    """A shown table as plain values; "mean ± half" becomes three columns, rates fractions."""
    titles = [column.title or "row" for column in table.columns]
    columns: list[str] = []
    parts: list[list[tuple[Cell, ...]]] = []
    for place, title in enumerate(titles):
        cells = [row[place] for row in table.rows]
        is_mean = any(isinstance(cell, str) and MEAN.match(cell) for cell in cells)
        columns += ends(title) if is_mean else (title,)
        scale = 0.01 if title.split(" - ")[0] in RATES else 1.0
        parts.append([_parts(cell, scale) if is_mean else (plain(cell),) for cell in cells])
    rows = tuple(
        tuple(cell for part in parts for cell in part[number]) for number in range(len(table.rows))
    )
    return ResultTable(name, table.title, tuple(columns), rows)


def _parts(cell: Any, scale: float) -> tuple[Cell, ...]:
    """A mean and the ends of its interval, from how they are shown."""
    found = MEAN.match(cell) if isinstance(cell, str) else None
    if found is not None:
        mean, half = float(found[1]), float(found[2])
        return scale * mean, scale * (mean - half), scale * (mean + half)
    try:
        return scale * float(cell), None, None
    except (TypeError, ValueError):
        return None, None, None


def plain(value: Any) -> Cell:
    """A value of a table: a number of Python instead of NumPy's."""
    return value.item() if hasattr(value, "item") else value
