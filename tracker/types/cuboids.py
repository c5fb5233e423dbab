"""Cuboids standing on the road: the tracker's picture of a car in 3D."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy import ndarray as Array

from tracker.types.rows import Rows


@dataclass(frozen=True, eq=False)
class Cuboids(Rows):
    """Cars as upright cuboids in the `road` frame (x right, y down, z forward), metres.

    base: centre of the bottom face. yaw: about road +y, 0 = facing road +x, radians.
    size: length, height, width, i.e. along the object's x (forward), y (down), z (left).
    """

    base: Float[Array, "n 3"]
    yaw: Float[Array, " n"]
    size: Float[Array, "n 3"]

    @classmethod
    def empty(cls) -> "Cuboids":
        """No cuboid at all."""
        return cls(np.zeros((0, 3)), np.zeros(0), np.zeros((0, 3)))

    def footprint(self) -> Float[Array, "n 4 2"]:
        """The four bottom corners on the road plane (x, z), in a constant turning sense."""
        c, s = np.cos(self.yaw), np.sin(self.yaw)
        along = 0.5 * self.size[:, 0]
        across = 0.5 * self.size[:, 2]
        ax, az = along * c, -along * s  # the car's forward half axis
        bx, bz = across * s, across * c  # its left half axis
        x, z = self.base[:, 0], self.base[:, 2]
        corners = np.empty((len(self.yaw), 4, 2))
        corners[:, 0, 0] = x + ax + bx
        corners[:, 0, 1] = z + az + bz
        corners[:, 1, 0] = x - ax + bx
        corners[:, 1, 1] = z - az + bz
        corners[:, 2, 0] = x - ax - bx
        corners[:, 2, 1] = z - az - bz
        corners[:, 3, 0] = x + ax - bx
        corners[:, 3, 1] = z + az - bz
        return corners

    def corners(self) -> Float[Array, "n 8 3"]:
        """The eight corners in the road frame: the footprint, then the same four at the roof."""
        ground = self.footprint()
        corners = np.empty((len(self.yaw), 8, 3))
        corners[:, :4, 0] = corners[:, 4:, 0] = ground[:, :, 0]
        corners[:, :4, 2] = corners[:, 4:, 2] = ground[:, :, 1]
        corners[:, :4, 1] = self.base[:, 1, None]
        corners[:, 4:, 1] = (self.base[:, 1] - self.size[:, 1])[:, None]
        return corners
