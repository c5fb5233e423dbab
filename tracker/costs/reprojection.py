"""3D-2D: how much of the new box lies in the expected search area (eq. 3)."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy import ndarray as Array

from tracker.costs.gating import GatedPairs
from tracker.kernels import Kernel

COST_OF_AREAS = Kernel("tracker.kernels.comparing", "cost_of_areas")


@dataclass(frozen=True)
class Reprojection:
    """1 - |search area n box| / |box|: 0 inside the search area (eq. 3).

    The part of a box outside the image does not count; a box without area costs NaN.
    """

    def __call__(self, pairing: GatedPairs) -> Float[Array, " k"]:
        """The cost of every pair of the pairing, in [0, 1]."""
        rows, columns = pairing.pairs
        costs, far = np.empty(len(rows)), pairing.camera.far_corner
        areas, boxes = pairing.search_areas, pairing.observed.boxes
        COST_OF_AREAS(areas, boxes, far, rows, columns, costs)
        return costs
