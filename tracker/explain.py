"""Why a detection got its identity: every cue's cost of every pair of one frame."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, Int
from numpy import ndarray as Array

from tracker.association import Match
from tracker.costs import GatedPairs, WeightedCosts, weighted_sum


@dataclass(frozen=True, eq=False)
class Explanation:
    """Rows = the tracks that were expected, columns = the detections after suppression."""

    frame: int
    """Index of the frame."""
    ids: Int[Array, " n"]
    """Ids of the rows."""
    boxes: Float[Array, "m 4"]
    """Boxes of the columns: x_min, y_min, x_max, y_max, px."""
    gated: Bool[Array, "n m"]
    """Whether the pair lay outside the search area, so that no cost was computed."""
    parts: dict[str, Float[Array, "n m"]]
    """Each cost by its class's name; NaN where gated or not measured."""
    total: Float[Array, "n m"]
    """What was associated: the weighted mean of the costs; inf where gated."""
    matched: Bool[Array, "n m"]
    """Which pairs were made."""
    runner_up: Float[Array, "n m"]
    """For each pair the cheapest total among the others of its row and column; inf without any."""
    pairing: GatedPairs
    """What was compared: beliefs, their regions and search areas."""

    @classmethod
    def of(
        cls,
        frame: int,
        ids: Int[Array, " n"],
        pairing: GatedPairs,
        costs: WeightedCosts,
        total: Float[Array, "n m"],
        match: Match,
    ) -> "Explanation":
        """The explanation of a step, its costs computed once more, one by one."""
        rows, columns = pairing.pairs
        gated = np.ones(pairing.shape, bool)
        gated[rows, columns] = False
        parts = {}
        for (_, cost), part in zip(costs, weighted_sum(pairing, costs).parts, strict=True):
            matrix = np.full(pairing.shape, np.nan)
            matrix[rows, columns] = part
            parts[type(cost).__name__] = matrix
        matched = np.zeros(pairing.shape, bool)
        matched[match.pairs[:, 0], match.pairs[:, 1]] = True
        boxes, others = pairing.observed.boxes, runner_ups(total)
        return cls(frame, ids, boxes, gated, parts, total, matched, others, pairing)

    def lines(self) -> list[str]:
        """A sentence for each pair that was not gated, the made ones first."""
        sentences = []
        rows, columns = np.nonzero(~self.gated)
        pairs = zip(rows.tolist(), columns.tolist(), strict=True)
        for row, column in sorted(pairs, key=self._order):
            cues = ", ".join(f"{name} {part[row, column]:.3f}" for name, part in self.parts.items())
            verdict = "matched" if self.matched[row, column] else "refused"
            total, other = self.total[row, column], self.runner_up[row, column]
            sentences.append(
                f"frame {self.frame}: track {self.ids[row]} with detection {column}: {verdict} at "
                f"{total:.3f} ({cues}); runner-up {other:.3f}"
            )
        return sentences

    def _order(self, pair: tuple[int, int]) -> tuple[bool, float]:
        return not self.matched[pair], float(self.total[pair])


def runner_ups(total: Float[Array, "n m"]) -> Float[Array, "n m"]:
    """For each pair the smallest total of the others in its row and its column."""
    result = np.full(total.shape, np.inf)
    for row, column in np.ndindex(*total.shape):
        others = np.concatenate((np.delete(total[row], column), np.delete(total[:, column], row)))
        result[row, column] = others.min(initial=np.inf)
    return result
