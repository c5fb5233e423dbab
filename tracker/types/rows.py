"""What every table of this package shares: rows that are picked and put end to end."""

from collections.abc import Sequence
from dataclasses import fields
from typing import Any, Self

import numpy as np

# An index of rows: a mask, a list of row numbers, or a slice.
RowIndex = Any


class Rows:
    """Mixin for frozen dataclasses whose fields are columns with one entry a row, or None."""

    def __len__(self) -> int:
        return len(getattr(self, fields(self)[0].name))  # type: ignore[arg-type]

    def select(self, rows: RowIndex) -> Self:
        """The given rows of every column, in the given order."""
        return type(self)(
            *(
                None if (column := getattr(self, field.name)) is None
                else column.select(rows) if isinstance(column, Rows)
                else column[rows]
                for field in fields(self)  # type: ignore[arg-type]
            )
        )  # fmt: skip

    @classmethod
    def concatenate(cls, parts: Sequence[Self]) -> Self:
        """The rows of all parts, in order; a column stays only if every part has it."""
        columns: list[Any] = []
        for field in fields(cls):  # type: ignore[arg-type]
            pieces = [getattr(part, field.name) for part in parts]
            if any(piece is None for piece in pieces):
                columns.append(None)
            elif isinstance(pieces[0], Rows):
                columns.append(type(pieces[0]).concatenate(pieces))
            else:
                columns.append(np.concatenate(pieces))
        return cls(*columns)
