"""Cuboids standing on the road: the tracker's picture of a car in 3D."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from jaxtyping import Float
from numpy import ndarray as Array

from tracker.types.packed import ColumnBlock, PackedRows

# Where the corners lie along the half axes: forward, down, left. The roof is one height up.
CORNERS = np.array([
    [1, 0, 1], [-1, 0, 1], [-1, 0, -1], [1, 0, -1],
    [1, -1, 1], [-1, -1, 1], [-1, -1, -1], [1, -1, -1],
], dtype=float)  # fmt: skip


@dataclass(frozen=True, eq=False)
class Cuboids(PackedRows):
    """Cars as upright cuboids in the `road` frame (x right, y down, z forward), one per row."""

    base: Float[Array, "n 3"]
    """Centre of the bottom face, metres."""
    yaw: Float[Array, " n"]
    """About road +y, rad; 0 = facing road +x."""
    size: Float[Array, "n 3"]
    """Length, height, width: along the object's x (forward), y (down), z (left); metres."""

    BLOCKS: ClassVar[Mapping[str, ColumnBlock]] = {
        "base": ColumnBlock(0, 3, (3,)),
        "yaw": ColumnBlock(3, 1),
        "size": ColumnBlock(4, 3, (3,)),
    }

    @classmethod
    def empty(cls) -> "Cuboids":
        """No cuboid at all."""
        return cls(np.zeros((0, 3)), np.zeros(0), np.zeros((0, 3)))

    def footprint(self) -> Float[Array, "n 4 2"]:
        """The four bottom corners on the road plane (x, z), in a constant turning sense."""
        return self.corners()[:, :4, ::2]

    def corners(self) -> Float[Array, "n 8 3"]:
        """The eight corners in the road frame: the four at the bottom, then those at the roof."""
        corners = CORNERS.dot(self.half_axes().reshape(3, -1)).reshape(8, -1, 3) + self.base
        return corners.transpose(1, 0, 2)

    def half_axes(self) -> Float[Array, "3 n 3"]:
        """Half the length forward, the whole height down, half the width left: see `CORNERS`."""
        c, s = np.cos(self.yaw), np.sin(self.yaw)
        axes = np.zeros((3, len(c), 3))
        axes[0, :, 0] = axes[2, :, 2] = c
        axes[0, :, 2] = -s
        axes[1, :, 1] = 2.0
        axes[2, :, 0] = s
        axes *= 0.5 * self.size.T[:, :, None]
        return axes
