"""What an association says: who is who, who was lost, who is new."""

from dataclasses import dataclass
from typing import Protocol, runtime_checkable

import numpy as np
from jaxtyping import Float, Int
from numpy import ndarray as Array


@dataclass(frozen=True, eq=False)
class Match:
    """pairs: (row, column) of what belongs together. lost: rows, new: columns without partner."""

    pairs: Int[Array, "k 2"]
    lost: Int[Array, " l"]
    new: Int[Array, " m"]

    @classmethod
    def of(cls, pairs: Int[Array, "k 2"], rows: int, columns: int) -> "Match":
        """The match of these pairs among so many rows and columns."""
        unmatched_rows, unmatched_columns = np.ones(rows, bool), np.ones(columns, bool)
        unmatched_rows[pairs[:, 0]] = False
        unmatched_columns[pairs[:, 1]] = False
        return cls(pairs, np.flatnonzero(unmatched_rows), np.flatnonzero(unmatched_columns))


@runtime_checkable
class Associate(Protocol):
    """From a matrix of costs (rows expected, columns observed, inf = impossible) to a match."""

    def __call__(self, costs: Float[Array, "n m"]) -> Match:
        """Every row and every column at most once; no pair costs more than the limit."""
        ...
