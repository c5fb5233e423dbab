"""Where to start a fit: the likeliest yaws of the mean car on the road, all of them tried.

With the viewing rays r of the points, the distance of a car's point from its ray is |(I - r r^T)
(R(yaw) p + t)|. Its square is a quadratic form in (1, cos yaw, sin yaw, x, z): the place comes
out in closed form, and every yaw costs a few multiplications.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, Int
from numpy import ndarray as Array

from tracker.shape.model import DIRECTION_BINS, CarModel
from tracker.shape.projection import YAW, X, Z
from tracker.types import Camera

YAW_COUNT = 72  # how many are tried, 5 degrees apart
MIN_YAWS_APART = 9  # two starts are at least this many of them apart
# How often a keypoint detector finds a point that is there to be seen, and one that is not.
VISIBLE_FOUND_SHARE = 0.7
HIDDEN_FOUND_SHARE = 0.05
MAX_DEPTH = 150.0  # metres


@dataclass(frozen=True, eq=False)
class Rays:
    """The seen points of cars as viewing rays in the road's axes; rows are cars."""

    rays: Float[Array, "n k 3"]
    """Unit vectors from the camera."""
    weights: Float[Array, "n k"]
    """Confidence of each point, 0 to 1; 0 = not seen."""
    mean: Float[Array, "n k 3"]
    """The points on the mean car, `object` frame, metres."""
    var: Float[Array, "n k"]
    """How much each point varies between cars, m^2 along one axis."""
    centre: Float[Array, "3"]
    """Where the camera is in the road frame, metres."""
    sigma: Float[Array, " n"]
    """Std of a point of each car, rad."""

    def rows(self, rows: Array) -> "Rays":
        """The rays of some cars."""
        return Rays(
            self.rays.take(rows, axis=0),
            self.weights.take(rows, axis=0),
            self.mean.take(rows, axis=0),
            self.var.take(rows, axis=0),
            self.centre,
            self.sigma.take(rows),
        )


def rays_to(
    pixels: Float[Array, "n k 2"], camera: Camera
) -> tuple[Float[Array, "n k 3"], Float[Array, "3"]]:
    """Unit viewing rays in the road's axes, and where the camera stands in the road frame."""
    rays = camera.rays_road(pixels)
    rays /= np.linalg.norm(rays, axis=2, keepdims=True)
    return rays, camera.T_road_cam[:3, 3]


def starts(
    given: Rays, model: CarModel, seen: Bool[Array, "n m"], count: int, columns: int
) -> Float[Array, "n h p"]:
    """The unknowns of `count` likely cars a row, the likeliest yaw first, far apart in yaw.

    seen: which of all points of the model were detected; a yaw is likely when those are the ones
    that the car does not hide itself.
    """
    cost, place = scan_yaws(given)
    angle = np.arange(YAW_COUNT) * (2.0 * np.pi / YAW_COUNT)
    cost = cost - visibility_score(model, seen, angle[None], place, given.centre)
    found = np.zeros((len(cost), count, columns))
    rows = np.arange(len(cost))
    for number in range(count):
        best = cost.argmin(axis=1)
        found[:, number, YAW] = angle[best]
        found[:, number, X], found[:, number, Z] = place[rows, best].T
        near = (best[:, None] + np.arange(1 - MIN_YAWS_APART, MIN_YAWS_APART)) % YAW_COUNT
        np.put_along_axis(cost, near, np.inf, axis=1)
    return found


def scan_yaws(given: Rays) -> tuple[Float[Array, "n yaws"], Float[Array, "n yaws 2"]]:
    """For every yaw the cost (a negative log-likelihood) of the best place, and that place."""
    n, k = given.weights.shape
    x, y, z = (given.mean[:, :, axis] for axis in range(3))
    B = np.zeros((n, k, 3, 5))  # a point as seen from the camera is B (1, cos, sin, x, z)
    B[:, :, 0, 0], B[:, :, 2, 0] = -given.centre[0], -given.centre[2]
    B[:, :, 1, 0] = y - given.centre[1]
    B[:, :, 0, 1] = x
    B[:, :, 2, 1], B[:, :, 0, 2] = z, z
    B[:, :, 2, 2] = -x
    B[:, :, 0, 3] = B[:, :, 2, 4] = 1.0
    along = (given.rays[:, :, None] @ B)[:, :, 0]
    weighted = (B * given.weights[:, :, None, None]).reshape(n, 3 * k, 5)
    Q = weighted.transpose(0, 2, 1) @ B.reshape(n, 3 * k, 5)
    Q -= (along * given.weights[:, :, None]).transpose(0, 2, 1) @ along
    place_of = -np.linalg.solve(Q[:, 3:, 3:] + 1e-9 * np.eye(2), Q[:, 3:, :3])
    form = Q[:, :3, :3] + Q[:, :3, 3:] @ place_of
    angle = np.arange(YAW_COUNT) * (2.0 * np.pi / YAW_COUNT)
    turns = np.stack((np.ones(YAW_COUNT), np.cos(angle), np.sin(angle)))
    squares = np.maximum((turns * (form @ turns)).sum(axis=1), 0.0)
    place = (place_of @ turns).transpose(0, 2, 1)
    bad = ~((place[:, :, 1] > 1.0) & (place[:, :, 1] < MAX_DEPTH))
    place[:, :, 1] = np.clip(place[:, :, 1], 2.0, MAX_DEPTH)
    total = np.maximum(given.weights.sum(axis=1), 1e-9)
    var = (given.var * given.weights).sum(axis=1) / total
    distance = (place**2).sum(axis=2)
    cost = 0.5 * squares / (var[:, None] + distance * given.sigma[:, None] ** 2)
    # The variance grows with the distance: a likelihood pays for it.
    cost += total[:, None] * np.log(var[:, None] + distance * given.sigma[:, None] ** 2)
    return cost + 1e3 * bad, place


def visibility_score(
    model: CarModel,
    seen: Bool[Array, "n m"],
    yaw: Float[Array, "#n h"],
    place: Float[Array, "n h 2"],
    centre: Float[Array, "3"],
) -> Float[Array, "n h"]:
    """The log-likelihood of having found exactly those points, for cars at these places."""
    chance = HIDDEN_FOUND_SHARE + (VISIBLE_FOUND_SHARE - HIDDEN_FOUND_SHARE) * model.visibility
    table = seen @ np.log(chance).T + ~seen @ np.log1p(-chance).T
    off = centre[::2] - place
    bins = view_bin(np.arctan2(-off[..., 1], off[..., 0]) - yaw)
    return np.take_along_axis(table, bins, axis=1)


def view_bin(direction: Float[Array, "*n"]) -> Int[Array, "*n"]:
    """The row of `CarModel.visibility` for a direction."""
    return np.floor(direction * (DIRECTION_BINS / (2.0 * np.pi))).astype(np.int64) % DIRECTION_BINS
