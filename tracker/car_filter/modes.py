"""Parked or moving: how cars change from one to the other, and that they do not drive backwards."""

import math

import numpy as np
from jaxtyping import Float, Int
from numpy import ndarray as Array

from tracker.car_filter.states import MIN_LOG_WEIGHT, CarStates
from tracker.kernels import Kernel

# A mode that is less likely than the other by this (nats) has died out.
DEAD_NATS = 3.0
# A heading of which less than exp of this is left gives no new mode.
MIN_SWITCH_LOG_WEIGHT = -4.0
# Slower cars (m/s) may have parked; parked ones start with this std of their speed.
MAX_PARKING_SPEED, STARTING_SPEED_STD = 0.5, 1.5
SWITCHING_LIMITS = np.array([DEAD_NATS, MIN_SWITCH_LOG_WEIGHT, MAX_PARKING_SPEED])
WEIGH_CARS = Kernel("tracker.kernels.car_hypotheses", "weigh_cars")


def weighed(
    states: CarStates,
    before: Float[Array, "n k"],
    fits: Float[Array, "n k"],
    told: Float[Array, "n k"],
    evidence: float,
    switch: float,
) -> tuple[CarStates, Int[Array, "n k"]]:
    """Cars after boxes with the weights that these leave; the hypothesis each one was made of.

    states: after the boxes; their arrays are overwritten. before: logarithms of the weights before
    them. fits, told: nats that the boxes, of which `evidence` counts, and the cues tell. Cars do
    not drive backwards, which counts as well, and they stop and start: with the probability
    `switch` a mode that has died out begins again from the other one.
    """
    log_weights, parents = np.empty(before.shape), np.empty(before.shape, np.int64)
    counted = before, MIN_LOG_WEIGHT, fits, told, evidence
    WEIGH_CARS(states.means, states.covs, *counted, *switching(switch), log_weights, parents)
    return CarStates(states.means, states.covs, log_weights), parents


def switching(switch: float) -> tuple[float, Float[Array, "3"], float]:
    """How modes begin again, as the kernels take it; switch: with which probability."""
    return math.log(switch), SWITCHING_LIMITS, STARTING_SPEED_STD**2
