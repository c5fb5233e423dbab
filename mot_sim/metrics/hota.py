"""HOTA: detection and association in one score, over nineteen strictnesses of overlap.

Luiten et al., HOTA: a higher order metric for evaluating multi-object tracking, IJCV 2021; names
and numbers as in TrackEval 1.3.0.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from jaxtyping import Float, Int
from numpy import ndarray as Array

from mot_sim.metrics.clear import Number
from mot_sim.metrics.matching import EPSILON, Overlaps, match

ALPHAS = np.arange(0.05, 0.99, 0.05)  # the overlap that a match needs: 0.05, 0.10, ..., 0.95
HOTA_RATES = ("HOTA", "DetA", "AssA", "DetRe", "DetPr", "AssRe", "AssPr", "LocA", "OWTA")
HOTA_SCORES = (*HOTA_RATES, "HOTA_TP", "HOTA_FN", "HOTA_FP")


@dataclass(frozen=True, eq=False)
class Hota:
    """HOTA and its parts, one value for every alpha in `ALPHAS`.

    Det: detection, Ass: association, Loc: overlap of the matches; A: accuracy, Re: recall, Pr:
    precision. OWTA is HOTA without false positives. The usual scores are the means over alpha.
    """

    HOTA_TP: Int[Array, " a"]
    """Matches whose IoU is at least alpha."""
    HOTA_FN: Int[Array, " a"]
    """Labels without such a match."""
    HOTA_FP: Int[Array, " a"]
    """Boxes of the output without such a match."""
    AssA: Float[Array, " a"]
    """How well the ids of a match agree over the whole sequence, mean over matches, 0 to 1."""
    AssRe: Float[Array, " a"]
    """Share of the label's boxes that have the match's id, mean over matches, 0 to 1."""
    AssPr: Float[Array, " a"]
    """Share of the id's boxes that meet the match's label, mean over matches, 0 to 1."""
    LocA: Float[Array, " a"]
    """Mean IoU of the matches, 0 to 1; 1 without any."""

    @cached_property
    def DetRe(self) -> Float[Array, " a"]:
        """The share of the labels that are matched."""
        return self.HOTA_TP / np.maximum(1, self.HOTA_TP + self.HOTA_FN)

    @cached_property
    def DetPr(self) -> Float[Array, " a"]:
        """The share of the output that is matched."""
        return self.HOTA_TP / np.maximum(1, self.HOTA_TP + self.HOTA_FP)

    @cached_property
    def DetA(self) -> Float[Array, " a"]:
        """Matches among matches, misses and false positives."""
        return self.HOTA_TP / np.maximum(1, self.HOTA_TP + self.HOTA_FN + self.HOTA_FP)

    @cached_property
    def HOTA(self) -> Float[Array, " a"]:
        """The geometric mean of DetA and AssA."""
        return np.sqrt(self.DetA * self.AssA)

    @cached_property
    def OWTA(self) -> Float[Array, " a"]:
        """The geometric mean of DetRe and AssA."""
        return np.sqrt(self.DetRe * self.AssA)

    @classmethod
    def combine(cls, parts: Sequence["Hota"]) -> "Hota":
        """The scores of all sequences together: counts add up, the rest is weighted by HOTA_TP."""
        found = np.sum([part.HOTA_TP for part in parts], axis=0)

        def per_match(name: str) -> Float[Array, " a"]:
            return np.sum([getattr(part, name) * part.HOTA_TP for part in parts], axis=0)

        return cls(
            HOTA_TP=found,
            HOTA_FN=np.sum([part.HOTA_FN for part in parts], axis=0),
            HOTA_FP=np.sum([part.HOTA_FP for part in parts], axis=0),
            AssA=per_match("AssA") / np.maximum(1, found),
            AssRe=per_match("AssRe") / np.maximum(1, found),
            AssPr=per_match("AssPr") / np.maximum(1, found),
            LocA=mean_overlap(per_match("LocA"), found),
        )

    def by_alpha(self) -> dict[str, list[float]]:
        """The values at every alpha, by name."""
        return {name: getattr(self, name).tolist() for name in HOTA_SCORES}

    def numbers(self) -> dict[str, Number]:
        """Every score by its name: means over alpha, and the values at the least alpha."""
        numbers: dict[str, Number] = {
            name: float(np.mean(getattr(self, name))) for name in HOTA_SCORES
        }
        hota, overlap = float(self.HOTA[0]), float(self.LocA[0])
        return numbers | {"HOTA(0)": hota, "LocA(0)": overlap, "HOTALocA(0)": hota * overlap}


def hota_scores(overlaps: Overlaps) -> Hota:
    """HOTA of one sequence.

    One matching serves all alphas: it maximises overlap times the alignment of the two ids over
    the whole sequence (section 4.3 there), and each alpha keeps of it what overlaps enough.
    """
    matched = match(overlaps, np.arange(len(overlaps.iou)), alignment(overlaps) * overlaps.iou)
    iou = overlaps.iou[matched]
    level = np.searchsorted(ALPHAS - EPSILON, iou, side="right")  # how many alphas it satisfies
    satisfies = level > 0
    level, iou, matched = level[satisfies] - 1, iou[satisfies], matched[satisfies]
    found = at_least(np.bincount(level, minlength=len(ALPHAS)))
    overlap = np.bincount(level, iou, minlength=len(ALPHAS)).astype(float)  # of nothing: integers
    accuracy, recall, precision = association(overlaps, matched, level)
    return Hota(
        HOTA_TP=found,
        HOTA_FN=len(overlaps.truth) - found,
        HOTA_FP=len(overlaps.output) - found,
        AssA=accuracy / np.maximum(1, found),
        AssRe=recall / np.maximum(1, found),
        AssPr=precision / np.maximum(1, found),
        LocA=mean_overlap(at_least(overlap), found),
    )


def alignment(overlaps: Overlaps) -> Float[Array, " p"]:
    """How well the two ids of every pair go together over the whole sequence, in [0, 1]."""
    iou, truth_count, output_count = overlaps.iou, *overlaps.id_counts
    of_row = np.bincount(overlaps.rows, iou)[overlaps.rows]
    of_column = np.bincount(overlaps.columns, iou)[overlaps.columns]
    rivals = of_column + of_row - iou
    exclusive = np.divide(iou, rivals, out=np.zeros_like(iou), where=rivals > EPSILON)
    together = np.bincount(overlaps.id_pairs, exclusive)[overlaps.id_pairs]
    truth_boxes = np.bincount(overlaps.truth.ids, minlength=truth_count)[overlaps.truth_ids]
    output_boxes = np.bincount(overlaps.output.ids, minlength=output_count)[overlaps.output_ids]
    return together / (truth_boxes + output_boxes - together)


def association(
    overlaps: Overlaps, matched: Int[Array, " j"], level: Int[Array, " j"]
) -> tuple[Float[Array, " a"], Float[Array, " a"], Float[Array, " a"]]:
    """AssA, AssRe and AssPr summed over the matches of every alpha.

    level: the largest index of an alpha that a match satisfies.
    """
    _, one_of_each, kind = np.unique(
        overlaps.id_pairs[matched], return_index=True, return_inverse=True
    )
    shape = (len(ALPHAS), len(one_of_each))
    counts = np.bincount(level * shape[1] + kind, minlength=shape[0] * shape[1]).reshape(shape)
    together = at_least(counts)
    members = matched[one_of_each]
    truth_boxes = np.bincount(overlaps.truth.ids)[overlaps.truth_ids[members]]
    output_boxes = np.bincount(overlaps.output.ids)[overlaps.output_ids[members]]
    squared = together * together.astype(float)
    return (
        (squared / np.maximum(1, truth_boxes + output_boxes - together)).sum(axis=1),
        (squared / np.maximum(1, truth_boxes)).sum(axis=1),
        (squared / np.maximum(1, output_boxes)).sum(axis=1),
    )


def at_least(values: Array) -> Array:
    """Sums of the values at an alpha and at all stricter ones."""
    return np.cumsum(values[::-1], axis=0)[::-1]


def mean_overlap(total: Float[Array, " a"], count: Int[Array, " a"]) -> Float[Array, " a"]:
    """The mean overlap of matches; 1 where there is none."""
    return np.maximum(1e-10, total) / np.maximum(1e-10, count)
