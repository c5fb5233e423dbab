"""2D-2D: the overlap of the expected box with the new one."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy import ndarray as Array

from tracker.costs.gating import GatedPairs
from tracker.geometry.overlap import MIN_AREA
from tracker.kernels import Kernel

COST_OF_OVERLAPS = Kernel("tracker.kernels.pairing", "cost_of_overlaps")


@dataclass(frozen=True)
class ImageOverlap:
    """1 - IoU of the expected box (moved by the camera's and the car's motion) and the new one.

    Not of the paper's eqs. 3-6; its Table IV uses such a 2D-2D cue as the baseline.
    """

    buffer: float = 0.0
    """Share of its sides that both boxes are widened by, on each side, so that small and fast cars
    still meet (as C-BIoU does); more: boxes farther apart overlap."""
    drift: float = 0.0
    """Share of its sides per second since the last frame that a detector looked at; both boxes are
    widened by that where it is more than `buffer`."""

    def __call__(self, pairing: GatedPairs) -> Float[Array, " k"]:
        """The cost of every pair of the pairing, in [0, 1]."""
        rows, columns = pairing.pairs
        fraction = max(self.buffer, round(self.drift * pairing.seconds, 6))
        costs = np.empty(len(rows))
        boxes = pairing.expected.boxes, pairing.observed.boxes
        COST_OF_OVERLAPS(*boxes, rows, columns, fraction, MIN_AREA, costs)
        return costs
