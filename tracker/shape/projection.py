"""Where a car's points appear, and how that changes with its pose and shape.

The unknowns of a car, in this order: x, y, z of its base in the road frame, yaw, the logarithm
of its scale, and the coefficients of eq. 1. X_road = base + scale R(yaw) (mean + sum lambda V).
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int
from numpy import ndarray as Array

X, Y, Z, YAW, SCALE, SHAPE = range(6)  # SHAPE: the first coefficient
MIN_POINT_DEPTH = 0.5  # metres before the camera: no point of a car that is seen lies nearer


@dataclass(frozen=True, eq=False)
class ObservedPoints:
    """Points seen of cars; rows are cars, padded with weight 0 to the same number of points.

    The points stand on the last axis, where arithmetic on arrays is fastest.
    """

    pixels: Float[Array, "n 2 k"]
    """u, v, px."""
    weights: Float[Array, "n 2 k"]
    """1 / sigma^2 of u and v, px^-2; 0: padding."""
    mean: Float[Array, "n 3 k"]
    """The points on the mean car, `object` frame, metres."""
    vectors: Float[Array, "n 3 b k"]
    """How they move with each coefficient of eq. 1, metres."""
    P: Float[Array, "3 4"]
    """Projects homogeneous points of the road frame to pixels."""

    def rows(self, rows: Int[Array, " m"]) -> "ObservedPoints":
        """The points of some cars, repeated as often as they are named."""
        return ObservedPoints(
            self.pixels.take(rows, axis=0),
            self.weights.take(rows, axis=0),
            self.mean.take(rows, axis=0),
            self.vectors.take(rows, axis=0),
            self.P,
        )

    def weighted(self, weights: Float[Array, "n 2 k"]) -> "ObservedPoints":
        """The same points with other weights."""
        return ObservedPoints(self.pixels, weights, self.mean, self.vectors, self.P)


def residuals(
    observed: ObservedPoints, cars: Float[Array, "n p"], free: Int[Array, " f"]
) -> tuple[Float[Array, "n 2 k"], Float[Array, "n f 2 k"], Float[Array, "n k"]]:
    """Expected minus seen pixels, their derivatives by the `free` unknowns, and depths.

    free: X to YAW, then perhaps SCALE, then all coefficients or none. Points nearer than
    NEAREST are drawn to that depth, so that numbers stay finite.
    """
    c, s = np.cos(cars[:, YAW, None]), np.sin(cars[:, YAW, None])
    scale = np.exp(cars[:, SCALE, None])
    shape = (cars[:, None, None, SHAPE:] @ observed.vectors)[:, :, 0] + observed.mean
    shape *= scale[:, None]
    turned = np.empty_like(shape)
    turned[:, 0] = c * shape[:, 0] + s * shape[:, 2]
    turned[:, 1] = shape[:, 1]
    turned[:, 2] = c * shape[:, 2] - s * shape[:, 0]
    P = observed.P
    seen = P[:, :3] @ (turned + cars[:, X : Z + 1, None]) + P[:, 3:]
    depth = seen[:, 2]
    inverse = (1.0 / np.maximum(depth, MIN_POINT_DEPTH))[:, None]
    uv = seen[:, :2] * inverse
    by_x, by_y, by_z = ((P[:2, axis, None] - uv * P[2, axis]) * inverse for axis in (X, Y, Z))
    jacobian = np.empty((len(cars), len(free), *uv.shape[1:]))
    jacobian[:, X], jacobian[:, Y], jacobian[:, Z] = by_x, by_y, by_z
    jacobian[:, YAW] = by_x * turned[:, 2:] - by_z * turned[:, :1]
    has_scale = len(free) > SCALE and free[SCALE] == SCALE
    if has_scale:
        jacobian[:, SCALE] = by_x * turned[:, :1] + by_y * turned[:, 1:2] + by_z * turned[:, 2:]
    first = SCALE + int(has_scale)
    if len(free) > first:
        by_shape = jacobian[:, first:]
        axes = scale[:, None] * (c[:, None] * by_x - s[:, None] * by_z), scale[:, None] * by_y
        np.multiply(axes[0][:, None], observed.vectors[:, 0, :, None], out=by_shape)
        by_shape += axes[1][:, None] * observed.vectors[:, 1, :, None]
        left = scale[:, None] * (s[:, None] * by_x + c[:, None] * by_z)
        by_shape += left[:, None] * observed.vectors[:, 2, :, None]
    return uv - observed.pixels, jacobian, depth
