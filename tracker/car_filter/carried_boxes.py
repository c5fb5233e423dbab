"""Boxes carried along by the cars behind them."""

import numpy as np
from jaxtyping import Float
from numpy import ndarray as Array

from tracker.car_filter.projection import CUBOID_EDGES
from tracker.kernels import Kernel
from tracker.types import Camera
from tracker.types.cuboids import CORNERS

CARRY_BOXES = Kernel("tracker.kernels.car_boxes", "carry_boxes")

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
    carried = np.empty(boxes.shape)
    lens = camera.P_road, camera.far_corner[0], CORNERS, CUBOID_EDGES
    CARRY_BOXES(boxes, before, after, *lens, MAX_GROWTH, carried)
    return carried
