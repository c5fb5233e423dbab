"""The box that a car fills in the image, with its derivatives by the state."""

import numpy as np
from jaxtyping import Float
from numpy import ndarray as Array

from tracker.car_filter.states import STATE_SIZE
from tracker.kernels import Kernel
from tracker.types import Camera
from tracker.types.cuboids import CORNERS

# The twelve edges of a cuboid, as pairs of its corners.
CUBOID_EDGES = np.array(
    [(a, b) for a in range(8) for b in range(a) if np.abs(CORNERS[a] - CORNERS[b]).sum() in (1, 2)]
)
PROJECT = Kernel("tracker.kernels.car_boxes", "project_cars")
NO_JACOBIANS = np.zeros((0, 4, STATE_SIZE))


def project_boxes(
    states: Float[Array, "h 9"], camera: Camera
) -> tuple[Float[Array, "h 4"], Float[Array, "h 4 9"]]:
    """The upright boxes around projected cuboids (x_min, y_min, x_max, y_max, px).

    And their Jacobians: each edge is that of the corner which it touches. Boxes are not clipped,
    but of a car that reaches beyond the left or right border of the image, upper and lower edge are
    those of its part inside: the nearest corner, which would be lowest, is not seen.
    """
    jacobians = np.empty((len(states), 4, STATE_SIZE))
    return _projected(states, camera, jacobians), jacobians


def expected_boxes(states: Float[Array, "h 9"], camera: Camera) -> Float[Array, "h 4"]:
    """The boxes of `project_boxes`, without derivatives."""
    return _projected(states, camera, NO_JACOBIANS)


def _projected(
    states: Float[Array, "h 9"], camera: Camera, jacobians: Float[Array, "_ 4 9"]
) -> Float[Array, "h 4"]:
    """The boxes; their derivatives are written to `jacobians`, where it has room for them."""
    boxes = np.empty((len(states), 4))
    far_x, states = camera.far_corner[0], np.ascontiguousarray(states)
    is_derived = len(jacobians) > 0
    PROJECT(states, camera.P_road, far_x, CORNERS, CUBOID_EDGES, boxes, jacobians, is_derived)
    return boxes
