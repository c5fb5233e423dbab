"""Parked or moving: how cars change from one to the other, and that they do not drive backwards."""

import math

import numpy as np
from jaxtyping import Float, Int
from numpy import ndarray as Array

from tracker.car_filter.states import (
    HEADING_COUNT,
    HYPOTHESIS_COUNT,
    MOVING,
    PARKED,
    SPEED,
    YAW_RATE,
    CarStates,
    normalised,
)

# A mode that is less likely than the other by this (nats) has died out.
DEAD_NATS = 3.0
# A heading of which less than exp of this is left gives no new mode.
MIN_SWITCH_LOG_WEIGHT = -4.0
# Slower cars (m/s) may have parked; parked ones start with this std of their speed.
MAX_PARKING_SPEED, STARTING_SPEED_STD = 0.5, 1.5


def switched(states: CarStates, share: float) -> tuple[CarStates, Int[Array, "n k"]]:
    """Cars stop and start: a mode that has died out begins again from the other one.

    share: the probability with which it does. And the hypothesis that each one was made of.
    """
    parents = np.tile(np.arange(HYPOTHESIS_COUNT), (len(states), 1))
    log_weights, speeds = states.log_weights, states.means[:, MOVING, SPEED]
    parked, moving = log_weights[:, PARKED], log_weights[:, MOVING]
    begin = math.log(share)
    stops = (parked < moving + begin - DEAD_NATS) & (moving > MIN_SWITCH_LOG_WEIGHT)
    stops &= speeds < MAX_PARKING_SPEED
    starts = (moving < parked + begin - DEAD_NATS) & (parked > MIN_SWITCH_LOG_WEIGHT)
    if not (np.count_nonzero(stops) or np.count_nonzero(starts)):
        return states, parents
    log_weights = log_weights.copy()  # means and covariances are this update's own
    for which, source, target, var in (
        (stops, HEADING_COUNT, 0, 0.0),
        (starts, 0, HEADING_COUNT, STARTING_SPEED_STD**2),
    ):
        rows, headings = which.nonzero()
        before, after = (rows, headings + source), (rows, headings + target)
        mean, cov = states.means[before], states.covs[before]
        for column in (SPEED, YAW_RATE):
            mean[:, column] = cov[:, column] = cov[:, :, column] = 0.0
        cov[:, SPEED, SPEED] = var
        states.means[after], states.covs[after] = mean, cov
        log_weights[after] = log_weights[before] + begin
        parents[after] = before[1]
    return states.replaced(log_weights=normalised(log_weights)), parents


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
