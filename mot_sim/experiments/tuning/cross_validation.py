"""Weights of costs by cross-validation: random search, then local, on the folds that are not held.

Sharma et al., ICRA 2018: four folds with alike numbers of cars, occlusion, truncation and motion.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import partial
from itertools import permutations

import numpy as np
from jaxtyping import Float, Int
from numpy import ndarray as Array

from mot_sim.experiments.tuning.folds import balanced_folds, traits_of
from mot_sim.experiments.tuning.labelled import LabelledSequence
from mot_sim.experiments.tuning.weighing import WEIGHT_SUM, Scale, Weights, weights_of
from mot_sim.metrics import Scores, combine
from mot_sim.simulation import random_numbers
from tracker.errors import BadConfig

OBJECTIVES = ("HOTA", "MOTA")
MOVE_STEPS = (200, 100, 50, 25)  # of the local search, thousandths of the whole weight
# Called with what is under way, how many weight vectors are done, and of how many.
Progress = Callable[[str, int, int], None]


@dataclass(frozen=True)
class WeightSearch:
    """How the weights of costs are searched. Raises BadConfig for values that are not allowed."""

    objective: str = "HOTA"
    """The score that is maximised, one of OBJECTIVES."""
    samples: int = 60
    """Weight vectors drawn at random besides the fixed ones, 0 or more; more search wider and take
    longer."""
    folds: int = 4
    """Folds of cross-validation, 2 or more, and at most the drives that hold counted cars."""
    seed: int = 0
    """Seed of the random draws."""

    def __post_init__(self) -> None:
        if self.objective not in OBJECTIVES:
            raise BadConfig(f"objective {self.objective}: give {' or '.join(OBJECTIVES)}")
        if self.samples < 0:
            raise BadConfig(f"{self.samples} samples: give 0 or more")


@dataclass(frozen=True, eq=False)
class Fold:
    """A fold that is held out, and the weights that were best on the other folds."""

    held: tuple[str, ...]
    """Names of the drives that are held out."""
    weights: Weights
    """The weights that were best on the other folds, in thousandths."""
    train: float
    """The objective on the other folds."""
    held_out: float
    """The objective on the drives that are held out."""
    switches: int
    """Identity switches on the drives that are held out."""


@dataclass(frozen=True, eq=False)
class Tuned:
    """The result of a search for weights."""

    names: tuple[str, ...]
    """Names of the costs."""
    folds: tuple[Fold, ...]
    """The result of every fold."""
    weights: Weights
    """The mean of the folds' weights, in thousandths, which sum up to 1000."""
    spread: Float[Array, " c"]
    """Standard deviation of each cost's weight over the folds, as a share of the whole weight,
    0..1."""
    overall: float
    """The objective of the mean weights on all drives together."""
    start: float
    """The objective of the weights to begin with, on all drives together."""
    held_out: float
    """The objective on all drives together, each with the weights that were chosen without it."""
    weighed: int
    """Number of weight vectors that were scored, those read from the cache included."""
    fresh: int
    """Number of weight vectors that were scored in this run."""
    balance: Float[Array, "f t"] = field(repr=False)
    """A row per fold: its share, 0..1, of the sum of each of TRAITS over all drives."""

    def spelled(self) -> str:
        """The weights as `--costs` takes them."""
        pairs = zip(self.names, self.weights, strict=True)
        return ",".join(f"{name}={weight / WEIGHT_SUM:g}" for name, weight in pairs if weight)


