"""Greedy assignment: the cheapest pair first."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy import ndarray as Array

from tracker.association.match import Match


@dataclass(frozen=True)
class Greedy:
    """The cheapest pair first, then the cheapest of what is left; ties by row, then column."""

    max_cost: float = 1.0
    """Pairs that cost as much or more are never made; more: more pairs, and more wrong ones."""

    def __call__(self, costs: Float[Array, "n m"]) -> Match:
        """The greedy match."""
        rows, columns = np.nonzero(costs < self.max_cost)
        order = np.argsort(costs[rows, columns], kind="stable")
        free_rows, free_columns = np.ones(costs.shape[0], bool), np.ones(costs.shape[1], bool)
        pairs = []
        for row, column in zip(rows[order].tolist(), columns[order].tolist(), strict=True):
            if free_rows[row] and free_columns[column]:
                free_rows[row] = free_columns[column] = False
                pairs.append((row, column))
        return Match.of(np.array(sorted(pairs), np.int64).reshape(-1, 2), *costs.shape)
