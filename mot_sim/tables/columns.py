"""A column of a table: what its values are, and how they are shown."""

from dataclasses import dataclass
from math import floor, log10
from typing import Literal, get_args

from mot_sim.tables.score_names import is_count, is_rate, title_of

Cell = str | float | int | None
Row = tuple[Cell, ...]
Kind = Literal["name", "text", "rate", "count", "value"]
COLUMN_KINDS: tuple[str, ...] = get_args(Kind)

SAME_HALVES = 1e-9  # halves of an interval that differ by less are alike


@dataclass(frozen=True)
class Column:
    """A column of a table: its title, and how its values are shown."""

    title: str
    """What is shown above it."""
    kind: Kind = "text"
    """name: what a row is of; text: anything in words; rate: fractions, shown in percent; count and
    value: shown with the digits that count."""
    name: str = ""
    """Name of the column in files; empty: its title."""
    digits: int | None = None
    """Digits behind the point, where they are to be the same in all rows."""
    is_signed: bool = False
    """Whether values are differences, shown with their sign."""
    shows_ends: bool = False
    """Whether intervals are always shown by their ends, not as ± half where both halves are
    alike."""

    def __post_init__(self) -> None:
        if not self.name:
            object.__setattr__(self, "name", self.title or "row")

    @classmethod
    def named(cls, name: str, kind: Kind | None = None) -> "Column":
        """What a name stands for in files; without a kind, the one of the score of this name."""
        known: Kind = "rate" if is_rate(name) else "count" if is_count(name) else "value"
        return cls(title_of(name), kind or known, name)

    def show(self, value: Cell, low: Cell = None, high: Cell = None) -> str:
        """The value as text, with its interval where there is one."""
        shown = self._show(value, "+" if self.is_signed else "")
        is_plain = value is None or (low is None and high is None)
        if is_plain or any(isinstance(each, str) for each in (value, low, high)):
            return shown
        half = self._half(float(value or 0.0), low, high)
        if half is None:
            return f"{shown} [{self._show(low) or '…'}, {self._show(high) or '…'}]"
        digits = self._digits if self.kind == "rate" or self.digits is not None else _two_of(half)
        sign = "+" if self.is_signed else ""
        scale = self.scale
        return f"{scale * float(value or 0.0):{sign},.{digits}f} ±{scale * half:,.{digits}f}"

    @property
    def scale(self) -> float:
        """What values are multiplied with to be shown."""
        return 100.0 if self.kind == "rate" else 1.0

    @property
    def _digits(self) -> int:
        return 2 if self.digits is None else self.digits

    def _half(self, value: float, low: Cell, high: Cell) -> float | None:
        """Half of the interval; None where the halves differ, as where an end was clipped."""
        if low is None or high is None or self.shows_ends:
            return None
        half = float(high) - value
        return half if abs(value - float(low) - half) < SAME_HALVES * max(1.0, abs(value)) else None

    def _show(self, value: Cell, sign: str = "") -> str:
        """A value without its interval."""
        if value is None:
            return ""
        if isinstance(value, bool):
            return "yes" if value else "no"
        if isinstance(value, str) or self.kind in ("name", "text"):
            return str(value)
        if self.kind == "rate" or (self.digits is not None and isinstance(value, float)):
            return f"{self.scale * value:{sign},.{self._digits}f}"
        return _digits_that_count(value, sign)


@dataclass(frozen=True)
class ShownColumn:
    """A column as people see it: values, with the ends of their intervals where there are some."""

    column: Column
    """Its title, and how its values are shown."""
    place: int
    """Place of the value in a row."""
    low: int | None
    """Place of the interval's lower end in a row; None: there is none."""
    high: int | None
    """Place of its upper end; None: there is none."""
    is_number: bool
    """Whether it holds numbers and nothing else."""

    def text(self, row: Row) -> str:
        """The cell of a row."""
        low, high = (None if at is None else row[at] for at in (self.low, self.high))
        return self.column.show(row[self.place], low, high)


def show_value(value: Cell, low: Cell = None, high: Cell = None, is_part: bool = False) -> str:
    """A value of no table with its interval; parts of a whole in percent."""
    return Column("", "rate" if is_part else "value").show(value, low, high)


def _digits_that_count(value: float | int, sign: str) -> str:
    if isinstance(value, int):
        return f"{value:{sign},d}"
    size = abs(value)
    if size >= 1000.0 or (value == round(value) and size >= 100.0):
        return f"{value:{sign},.0f}"
    return f"{value:{sign}.3g}" if size < 100.0 else f"{value:{sign}.1f}"


def _two_of(half: float) -> int:
    """Digits behind the point that leave two of half an interval."""
    if half <= 0.0:
        return 2
    return min(max(1 - floor(log10(half)), 0), 4)
