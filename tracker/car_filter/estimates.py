"""One state per car out of its hypotheses: that of the likeliest direction."""

import numpy as np
from jaxtyping import Bool, Float, Int
from numpy import ndarray as Array

from tracker.car_filter.states import YAW, CarStates
from tracker.geometry import wrap_angle
from tracker.types import CarEstimates

# Headings that differ by less than pi / 4 count as one direction.
COS_SAME_DIRECTION = np.cos(np.pi / 4)
# Hypotheses with less weight are left out.
MIN_WEIGHT = 1e-4


def likeliest(
    states: CarStates, weights: Float[Array, "n k"]
) -> tuple[Int[Array, " n"], Bool[Array, "n k"], Float[Array, " n"]]:
    """Of each car the likeliest hypothesis of the likeliest direction, and who faces as it does.

    And the probability that the car faces there rather than the other way round.
    """
    yaw = states.means[:, :, YAW]
    ways = np.empty((*yaw.shape, 2))
    ways[:, :, 0], ways[:, :, 1] = np.cos(yaw), np.sin(yaw)
    cosine = ways @ ways.transpose(0, 2, 1)  # of the angles between them
    alike = cosine > COS_SAME_DIRECTION
    votes = (alike @ weights[:, :, None])[:, :, 0] + 1e-3 * weights
    best = np.where(weights > MIN_WEIGHT, votes, 0.0).argmax(axis=1)
    rows = np.arange(len(states))
    heading_known = (weights * (cosine[rows, best] > 0.0)).sum(axis=1)
    return best, alike[rows, best], heading_known


def estimate(states: CarStates, weights: Float[Array, "n k"]) -> CarEstimates:
    """Mean of the hypotheses that face the likeliest direction, and how sure that is.

    The covariance is about that mean, over all hypotheses that do not face the other way: from its
    width alone a car may be turned to the left or to the right. weights: probabilities of the
    hypotheses, which sum up to 1 over a row.
    """
    best, alike, heading_known = likeliest(states, weights)
    centre = states.means[np.arange(len(states)), best]
    off = states.means - centre[:, None]
    off[:, :, YAW] = wrap_angle(off[:, :, YAW])
    shift = (_shares(weights, alike)[:, None] @ np.where(alike[:, :, None], off, 0.0))[:, 0]
    off -= shift[:, None]
    shares = _shares(weights, np.abs(off[:, :, YAW]) < 0.5 * np.pi)
    off *= (shares > 0.0)[:, :, None]
    spread = (off * shares[:, :, None]).transpose(0, 2, 1) @ off
    n, k, size = states.means.shape
    within = (shares[:, None] @ states.covs.reshape(n, k, size * size)).reshape(n, size, size)
    return CarEstimates(centre + shift, within + spread, heading_known)


def _shares(weights: Float[Array, "n k"], chosen: Bool[Array, "n k"]) -> Float[Array, "n k"]:
    """The weights of the chosen hypotheses, which sum up to 1 over a row."""
    shares: Float[Array, "n k"] = weights * chosen * (weights > MIN_WEIGHT)
    return shares / shares.sum(axis=1, keepdims=True)
