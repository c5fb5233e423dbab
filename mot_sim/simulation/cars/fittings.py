"""What is bolted to the left half of the shell: two wheels, a mirror, half of each plate."""

import numpy as np
from jaxtyping import Float
from numpy import ndarray as Array

from mot_sim.simulation.cars.design import Designs, front_axle, greenhouse, rear_axle

SPOKES = 16  # corners of a wheel; one of them stands on the road
WHEEL_POINTS = 3 * SPOKES + 2  # tyre outside, rim, tyre inside, hub, inner centre
TYRE_WIDTH = 0.20
RIM = 0.68  # radius of the rim over that of the tyre
BOX = np.array([(i, j, k) for i in (0, 1) for j in (0, 1) for k in (0, 1)], dtype=float)


def wheel(designs: Designs, front: bool) -> Float[Array, "n p 3"]:
    """Along, up, left of a left wheel's points."""
    turn = np.linspace(0.0, 2.0 * np.pi, SPOKES, endpoint=False)
    circle = np.stack((np.sin(turn), -np.cos(turn)), axis=1)  # the first corner is the lowest
    circle[0] = (0.0, -1.0)
    rings = np.concatenate((circle, RIM * circle, circle, np.zeros((2, 2))))
    inward = np.repeat([0.02, 0.0, TYRE_WIDTH], SPOKES)
    inward = np.concatenate((inward, [0.025, TYRE_WIDTH]))
    radius = designs["wheel"]
    axle = front_axle(designs) if front else rear_axle(designs)
    outside = 0.5 * designs["width"] - 0.035
    points = np.empty((len(radius), WHEEL_POINTS, 3))
    points[..., 0] = axle[:, None] + radius[:, None] * rings[:, 0]
    points[..., 1] = radius[:, None] * (1.0 + rings[:, 1])
    points[..., 2] = outside[:, None] - inward
    return points


def mirror(designs: Designs, shell_points: Float[Array, "n 19 12 3"]) -> Float[Array, "n 8 3"]:
    """Along, up, left of the left mirror's corners: a box on the door, inside the full width."""
    cowl, roof_front, _, _ = greenhouse(designs)
    half = 0.5 * designs["width"]
    back = np.minimum(0.34, 0.5 * (cowl - roof_front))
    low = np.stack((cowl - back - 0.05, shell_points[:, 5, 6, 1] + 0.03, 0.86 * half), axis=1)
    high = low + np.stack((0.10 + 0 * half, 0.13 + 0 * half, 0.135 * half), axis=1)
    return low[:, None] + BOX * (high - low)[:, None]


def plate(designs: Designs, rows: Float[Array, "n 3 2 3"], front: bool) -> Float[Array, "n 8 3"]:
    """Along, up, left of half a number plate; it is the foremost or the last thing of the car.

    rows: the points inside the front or the rear of the shell, from `cap`.
    """
    middle = 0.5 * (rows[:, 0, 1, 1] + rows[:, 1, 1, 1])
    last = 0.5 * designs["length"]
    rear, ahead = (last - 0.05, last) if front else (-last, 0.05 - last)
    low = np.stack((rear, middle - 0.055, 0 * last), axis=1)
    high = np.stack((ahead, middle + 0.055, 0 * last + 0.26), axis=1)
    return low[:, None] + BOX * (high - low)[:, None]
