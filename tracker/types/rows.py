"""What every table of this package shares: rows that are picked and put end to end."""

from collections.abc import Sequence
from typing import Any, TypeVar

import numpy as np

# An index of rows: a mask, a list of row numbers, or a slice.
RowIndex = Any

# (typing.Self would say the same, but beartype checks methods, not classes.)
Table = TypeVar("Table", bound="Rows")


class Rows:
    """Mixin for frozen dataclasses whose fields are columns with one entry a row, or None.

    New tables are made of a dict of columns, not by the constructor, which costs a frozen
    dataclass three times as much: a tracker makes dozens of small tables a frame.
    """

    __match_args__: tuple[str, ...] = ()  # the names of the columns, filled in by @dataclass

    def __len__(self) -> int:
        return len(self.__dict__[self.__match_args__[0]])

    def select(self: Table, rows: RowIndex) -> Table:
        """The given rows of every column, in the given order."""
        if not isinstance(rows, np.ndarray):
            rows = np.arange(len(self))[rows]
        elif rows.dtype.kind == "b":
            rows = rows.nonzero()[0]
        return self.take(rows)

    def take(self: Table, rows: RowIndex, axis: int = 0) -> Table:
        """`select` for an array of row numbers; called as NumPy's `take`, so that tables nest.

        Of an array it takes a third of the time of `array[rows]`.
        """
        mine, columns = self._columns(), {}
        for name in self.__match_args__:
            column = mine[name]
            columns[name] = None if column is None else column.take(rows, 0)
        return assembled(type(self), columns)

    def replaced(self: Table, **columns: Any) -> Table:
        """The same table with other columns of these names."""
        kept = self._columns().copy()
        if len(kept) > len(self.__match_args__):  # what was derived of the columns and kept
            kept = {name: kept[name] for name in self.__match_args__}
        kept.update(columns)
        return assembled(type(self), kept)

    def copied(self: Table) -> Table:
        """The same rows in arrays of their own."""
        mine = self._columns()
        columns: dict[str, Any] = {}
        for name in self.__match_args__:
            column = mine[name]
            if isinstance(column, np.ndarray):
                columns[name] = column.copy()
            else:
                columns[name] = None if column is None else column.copied()
        return assembled(type(self), columns)

    def locked(self: Table) -> Table:
        """This table itself, whose arrays can no longer be written to: NumPy raises ValueError."""
        mine = self.__dict__
        for name in self.__match_args__:
            column = mine.get(name)
            if isinstance(column, np.ndarray):
                column.setflags(False)  # type: ignore[call-arg]  # by name it takes twice as long
            elif column is not None:
                column.locked()
        return self

    def updated(self: Table, rows: RowIndex, others: Table) -> Table:
        """The same table with the rows of another one in these places.

        A column stays only if both have it.
        """
        mine, theirs = self._columns(), others._columns()
        columns: dict[str, Any] = {}
        for name in self.__match_args__:
            column, other = mine[name], theirs[name]
            if column is None or other is None:
                columns[name] = None
            elif isinstance(column, np.ndarray):
                columns[name] = column.copy()
                columns[name][rows] = other
            else:
                columns[name] = column.updated(rows, other)
        return assembled(type(self), columns)

    @classmethod
    def concatenate(cls: type[Table], parts: Sequence[Table]) -> Table:
        """The rows of all parts, in order; a column stays only if every part with rows has it."""
        tables = [part._columns() for part in [each for each in parts if len(each)] or parts]
        columns: dict[str, Any] = {}
        for name in cls.__match_args__:
            pieces = [table[name] for table in tables]
            if any(piece is None for piece in pieces):
                columns[name] = None
            elif isinstance(pieces[0], np.ndarray):
                columns[name] = np.concatenate(pieces)
            else:
                columns[name] = type(pieces[0]).concatenate(pieces)
        return assembled(cls, columns)

    def _columns(self) -> dict[str, Any]:
        """All columns by their names, perhaps with what was derived of them."""
        return self.__dict__


def assembled(kind: type[Table], columns: dict[str, Any]) -> Table:
    """A table of these columns."""
    table = object.__new__(kind)
    object.__setattr__(table, "__dict__", columns)
    return table
