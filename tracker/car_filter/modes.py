"""Parked or moving: how cars change from one to the other, and that they do not drive backwards."""

import math

import numpy as np
from jaxtyping import Float, Int
from numpy import ndarray as Array

from tracker.car_filter.states import HYPOTHESIS_COUNT, CarStates
from tracker.kernels import Kernel

# A mode that is less likely than the other by this (nats) has died out.
DEAD_NATS = 3.0
# A heading of which less than exp of this is left gives no new mode.
MIN_SWITCH_LOG_WEIGHT = -4.0
# Slower cars (m/s) may have parked; parked ones start with this std of their speed.
MAX_PARKING_SPEED, STARTING_SPEED_STD = 0.5, 1.5
SWITCHING_LIMITS = np.array([DEAD_NATS, MIN_SWITCH_LOG_WEIGHT, MAX_PARKING_SPEED])
SWITCH_MODES = Kernel("tracker.kernels.car_hypotheses", "switch_modes")


def switched(states: CarStates, share: float) -> tuple[CarStates, Int[Array, "n k"]]:
    """Cars stop and start: a mode that has died out begins again from the other one.

    share: the probability with which it does. And the hypothesis that each one was made of. The
    arrays of `states` are overwritten.
    """
    parents = np.empty((len(states), HYPOTHESIS_COUNT), np.int64)
    limits = SWITCHING_LIMITS, STARTING_SPEED_STD**2
    SWITCH_MODES(states.means, states.covs, states.log_weights, math.log(share), *limits, parents)
    return states, parents


def forward_log_probability(
    speeds: Float[Array, " h"], variances: Float[Array, " h"]
) -> Float[Array, " h"]:
    """Log-probability that cars which seem to drive backwards do not."""
    from scipy.special import log_ndtr

    backwards = speeds < 0.0
    if not np.count_nonzero(backwards):
        return np.zeros(len(speeds))
    deviation = np.minimum(speeds, 0.0) / np.sqrt(np.maximum(variances, 1e-9))
    log_probability: Float[Array, " h"] = np.where(backwards, log_ndtr(deviation), 0.0)
    return log_probability
