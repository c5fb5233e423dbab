"""Whether stated uncertainties are honest: shares inside 1 and 2 sigma, NEES, stated chances.

Bar-Shalom, Li & Kirubarajan, Estimation with applications to tracking and navigation, 2001, 5.4:
for a consistent filter the squared errors in units of their covariance (NEES) follow chi-squared
with as many degrees of freedom as the error has components.
"""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from jaxtyping import Float
from numpy import ndarray as Array

from mot_sim.metrics.clear import Number

# Ranges of a stated chance that its truth is shown by.
CHANCE_BINS = (0.5, 0.6, 0.7, 0.8, 0.9, 0.95, 1.0)


def squared_deviations(
    errors: Float[Array, "n k"], covs: Float[Array, "n k k"]
) -> Float[Array, " n"]:
    """e' C^-1 e of every row; NaN where something is unknown or C is not positive definite."""
    squared = np.full(len(errors), np.nan)
    finite = np.isfinite(errors).all(axis=1) & np.isfinite(covs).all(axis=(1, 2))
    rows = np.flatnonzero(finite)
    rows = rows[np.linalg.eigvalsh(covs[rows])[:, 0] > 0.0] if len(rows) else rows
    if len(rows):
        whitened = np.linalg.solve(covs[rows], errors[rows][:, :, None])[:, :, 0]
        squared[rows] = (errors[rows] * whitened).sum(axis=1)
    return squared


@dataclass(frozen=True)
class Consistency:
    """How errors lie in the covariances that were stated for them."""

    components: int
    """Numbers in an error: 2 for a place on the road, 1 for a speed."""
    rows: int
    """Errors whose covariance is stated."""
    inside_1_sigma: float
    """Share of them inside 1 sigma; NaN without any."""
    inside_2_sigma: float
    """Share of them inside 2 sigma; NaN without any."""
    nees: float
    """Mean of the normalised estimation error squared; ideal: `components`. More: overconfident."""

    @classmethod
    def of(cls, squared: Float[Array, " n"], components: int) -> "Consistency":
        """From `squared_deviations` of errors with so many components; NaN rows are left out."""
        known = squared[np.isfinite(squared)]
        if not len(known):
            return cls(components, 0, np.nan, np.nan, np.nan)
        inside_1, inside_2 = (float((known <= sigmas**2).mean()) for sigmas in (1.0, 2.0))
        return cls(components, len(known), inside_1, inside_2, float(known.mean()))

    def ideal(self, sigmas: float) -> float:
        """The share that lies inside so many sigmas when errors are normal and honestly stated."""
        from scipy.special import gammainc

        return float(gammainc(0.5 * self.components, 0.5 * sigmas**2))

    def numbers(self, what: str) -> dict[str, Number]:
        """Every score by its name, which begins with what the errors are of."""
        return {
            f"{what}_inside_1_sigma": self.inside_1_sigma,
            f"{what}_inside_2_sigma": self.inside_2_sigma,
            f"{what}_nees": self.nees,
        }


@dataclass(frozen=True)
class ChanceRange:
    """Stated chances of one range against what came true."""

    low: float
    """Least chance of the range."""
    high: float
    """Largest chance of the range."""
    rows: int
    """How many were stated."""
    stated: float
    """Their mean; NaN without any."""
    came_true: float
    """The share that came true; NaN without any."""


def chances_by_range(
    chances: Float[Array, " n"], came_true: Float[Array, " n"]
) -> list[ChanceRange]:
    """Stated chances, each at least 1/2, by range; rows with NaN in either are left out."""
    known = np.isfinite(chances) & np.isfinite(came_true)
    chances, came_true = chances[known], came_true[known]
    place = np.searchsorted(CHANCE_BINS[1:-1], chances, side="right")
    ranges = []
    for bin_number, (low, high) in enumerate(pairwise(CHANCE_BINS)):
        here = place == bin_number
        count = int(here.sum())
        mean = float(chances[here].mean()) if count else np.nan
        true = float(came_true[here].mean()) if count else np.nan
        ranges.append(ChanceRange(low, high, count, mean, true))
    return ranges


def brier_score(chances: Float[Array, " n"], came_true: Float[Array, " n"]) -> float:
    """Mean squared difference of chances and what came true; 0: all known, 1/4: a coin's."""
    squared = (chances - came_true) ** 2
    squared = squared[np.isfinite(squared)]
    return float(squared.mean()) if len(squared) else np.nan
