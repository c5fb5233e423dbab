"""Optimal two-frame assignment: the paper's association."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy import ndarray as Array

from tracker.association.match import Match
from tracker.errors import BadConfig
from tracker.kernels import Kernel

PAIR_CLEARLY = Kernel("tracker.kernels.pairing", "pair_clearly")


@dataclass(frozen=True)
class Hungarian:
    """The match with the smallest sum of (cost - max_cost): a pair is made only if it gains."""

    max_cost: float = 1.0
    """Pairs that cost as much or more are never made, finite; more: more pairs, and more wrong
    ones."""

    def __post_init__(self) -> None:
        if not np.isfinite(self.max_cost):
            raise BadConfig(f"max_cost {self.max_cost:g}: the largest cost must be finite")

    def __call__(self, costs: Float[Array, "n m"]) -> Match:
        """The optimal match."""
        costs = np.asarray(costs, float)
        n, m = costs.shape
        pairs, lost, new = np.empty((2, n), np.int64), np.empty(n, np.int64), np.empty(m, np.int64)
        count = PAIR_CLEARLY(costs, self.max_cost, pairs, lost, new)
        if count >= 0:
            return Match(pairs[:, :count].T, lost[: n - count], new[: m - count])
        from scipy.optimize import linear_sum_assignment

        gain = np.minimum(costs - self.max_cost, 0.0)
        rows, columns = linear_sum_assignment(gain)
        made = gain[rows, columns] < 0.0
        return Match.of(np.array((rows[made], columns[made])).T, n, m)
