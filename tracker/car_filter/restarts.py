"""Cars of which no hypothesis explains the box any more begin again, beside what was believed."""

import math

import numpy as np
from jaxtyping import Bool, Float, Int
from numpy import ndarray as Array

from tracker.beliefs import BOTTOM_CENTRE
from tracker.car_filter.states import MIN_LOG_WEIGHT, CarStates, normalised
from tracker.types import Camera

# How probable it is, at first, that a car of which nothing fits is another one than believed:
# else its box is wrong, and what was believed fits the next one again.
RESTART_SHARE = 0.5


def restarted(
    states: CarStates, rows: Int[Array, " r"], fresh: CarStates
) -> tuple[CarStates, Bool[Array, "n k"]]:
    """Fresh hypotheses of the cars in `rows` in all columns that are not followed; which they are.

    states: in arrays of their own, which are overwritten.
    """
    is_fresh = np.zeros(states.log_weights.shape, bool)
    is_fresh[rows] = states.log_weights[rows] <= MIN_LOG_WEIGHT
    log_weights, source = states.log_weights.copy(), is_fresh[rows]
    begun = np.where(source, fresh.log_weights, -np.inf)
    begun -= np.logaddexp.reduce(begun, axis=1, keepdims=True)
    log_weights[rows] = np.where(
        source, begun + math.log(RESTART_SHARE), log_weights[rows] + math.log1p(-RESTART_SHARE)
    )
    states.means[is_fresh], states.covs[is_fresh] = fresh.means[source], fresh.covs[source]
    return states.replaced(log_weights=normalised(log_weights)), is_fresh


def places_by_height(
    boxes: Float[Array, "n 4"], size: tuple[float, float, float], camera: Camera
) -> Float[Array, "n 3"]:
    """Centres of the bases of cars of this size that look down the road, by their boxes' heights.

    Nearest face and box have the same height.
    """
    depth = camera.K[1, 1] * size[1] / np.maximum(boxes[:, 3] - boxes[:, 1], 1.0)
    rays = camera.rays_road(boxes.dot(BOTTOM_CENTRE))
    places = rays * depth[:, None]
    distance = np.maximum(np.hypot(places[:, 0], places[:, 2]), 1e-3)
    places[:, 1] = 0.0
    places[:, ::2] *= (1.0 + 0.5 * size[0] / distance)[:, None]
    centres: Float[Array, "n 3"] = places
    return centres
