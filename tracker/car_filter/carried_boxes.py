"""Boxes carried along by the cars behind them."""

import numpy as np
from jaxtyping import Float
from numpy import ndarray as Array

from tracker.car_filter.projection import expected_boxes
from tracker.types import Camera

# A box grows or shrinks at most this many times in one step.
MAX_GROWTH = 5.0


def carried_boxes(
    boxes: Float[Array, "n 4"],
    before: Float[Array, "n 9"],
    after: Float[Array, "n 9"],
    camera: Camera,
) -> Float[Array, "n 4"]:
    """Boxes of cars in state `before`, moved and scaled as their cuboids are until `after`.

    Where the box and the projected cuboid disagree they go on to do so, in proportion.
    """
    old, new = np.split(expected_boxes(np.concatenate((before, after)), camera), 2)
    growth = (new[:, 2:] - new[:, :2]) / np.maximum(old[:, 2:] - old[:, :2], 1.0)
    growth = np.minimum(np.maximum(growth, 1.0 / MAX_GROWTH), MAX_GROWTH)
    off = boxes[:, :2] + boxes[:, 2:] - old[:, :2] - old[:, 2:]
    middle = 0.5 * (new[:, :2] + new[:, 2:] + off * growth)
    half = 0.5 * (boxes[:, 2:] - boxes[:, :2]) * growth
    return np.concatenate((middle - half, middle + half), axis=1)
