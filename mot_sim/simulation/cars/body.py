"""From designs to cars: all points of the shared mesh, in the `object` frame."""

import numpy as np
from jaxtyping import Float
from numpy import ndarray as Array

from mot_sim.simulation.cars.design import Designs
from mot_sim.simulation.cars.fittings import mirror, plate, wheel
from mot_sim.simulation.cars.shell import cap, shell
from mot_sim.simulation.cars.topology import HALF_POINTS, KEYPOINTS, topology


def half_points(designs: Designs) -> Float[Array, "n h 3"]:
    """The left halves of cars: x forward, y down, z left, metres; the wheels stand on y = 0."""
    body = shell(designs)
    front, rear = cap(designs, body, True), cap(designs, body, False)
    count = len(body)
    pieces = (
        body, front, rear, wheel(designs, True), wheel(designs, False), mirror(designs, body),
        plate(designs, front, True), plate(designs, rear, False),
    )  # fmt: skip
    shapes = [(count, int(np.prod(piece.shape[1:-1])), 3) for piece in pieces]
    points = np.concatenate(
        [piece.reshape(shape) for piece, shape in zip(pieces, shapes, strict=True)], axis=1
    )
    assert points.shape[1] == HALF_POINTS
    return points * np.array([1.0, -1.0, 1.0])


def whole(half: Float[Array, "*n h 3"]) -> Float[Array, "*n v 3"]:
    """Cars, or their changes, from their left halves: the right is the exact mirror image."""
    shared = topology()
    sides = np.where(shared.on_right, -1.0, 1.0)
    points = half[..., shared.twins, :]
    points[..., 2] *= sides
    return points


def half_keypoints(half: Float[Array, "*n h 3"]) -> Float[Array, "*n 19 3"]:
    """The named points of the left side (see KEYPOINTS), in that order."""
    first, second = np.array(list(KEYPOINTS.values())).T
    return 0.5 * (half[..., first, :] + half[..., second, :])


def authors_keypoints(half: Float[Array, "*n h 3"]) -> Float[Array, "*n 38 3"]:
    """All keypoints: the authors' rows 0..17, their mirror images 18..35, and the two mirrors."""
    left = half_keypoints(half)
    right = left * np.array([1.0, 1.0, -1.0])
    return np.concatenate(
        (left[..., :18, :], right[..., :18, :], left[..., 18:, :], right[..., 18:, :]), axis=-2
    )
