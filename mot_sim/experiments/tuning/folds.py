"""Folds of drives that are alike in what makes tracking hard, as the paper asks."""

from collections.abc import Sequence

import numpy as np
from jaxtyping import Float, Int
from numpy import ndarray as Array

from mot_sim.metrics.preprocessing import MAX_OCCLUSION_LEVEL, MAX_TRUNCATION_LEVEL, kind_is
from tracker.errors import BadConfig
from tracker.types import Tracks

TRAITS = ("cars", "boxes", "occluded", "truncated", "approaching", "sideways")
# How much the mere number of drives in a fold counts beside each of the traits.
NUMBER_WEIGHT = 0.05


def traits_of(truth: Tracks) -> Float[Array, " t"]:
    """How much of each of TRAITS a drive holds; sums, so that folds add up.

    cars: identities; boxes: of counted cars; occluded, truncated: boxes of cars that are;
    approaching: change of the height of cars' boxes from frame to frame, in its logarithm;
    sideways: motion of their centres, in heights of the box. The last two tell how the camera
    and the cars move towards each other.
    """
    cars = truth.select(np.flatnonzero(kind_is(truth, "Car", True) & (truth.ids >= 0)))
    none = np.zeros(len(cars), np.int64)
    occluded = (none if cars.occlusion is None else cars.occlusion) > 0
    truncated = (none if cars.truncation is None else cars.truncation) > MAX_TRUNCATION_LEVEL
    hidden = (none if cars.occlusion is None else cars.occlusion) > MAX_OCCLUSION_LEVEL
    approaching, sideways = box_motion(cars)
    counted = ~hidden & ~truncated
    values = (
        len(np.unique(cars.ids[counted])), np.count_nonzero(counted), np.count_nonzero(occluded),
        np.count_nonzero(truncated), approaching, sideways,
    )  # fmt: skip
    return np.array(values, float)


def box_motion(cars: Tracks) -> tuple[float, float]:
    """Summed over neighbouring frames of each car: |change of log height|, |shift| / height."""
    order = np.lexsort((cars.frames, cars.ids))
    boxes, ids, frames = cars.boxes[order], cars.ids[order], cars.frames[order]
    height = np.maximum(boxes[:, 3] - boxes[:, 1], 1.0)
    neighbours = (ids[1:] == ids[:-1]) & (frames[1:] == frames[:-1] + 1)
    grown = np.abs(np.diff(np.log(height)))[neighbours]
    centre = 0.5 * (boxes[:, 0] + boxes[:, 2])
    shifted = (np.abs(np.diff(centre)) / height[1:])[neighbours]
    return float(grown.sum()), float(shifted.sum())


def balanced_folds(traits: Float[Array, "n t"], folds: int) -> Int[Array, " n"]:
    """The fold of every drive, such that all folds have nearly equal shares of every trait.

    The largest drives go first, each to where it balances best; then drives are moved and
    swapped as long as that helps. The same drives give the same folds. Raises BadConfig for fewer
    than 2 folds, and where fewer drives than folds hold any counted car.
    """
    holding = np.count_nonzero(traits[:, TRAITS.index("boxes")] > 0.0)
    if folds < 2:
        raise BadConfig(f"{folds} folds: give 2 or more, each is held out once")
    if holding < folds:
        raise BadConfig(
            f"{folds} folds, but only {holding} of {len(traits)} sequences hold counted cars: "
            "give more sequences or fewer folds"
        )
    shares = shares_of(traits)
    placed = np.full(len(shares), -1)
    for drive in np.argsort(-shares[:, :-1].sum(axis=1), kind="stable").tolist():
        placed[drive] = _best_of([_with(placed, {drive: fold}) for fold in range(folds)], shares)[
            drive
        ]
    while True:
        better = _best_of([placed, *_neighbours(placed, folds)], shares)
        if imbalance(better, shares) > imbalance(placed, shares) - 1e-12:
            return placed
        placed = better


def shares_of(traits: Float[Array, "n t"]) -> Float[Array, "n u"]:
    """Each drive's part of every trait that there is, and a little for being one."""
    there = traits[:, traits.sum(axis=0) > 0.0]
    number = np.full((len(traits), 1), NUMBER_WEIGHT / len(traits))
    return np.concatenate([there / there.sum(axis=0), number], axis=1)


def imbalance(folds: Int[Array, " n"], shares: Float[Array, "n u"]) -> float:
    """The sum of squares of the folds' shares; -1 is no fold yet."""
    here = np.flatnonzero(folds >= 0)
    sums = np.zeros((int(folds.max(initial=0)) + 1, shares.shape[1]))
    np.add.at(sums, folds[here], shares[here])
    return float((sums**2).sum())


def _neighbours(folds: Int[Array, " n"], count: int) -> list[Int[Array, " n"]]:
    """All folds that one move of a drive, or one swap of two, leads to."""
    n = len(folds)
    moves = [_with(folds, {i: f}) for i in range(n) for f in range(count) if f != folds[i]]
    swaps = [
        _with(folds, {i: int(folds[j]), j: int(folds[i])})
        for i in range(n)
        for j in range(i)
        if folds[i] != folds[j]
    ]
    return moves + swaps


def _with(folds: Int[Array, " n"], changes: dict[int, int]) -> Int[Array, " n"]:
    changed = folds.copy()
    for drive, fold in changes.items():
        changed[drive] = fold
    return changed


def _best_of(options: Sequence[Int[Array, " n"]], shares: Float[Array, "n u"]) -> Int[Array, " n"]:
    """The first of those with the least imbalance."""
    return options[int(np.argmin([imbalance(each, shares) for each in options]))]
