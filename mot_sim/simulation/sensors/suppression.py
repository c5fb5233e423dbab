"""A detector's own suppression: of two objects' boxes that overlap the weaker is lost or weakened.

Detectors keep one box where several overlap, so that a car close behind another one is lost or
loses score. How much of that is left differs: some cut at an overlap, some hardly do.
"""

from dataclasses import dataclass, field

import numpy as np
from jaxtyping import Bool, Float, Int
from numpy import ndarray as Array
from scipy.special import expit, ndtr

from mot_sim.simulation.sensors.boxes import overlapping_pairs, pair_ids
from mot_sim.simulation.sensors.checks import require_rates, require_table
from mot_sim.simulation.sensors.correlated_noise import (
    Autocorrelation,
    correlated_normals,
)
from mot_sim.simulation.sensors.quantiles import Quantiles

IOU_BINS = (0.3, 0.4, 0.5, 0.6, 0.7)  # lower ends; the last reaches up to 1
SCORE_BINS = (0.0, 0.5, 0.9)  # lower ends, of the weaker one's score
NO_LIMIT = Quantiles((30.0, 30.0))


@dataclass(frozen=True)
class OverlapSuppression:
    """Of two objects' boxes the weaker is dropped, or its score is limited.

    The weaker is the one of the lower score; of equal scores the one whose lower edge is higher in
    the image, then the later row. Boxes that are dropped suppress no others. One number a pair
    that changes slowly decides: who is dropped stays so for a while.
    """

    dropped: tuple[float, ...] = (0.0,) * (len(IOU_BINS) * len(SCORE_BINS))
    """Rate at which the weaker is dropped, 0 to 1: IoU of IOU_BINS by its score of SCORE_BINS, row
    after row; more: fewer cars close behind others."""
    weakened: tuple[float, ...] = (0.0,) * len(IOU_BINS)
    """Rate at which the score of a weaker one that is left is limited, 0 to 1, in each of IOU_BINS;
    more: lower scores of cars close behind others."""
    log_odds: Quantiles = NO_LIMIT
    """Distribution of that limit, log-odds; lower: lower scores."""
    autocorrelation: Autocorrelation = field(default_factory=Autocorrelation)
    """How a pair's number is correlated over time; slower: who is dropped stays so longer."""

    def __post_init__(self) -> None:
        require_table("suppression dropped", IOU_BINS * len(SCORE_BINS), self.dropped)
        require_table("suppression weakened", IOU_BINS, self.weakened)
        require_rates("suppression", *self.dropped, *self.weakened)

    def __call__(
        self,
        frames: Int[Array, " n"],
        ids: Int[Array, " n"],
        boxes: Float[Array, "n 4"],
        scores: Float[Array, " n"],
        seed: int,
        step: float,
        level: float = 1.0,
        score_level: float = 1.0,
    ) -> tuple[Bool[Array, " n"], Float[Array, " n"]]:
        """Which boxes are dropped, and all scores; frames ascend, step: seconds between them.

        level scales the rates; score_level how far limited scores are below 1.
        """
        lost = np.zeros(len(frames), bool)
        first, second, iou = overlapping_pairs(frames, boxes, IOU_BINS[0])
        if level == 0.0 or not len(first):
            return lost, scores
        stronger, weaker = by_strength(first, second, scores, boxes)
        keys = pair_ids(ids[stronger], ids[weaker])
        x = correlated_normals(
            seed, "suppression", keys, frames[weaker], self.autocorrelation, step, 2
        )
        drop, weaken = self.rates(iou, scores[weaker], level)
        chance = ndtr(x[:, 0])
        falls = chance < drop
        fades = ~falls & (chance - drop < (1.0 - drop) * weaken)
        limit = 1.0 - score_level * expit(-self.log_odds.of_normal(x[:, 1]))
        scores = scores.copy()
        # The strongest first: what is dropped suppresses no others.
        order = np.lexsort((weaker, stronger, -scores[stronger], frames[stronger]))
        order = order[falls[order] | fades[order]]
        for pair in order.tolist():
            row = weaker[pair]
            if lost[stronger[pair]] or lost[row]:
                continue
            if falls[pair]:
                lost[row] = True
            else:
                scores[row] = min(scores[row], limit[pair])
        return lost, scores

    def rates(
        self, iou: Float[Array, " p"], scores: Float[Array, " p"], level: float = 1.0
    ) -> tuple[Float[Array, " p"], Float[Array, " p"]]:
        """The rates at which the weaker of each pair is dropped, or else limited; at most 1."""
        row = np.digitize(iou, IOU_BINS) - 1
        column = np.digitize(scores, SCORE_BINS) - 1
        drop = np.array(self.dropped).reshape(len(IOU_BINS), len(SCORE_BINS))[row, column]
        weaken = np.array(self.weakened)[row]
        known = row >= 0
        return (
            np.where(known, np.minimum(level * drop, 1.0), 0.0),
            np.where(known, np.minimum(level * weaken, 1.0), 0.0),
        )


def by_strength(
    first: Int[Array, " p"],
    second: Int[Array, " p"],
    scores: Float[Array, " n"],
    boxes: Float[Array, "n 4"],
) -> tuple[Int[Array, " p"], Int[Array, " p"]]:
    """The stronger and the weaker row of each pair; ties go to the lower edge, then the row."""
    a, b = scores[first], scores[second]
    low_a, low_b = boxes[first, 3], boxes[second, 3]
    second_wins = (b > a) | ((a == b) & (low_b > low_a))
    second_wins |= (a == b) & (low_a == low_b) & (second < first)
    return np.where(second_wins, second, first), np.where(second_wins, first, second)
