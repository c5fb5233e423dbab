"""Pairwise costs: small = same object. One file a cost; `COSTS` is their register."""

from collections.abc import Callable
from typing import Protocol, runtime_checkable

import numpy as np
from jaxtyping import Float
from numpy import ndarray as Array

from tracker.costs.image_overlap import ImageOverlap
from tracker.costs.pairing import Pairing
from tracker.costs.reprojection import Reprojection
from tracker.costs.volume import Volume


@runtime_checkable
class Cost(Protocol):
    """A pure function of a pairing: one number in [0, 1] a pair, NaN where its cue is missing."""

    def __call__(self, pairing: Pairing) -> Float[Array, " k"]:
        """The cost of every pair of the pairing."""
        ...


COSTS: dict[str, Callable[[], Cost]] = {
    "image_overlap": ImageOverlap,
    "reprojection": Reprojection,
    "volume": Volume,
}

# Weights with their costs: the overall pairwise cost of the paper is their weighted sum.
WeightedCosts = tuple[tuple[float, Cost], ...]


def weighted_sum(
    pairing: Pairing, costs: WeightedCosts
) -> tuple[Float[Array, " k"], tuple[Float[Array, " k"], ...]]:
    """The weighted mean of the costs a pair, and each cost by itself.

    A NaN takes that cost out of its pair and the other weights renormalise; a pair without any
    cost is impossible (inf).
    """
    parts = tuple(cost(pairing) for _, cost in costs)
    if len(parts) == 1:
        return np.where(np.isnan(parts[0]), np.inf, parts[0]), parts
    total = np.zeros(len(pairing.pairs[0]))
    weight = np.zeros(len(total))
    for (share, _), part in zip(costs, parts, strict=True):
        measured = ~np.isnan(part)
        total += np.where(measured, share * part, 0.0)
        weight += share * measured
    return np.divide(total, weight, out=np.full(len(total), np.inf), where=weight > 0.0), parts


__all__ = [
    "COSTS",
    "Cost",
    "ImageOverlap",
    "Pairing",
    "Reprojection",
    "Volume",
    "WeightedCosts",
    "weighted_sum",
]
