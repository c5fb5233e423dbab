"""One state per car out of its hypotheses: that of the likeliest direction."""

import numpy as np
from jaxtyping import Float
from numpy import ndarray as Array

from tracker.car_filter.states import YAW, CarStates
from tracker.geometry import wrap_angle
from tracker.types import CarEstimates

# Headings that differ by less count as one direction, rad.
SAME_DIRECTION = np.pi / 4
# Hypotheses with less weight are left out.
MIN_WEIGHT = 1e-4


def estimate(states: CarStates, weights: Float[Array, "n k"]) -> CarEstimates:
    """Mean and covariance of the hypotheses that face the likeliest direction, and how sure it is.

    weights: probabilities of the hypotheses, which sum up to 1 over a row.
    """
    rows = np.arange(len(states))
    yaw = states.means[:, :, YAW]
    alike = np.cos(yaw[:, :, None] - yaw[:, None, :]) > np.cos(SAME_DIRECTION)
    weights = np.where(weights < MIN_WEIGHT, 0.0, weights)
    votes = np.where(weights > 0.0, (alike * weights[:, None, :]).sum(axis=2) + 1e-3 * weights, 0.0)
    best = votes.argmax(axis=1)
    shares = weights * alike[rows, best]
    shares /= shares.sum(axis=1, keepdims=True)
    centre = states.means[rows, best]
    off = states.means - centre[:, None]
    off[:, :, YAW] = wrap_angle(off[:, :, YAW])
    off *= (shares > 0.0)[:, :, None]
    shift = (shares[:, None] @ off)[:, 0]
    off -= shift[:, None]
    spread = (off * shares[:, :, None]).transpose(0, 2, 1) @ off
    n, k, size = states.means.shape
    within = (shares[:, None] @ states.covs.reshape(n, k, size * size)).reshape(n, size, size)
    mean = centre + shift
    same_way = (weights * (np.cos(yaw - mean[:, YAW, None]) > 0.0)).sum(axis=1)
    return CarEstimates(mean, within + spread, same_way / weights.sum(axis=1))
