"""The result of an association: matched pairs, unmatched tracks and unmatched detections."""

from dataclasses import dataclass
from typing import Protocol, runtime_checkable

import numpy as np
from jaxtyping import Float, Int
from numpy import ndarray as Array


@dataclass(frozen=True, eq=False)
class Match:
    """Which tracks (rows) and detections (columns) of a cost matrix belong together."""

    pairs: Int[Array, "k 2"]
    """(row, column)."""
    unmatched_tracks: Int[Array, " l"]
    """Rows without a partner, in order."""
    unmatched_detections: Int[Array, " m"]
    """Columns without a partner, in order."""

    @classmethod
    def of(cls, pairs: Int[Array, "k 2"], rows: int, columns: int) -> "Match":
        """The match of these pairs in a matrix of this many rows and columns."""
        return cls(pairs, _others(pairs[:, 0], rows), _others(pairs[:, 1], columns))


def _others(taken: Int[Array, " k"], count: int) -> Int[Array, " l"]:
    """The numbers below `count` that are not among the taken ones."""
    if len(taken) == count:
        return np.zeros(0, np.int64)
    left = np.ones(count, bool)
    left[taken] = False
    return left.nonzero()[0]


@runtime_checkable
class Associate(Protocol):
    """From a matrix of costs (rows expected, columns observed, inf = impossible) to a match."""

    def __call__(self, costs: Float[Array, "n m"]) -> Match:
        """Every row and every column at most once; no pair costs more than the limit."""
        ...
