"""How alike two cars look: the distance of their descriptors (eq. 5)."""

from dataclasses import dataclass
from math import log

import numpy as np
from jaxtyping import Float
from numpy import ndarray as Array

from tracker.costs.gating import GatedPairs
from tracker.errors import BadConfig, BadDetections, MissingCue
from tracker.kernels import Kernel
from tracker.types.embedding import Embedding

SQUARE_DISTANCES = Kernel("tracker.kernels.comparing", "square_distances")


@dataclass(frozen=True)
class Appearance:
    """1 - exp(-eta_app |psi - psi'|^2), eq. 5.

    Unlike the paper: mapped to [0, 1). Descriptors of `tracker.descriptors` have their unit of
    length from data: at distance 1 two cars are as likely one as two. With eta_app = ln 2 such
    a pair costs 1/2.
    """

    eta_app: float = log(2.0)
    """Steepness of the cost, finite and > 0; more: looks that differ a little cost more."""

    def __post_init__(self) -> None:
        if not 0.0 < self.eta_app < np.inf:
            raise BadConfig(f"eta_app {self.eta_app:g}: give a finite number above 0")

    def __call__(self, pairing: GatedPairs) -> Float[Array, " k"]:
        """The cost of every pair; NaN where a descriptor was not measured.

        Raises MissingCue when the detections, or the tracks, have no descriptors at all,
        BadDetections for descriptors of different lengths.
        """
        rows, columns = pairing.pairs
        if not len(rows):
            return np.zeros(0)
        before = _required(pairing.expected.embedding, "tracks")
        now = _required(pairing.observed.embedding, "detections")
        if before.shape[1] != now.shape[1]:
            raise BadDetections(
                f"descriptors of {before.shape[1]} numbers before and of {now.shape[1]} now: "
                "measure all frames with one descriptor, or reset the tracker"
            )
        square = np.empty(len(rows))
        SQUARE_DISTANCES(before, now, rows, columns, square)
        return -np.expm1(-self.eta_app * square)


def _required(look: Embedding | None, whose: str) -> Float[Array, "n d"]:
    """The column, or what to do about its absence."""
    if look is None:
        raise MissingCue(
            f"the cost 'appearance' needs descriptors, which these {whose} do not have: give "
            "Detections the column `descriptor` (see tracker.front_end; --cues appearance or "
            "--cues classical), or leave this cost out"
        )
    return look.descriptor
