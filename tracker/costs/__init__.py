"""Pairwise costs: small = same object. One file a cost; `COSTS` is their register."""

from collections.abc import Callable
from math import isnan
from typing import NamedTuple, Protocol, runtime_checkable

import numpy as np
from jaxtyping import Float
from numpy import ndarray as Array

from tracker.costs.appearance import Appearance
from tracker.costs.gating import GatedPairs
from tracker.costs.image_overlap import ImageOverlap
from tracker.costs.reprojection import Reprojection
from tracker.costs.shape_pose import ShapeAndPose
from tracker.costs.volume import Volume


@runtime_checkable
class Cost(Protocol):
    """A pure function of a pairing: one number in [0, 1] a pair, NaN where its cue is missing."""

    def __call__(self, pairing: GatedPairs) -> Float[Array, " k"]:
        """The cost of every pair of the pairing."""
        ...


COSTS: dict[str, Callable[[], Cost]] = {
    "appearance": Appearance,
    "image_overlap": ImageOverlap,
    "reprojection": Reprojection,
    "shape_pose": ShapeAndPose,
    "volume": Volume,
}

# Weights with their costs: the overall pairwise cost of the paper is their weighted sum.
WeightedCosts = tuple[tuple[float, Cost], ...]


class Sum(NamedTuple):
    """The overall pairwise cost, and what it was made of; one entry per pair."""

    total: Float[Array, " k"]
    """Weighted mean of the costs, 0 to 1; inf where no cost could be measured."""
    parts: tuple[Float[Array, " k"], ...]
    """Each cost by itself, in the order of the weights; NaN where its cue is missing."""
    unmeasured: int
    """How many numbers in `parts` are NaN."""


def weighted_sum(pairing: GatedPairs, costs: WeightedCosts) -> Sum:
    """The overall pairwise cost of the paper, divided by the sum of the weights.

    A NaN takes that cost out of its pair and the other weights renormalise; a pair without any
    cost is impossible (inf).
    """
    parts = tuple([cost(pairing) for _, cost in costs])
    if len(parts) == 1 and not isnan(np.dot(parts[0], parts[0])):  # nor is one of them
        return Sum(parts[0], parts, 0)
    each = np.array([weight for weight, _ in costs])
    total = each[0] * parts[0]
    for weight, part in zip(each[1:], parts[1:], strict=True):
        total += weight * part
    if not isnan(np.dot(total, total)):
        return Sum(total / each.sum(), parts, 0)
    values = np.array(parts)
    weights, measured = each[:, None], ~np.isnan(values)
    shares = weights * measured
    share = shares.sum(axis=0)
    total = np.full(len(share), np.inf)
    np.divide((shares * np.where(measured, values, 0.0)).sum(axis=0), share, total, where=share > 0)
    return Sum(total, parts, int(measured.size - np.count_nonzero(measured)))


__all__ = [
    "COSTS",
    "Appearance",
    "Cost",
    "GatedPairs",
    "ImageOverlap",
    "Reprojection",
    "ShapeAndPose",
    "Sum",
    "Volume",
    "WeightedCosts",
    "weighted_sum",
]
