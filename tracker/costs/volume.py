"""3D-3D: how much of the new region the expected one covers, on the road plane (eq. 4)."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy import ndarray as Array

from tracker.costs.gating import GatedPairs
from tracker.geometry import convex_intersection


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
        shared = convex_intersection(expected.footprint()[rows], observed.footprint()[columns])
        share = shared / (observed.size[:, 0] * observed.size[:, 2])[columns]
        return 1.0 - np.minimum(share, 1.0)  # areas are off by a rounding
