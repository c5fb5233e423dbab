"""What every table of this package shares: rows that are picked and put end to end."""

from collections.abc import Sequence
from typing import Any, TypeVar

import numpy as np

# An index of rows: a mask, a list of row numbers, or a slice.
RowIndex = Any

# (typing.Self would say the same, but beartype checks methods, not classes.)
Table = TypeVar("Table", bound="Rows")


class Rows:
    """Mixin for frozen dataclasses whose fields are columns with one entry a row, or None."""

    __match_args__: tuple[str, ...] = ()  # the names of the columns, filled in by @dataclass

    def __len__(self) -> int:
        return len(getattr(self, type(self).__match_args__[0]))

    def select(self: Table, rows: RowIndex) -> Table:
        """The given rows of every column, in the given order."""
        table = type(self)
        if not isinstance(rows, np.ndarray):
            rows = np.arange(len(self))[rows]
        elif rows.dtype == bool:
            rows = rows.nonzero()[0]
        columns: list[Any] = []
        for name in table.__match_args__:
            column = getattr(self, name)
            if isinstance(column, np.ndarray):
                columns.append(column.take(rows, axis=0))  # three times faster than column[rows]
            else:
                columns.append(None if column is None else column.select(rows))
        return table(*columns)

    @classmethod
    def concatenate(cls: type[Table], parts: Sequence[Table]) -> Table:
        """The rows of all parts, in order; a column stays only if every part has it."""
        columns: list[Any] = []
        for name in cls.__match_args__:
            pieces = [getattr(part, name) for part in parts]
            if any(piece is None for piece in pieces):
                columns.append(None)
            elif isinstance(pieces[0], Rows):
                columns.append(type(pieces[0]).concatenate(pieces))
            else:
                columns.append(np.concatenate(pieces))
        return cls(*columns)
