"""Values of tables as a reader wants them: percent, digits that count, intervals in one place."""

from collections.abc import Sequence
from dataclasses import dataclass
from math import floor, log10

from mot_sim.experiments.results.result_file import Cell, ResultTable
from mot_sim.experiments.sweep.curves import is_rate
from mot_sim.plotting.charts import Place
from mot_sim.tables.grid import COUNTS, RATES

TITLES = {name: title for title, name in (RATES | COUNTS).items()}  # by TrackEval's name
FRACTIONS = ("MTR", "PTR", "MLR", "MT %", "PT %", "ML %", "score from", "share", "fall")
SAME = 1e-9  # halves of an interval that differ by less are alike


@dataclass(frozen=True)
class ShownColumn:
    """A column to show: its title, the columns it is made of, and whether it holds numbers."""

    title: str
    name: str
    low: str | None = None
    high: str | None = None
    is_number: bool = False
    is_fraction: bool = False


def shown_columns(table: ResultTable) -> list[ShownColumn]:
    """The columns of a table, with the ends of an interval in that of its value."""
    ends = {
        f"{name} {end}"
        for name in table.columns
        for end in ("low", "high")
        if {f"{name} low", f"{name} high"} <= set(table.columns)
    }
    found = []
    for name in table.columns:
        if name in ends:
            continue
        has_ends = f"{name} low" in ends
        values = [value for value in table.column(name) if value is not None]
        if table.rows and not values and not has_ends:
            continue  # a column of nothing, such as the errors where there are none
        is_number = bool(values) and all(
            isinstance(value, float | int) and not isinstance(value, bool) for value in values
        )
        is_part = is_number and is_fraction(name, table)
        title = TITLES.get(name, name)
        title = f"{title.removesuffix(' %')}, %" if is_part else title
        found.append(
            ShownColumn(
                title, name, f"{name} low" if has_ends else None,
                f"{name} high" if has_ends else None, is_number or has_ends, is_part,
            )
        )  # fmt: skip
    return found


def is_fraction(name: str, table: ResultTable) -> bool:
    """Whether a column holds fractions that are shown in percent."""
    base = name.partition(" - ")[0].removesuffix(" of the others").removesuffix(" held out")
    return is_rate(base) or base.lower() in FRACTIONS or base in FRACTIONS


def number(value: float | int, is_part: bool = False, sign: str = "") -> str:
    """A number with the digits that count; parts in percent with two."""
    if is_part:
        return f"{100.0 * value:{sign}.2f}"
    if isinstance(value, int):
        return f"{value:{sign},d}"
    size = abs(value)
    if size >= 1000.0 or (value == round(value) and size >= 100.0):
        return f"{value:{sign},.0f}"
    return f"{value:{sign}.3g}" if size < 100.0 else f"{value:{sign}.1f}"


def word(value: Cell, is_part: bool = False, sign: str = "") -> str:
    """A value without an interval."""
    if value is None:
        return ""
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, str):
        return value
    return number(value, is_part, sign)


def with_ends(value: Cell, low: Cell, high: Cell, is_part: bool = False, sign: str = "") -> str:
    """A value with its interval: ± half of it where both halves are alike, else its ends."""
    shown = word(value, is_part, sign)
    if isinstance(value, str) or isinstance(low, str) or isinstance(high, str):
        return shown
    if value is None or (low is None and high is None):
        return shown
    if low is not None and high is not None:
        half = high - value
        if abs((value - low) - half) < SAME * max(1.0, abs(value)):
            if is_part:
                return f"{shown} ±{100.0 * half:.2f}"
            digits = _digits(half)
            return f"{value:{sign},.{digits}f} ±{half:,.{digits}f}"
    return f"{shown} [{word(low, is_part) or '…'}, {word(high, is_part) or '…'}]"


def _digits(half: float) -> int:
    """Digits behind the point that leave two of half an interval."""
    if half <= 0.0:
        return 2
    return min(max(1 - floor(log10(half)), 0), 4)


def point(table: ResultTable, row: Sequence[Cell], names: Sequence[str]) -> str:
    """Levels of a row in words: `jitter=2`."""
    values = dict(zip(table.columns, row, strict=True))
    return ", ".join(
        f"{name.rpartition('.')[2]}={word(values[name])}"
        for name in names
        if values[name] is not None
    )


def chart_place(value: Cell) -> Place:
    """Where a value stands in a chart."""
    return word(value) if value is None or isinstance(value, str | bool) else value


__all__ = [
    "ShownColumn",
    "chart_place",
    "is_fraction",
    "number",
    "point",
    "shown_columns",
    "with_ends",
    "word",
]  # fmt: skip
