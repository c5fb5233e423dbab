"""Identity scores: how long each car keeps the one track id that fits it best.

Ristani et al., Performance measures and a data set for multi-target, multi-camera tracking,
ECCV workshops 2016; names and numbers as in TrackEval 1.3.0.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from mot_sim.metrics.clear import Number
from mot_sim.metrics.matching import Overlaps
from mot_sim.metrics.preprocessing import MIN_OVERLAP

IDENTITY_SCORES = ("IDF1", "IDR", "IDP", "IDTP", "IDFN", "IDFP")


@dataclass(frozen=True, eq=False)
class Identity:
    """How many boxes have the one id that fits their label best over the whole sequence."""

    IDTP: int
    """Boxes with the right track id."""
    IDFN: int
    """Labels without such a box."""
    IDFP: int
    """Boxes of the output without such a label."""

    @property
    def IDR(self) -> float:
        """The share of the labels that have their right track id."""
        return self.IDTP / max(1.0, self.IDTP + self.IDFN)

    @property
    def IDP(self) -> float:
        """The share of the output that has the right track id."""
        return self.IDTP / max(1.0, self.IDTP + self.IDFP)

    @property
    def IDF1(self) -> float:
        """The harmonic mean of IDR and IDP."""
        return self.IDTP / max(1.0, self.IDTP + 0.5 * self.IDFP + 0.5 * self.IDFN)

    @classmethod
    def combine(cls, parts: Sequence["Identity"]) -> "Identity":
        """The scores of all sequences together: counts add up."""
        return cls(
            sum(part.IDTP for part in parts),
            sum(part.IDFN for part in parts),
            sum(part.IDFP for part in parts),
        )

    def numbers(self) -> dict[str, Number]:
        """Every score by its name."""
        return {name: getattr(self, name) for name in IDENTITY_SCORES}


def identity_scores(overlaps: Overlaps) -> Identity:
    """Identity scores of one sequence.

    Labels' and output's ids are matched one to one over the whole sequence so that most boxes
    overlap by MIN_OVERLAP. The smallest sum of misses and false alarms, which the paper asks for,
    is the same: it is all boxes less twice IDTP.
    """
    from scipy.optimize import linear_sum_assignment

    near = overlaps.iou >= MIN_OVERLAP
    truth_count, output_count = overlaps.id_counts
    shared = np.bincount(overlaps.id_pairs[near], minlength=truth_count * output_count)
    shared = shared.reshape(truth_count, output_count)
    IDTP = int(shared[linear_sum_assignment(shared, maximize=True)].sum())
    return Identity(IDTP, len(overlaps.truth) - IDTP, len(overlaps.output) - IDTP)