def tune(
    scale: Scale, search: WeightSearch, start: Sequence[float], tell: Progress | None = None
) -> Tuned:
    """The weights that are best where they were not chosen. start: weights to begin with.

    Raises BadConfig for too few drives, and for weights that cannot be; whatever was weighed
    before stands in the scale's log, so that an interrupted search goes on.
    """
    say = tell or (lambda what, done, total: None)
    traits = np.array([traits_of(drive.truth) for drive in scale.drives])
    placed = balanced_folds(traits, search.folds)
    first = weights_of(start)
    drawn = candidates(first, search)
    scale.weigh(drawn, partial(say, "random search"))
    chosen = []
    for fold in range(search.folds):
        train = [drive for drive, place in zip(scale.drives, placed, strict=True) if place != fold]
        about = partial(say, f"local search, fold {fold + 1} of {search.folds}")
        chosen.append(refined(scale, search, train, drawn, about))
    mean = weights_of(np.mean(chosen, axis=0).tolist())
    scale.weigh([mean])
    shares = np.array([[traits[placed == fold].sum(axis=0)] for fold in range(search.folds)])
    return Tuned(
        names=scale.method.names,
        folds=tuple(
            _fold(scale, search, placed, fold, weights) for fold, weights in enumerate(chosen)
        ),
        weights=mean,
        spread=np.std(np.array(chosen) / WEIGHT_SUM, axis=0, ddof=1),
        overall=worth(scale, search, scale.drives, mean),
        start=worth(scale, search, scale.drives, first),
        held_out=_unseen(scale, search, placed, chosen),
        weighed=len(scale.known),
        fresh=scale.fresh,
        balance=shares[:, 0] / np.maximum(traits.sum(axis=0), 1e-12),
    )


def candidates(start: Weights, search: WeightSearch) -> list[Weights]:
    """What the random search weighs: the start, each cost alone, all alike, then random ones.

    Draws are even over the simplex (Dirichlet's distribution with ones).
    """
    n = len(start)
    alone = [weights_of(row) for row in np.eye(n).tolist()]
    rng = random_numbers.named_stream(search.seed, "tune")
    drawn = [weights_of(row) for row in rng.dirichlet(np.ones(n), search.samples).tolist()]
    return list(dict.fromkeys([start, *alone, weights_of([1.0] * n), *drawn]))


def refined(
    scale: Scale,
    search: WeightSearch,
    train: Sequence[LabelledSequence],
    known: Sequence[Weights],
    tell: Callable[[int, int], None],
) -> Weights:
    """The best of the known weights on these drives, improved by moving weight between costs."""
    value = {each: worth(scale, search, train, each) for each in known}
    best = max(known, key=lambda each: value[each])
    for step in MOVE_STEPS:
        while True:
            near = neighbours(best, step)
            scale.weigh(near, tell)
            value |= {each: worth(scale, search, train, each) for each in near}
            better = max([best, *near], key=lambda each: value[each])
            if value[better] <= value[best]:
                break
            best = better
    return best


def neighbours(weights: Weights, step: int) -> list[Weights]:
    """All vectors that differ by one move of at most `step` thousandths between two costs."""
    found = []
    for giver, taker in permutations(range(len(weights)), 2):
        moved = min(step, weights[giver])
        if moved:
            other = list(weights)
            other[giver] -= moved
            other[taker] += moved
            found.append(tuple(other))
    return list(dict.fromkeys(found))


def worth(
    scale: Scale, search: WeightSearch, drives: Sequence[LabelledSequence], weights: Weights
) -> float:
    """The objective of known weights on some drives together."""
    return float(together(scale, drives, weights)[search.objective])


def together(scale: Scale, drives: Sequence[LabelledSequence], weights: Weights) -> Scores:
    """The scores of known weights on some drives together."""
    return combine([scale.known[weights][drive.name] for drive in drives])


def _fold(
    scale: Scale, search: WeightSearch, placed: Int[Array, " n"], fold: int, weights: Weights
) -> Fold:
    train = [drive for drive, place in zip(scale.drives, placed, strict=True) if place != fold]
    held = [drive for drive, place in zip(scale.drives, placed, strict=True) if place == fold]
    scores = together(scale, held, weights)
    return Fold(
        tuple(drive.name for drive in held),
        weights,
        worth(scale, search, train, weights),
        float(scores[search.objective]),
        int(scores["IDSW"]),
    )


def _unseen(
    scale: Scale, search: WeightSearch, placed: Int[Array, " n"], chosen: Sequence[Weights]
) -> float:
    """The objective over all drives, each by the weights that were chosen without it."""
    scores = [
        scale.known[chosen[fold]][drive.name]
        for drive, fold in zip(scale.drives, placed.tolist(), strict=True)
    ]
    return float(combine(scores)[search.objective])
