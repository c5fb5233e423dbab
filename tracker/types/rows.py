"""What every table of this package shares: rows that are picked and put end to end."""

from collections.abc import Hashable, Sequence
from dataclasses import fields
from functools import cache
from typing import Any, TypeVar

import numpy as np

# An index of rows: a mask, a list of row numbers, or a slice.
RowIndex = Any

# (typing.Self would say the same, but beartype checks methods, not classes.)
Table = TypeVar("Table", bound="Rows")


@cache
def column_names(table: Hashable) -> tuple[str, ...]:
    """The fields of a table; looked up once, for it stands in the tracker's inner loop."""
    return tuple(field.name for field in fields(table))  # type: ignore[arg-type]


class Rows:
    """Mixin for frozen dataclasses whose fields are columns with one entry a row, or None."""

    def __len__(self) -> int:
        return len(getattr(self, column_names(type(self))[0]))

    def select(self: Table, rows: RowIndex) -> Table:
        """The given rows of every column, in the given order."""
        columns: list[Any] = []
        for name in column_names(type(self)):
            column = getattr(self, name)
            if isinstance(column, Rows):
                columns.append(column.select(rows))
            else:
                columns.append(None if column is None else column[rows])
        return type(self)(*columns)

    @classmethod
    def concatenate(cls: type[Table], parts: Sequence[Table]) -> Table:
        """The rows of all parts, in order; a column stays only if every part has it."""
        columns: list[Any] = []
        for name in column_names(cls):
            pieces = [getattr(part, name) for part in parts]
            if any(piece is None for piece in pieces):
                columns.append(None)
            elif isinstance(pieces[0], Rows):
                columns.append(type(pieces[0]).concatenate(pieces))
            else:
                columns.append(np.concatenate(pieces))
        return cls(*columns)
