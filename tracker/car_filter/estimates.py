"""One state per car out of its hypotheses: that of the likeliest direction."""

import numpy as np
from jaxtyping import Float
from numpy import ndarray as Array

from tracker.car_filter.states import CarStates
from tracker.kernels import Kernel
from tracker.types import CarEstimates

ESTIMATE_CARS = Kernel("tracker.kernels.car_hypotheses", "estimate_cars")
# Headings that differ by less than pi / 4 count as one direction.
COS_SAME_DIRECTION = np.cos(np.pi / 4)
# Hypotheses with less weight are left out.
MIN_WEIGHT = 1e-4


def estimate(states: CarStates, weights: Float[Array, "n k"]) -> CarEstimates:
    """Mean of the hypotheses that face the likeliest direction, and how sure that is.

    The covariance is about that mean, over all hypotheses that do not face the other way: from its
    width alone a car may be turned to the left or to the right. weights: probabilities of the
    hypotheses, which sum up to 1 over a row.
    """
    n, _, size = states.means.shape
    out = np.empty((n, size)), np.empty((n, size, size)), np.empty(n)
    limits = COS_SAME_DIRECTION, MIN_WEIGHT
    ESTIMATE_CARS(states.means, states.covs, weights, *limits, *out)
    return CarEstimates(*out)
