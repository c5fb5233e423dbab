"""3D-3D: how much of the new region the expected one covers, on the road plane (eq. 4)."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy import ndarray as Array

from tracker.costs.gating import GatedPairs
from tracker.kernels import Kernel

COST_OF_VOLUMES = Kernel("tracker.kernels.comparing", "cost_of_volumes")


@dataclass(frozen=True)
class Volume:
    """1 - |expected region n observed region| / |observed region| on the road plane (eq. 4).

    The paper's formula lacks the intersection sign that its code has. Heights are nearly equal
    on a road, so areas serve for volumes, as the paper says.
    """

    def __call__(self, pairing: GatedPairs) -> Float[Array, " k"]:
        """The cost of every pair of the pairing, in [0, 1]."""
        rows, columns = pairing.pairs
        expected, observed = pairing.expected_regions, pairing.observed_regions
        costs = np.empty(len(rows))
        regions = expected.base, expected.yaw, expected.size
        seen = observed.base, observed.yaw, observed.size
        COST_OF_VOLUMES(*regions, *seen, rows, columns, costs)
        return costs
