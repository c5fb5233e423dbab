"""Boxes carried along by the cars behind them."""

import numpy as np
from jaxtyping import Float, Int
from numpy import ndarray as Array

from tracker.car_filter.motion import CarMotion, RoadStep
from tracker.car_filter.projection import CUBOID_EDGES
from tracker.kernels import Kernel
from tracker.types import Camera
from tracker.types.cuboids import CORNERS

CARRY_BOXES = Kernel("tracker.kernels.car_boxes", "carry_boxes")
EXPECT_BOXES = Kernel("tracker.kernels.car_frames", "expect_boxes")

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


def expected_after(
    boxes: Float[Array, "n 4"],
    predicted: Float[Array, "n 4"],
    hits: Int[Array, " n"],
    states: Float[Array, "n 9"],
    step: RoadStep,
    motion: CarMotion,
    camera: Camera,
) -> Float[Array, "n 4"]:
    """`carried_boxes` of cars in these states through a step; `predicted` after a single hit.

    One detection tells not where a car is going.
    """
    expected = np.empty(boxes.shape)
    moving = states, step.T_road, step.numbers, motion._times, step.log_size
    lens = camera.P_road, camera.far_corner[0], CORNERS, CUBOID_EDGES
    EXPECT_BOXES(boxes, predicted, hits, *moving, *lens, MAX_GROWTH, expected)
    return expected
