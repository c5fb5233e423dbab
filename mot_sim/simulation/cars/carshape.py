"""One car, ready to be drawn and measured."""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import trimesh
from jaxtyping import Float, Int, UInt8
from numpy import ndarray as Array

from mot_sim.simulation.cars.paint import Paint, part_colours
from tracker.errors import BadConfig


@dataclass(frozen=True, eq=False)
class CarShape:
    """A car in the `object` frame: x forward, y down, z left, origin on the road, metres.

    faces: counter-clockwise from outside. parts: index into PARTS a face. pieces: which closed
    piece a face belongs to. keypoints: KEYPOINTS_36; keypoints_14: KEYPOINTS_14; coefficients:
    of eq. 1. All three are None for a car that does not come from the fleet. scale: how much
    the fleet's shape was stretched along x, y, z.
    """

    vertices: Float[Array, "v 3"]
    faces: Int[Array, "f 3"]
    parts: Int[Array, " f"]
    pieces: Int[Array, " f"]
    keypoints: Float[Array, "36 3"] | None = None
    keypoints_14: Float[Array, "14 3"] | None = None
    coefficients: Float[Array, " b"] | None = None
    scale: Float[Array, "3"] | None = None

    @cached_property
    def size(self) -> Float[Array, "3"]:
        """Length, height, width of the tight box around the mesh."""
        return np.ptp(self.vertices, axis=0)

    def scaled_to(self, size: Float[Array, "3"]) -> "CarShape":
        """The same car stretched to this length, height and width; wheels stay on the road."""
        if not (np.isfinite(size).all() and (size > 0.0).all()):
            raise BadConfig(f"car of size {size.tolist()}: give length, height, width > 0")
        factor = size / self.size
        return replace(
            self,
            vertices=self.vertices * factor,
            keypoints=None if self.keypoints is None else self.keypoints * factor,
            keypoints_14=None if self.keypoints_14 is None else self.keypoints_14 * factor,
            scale=factor if self.scale is None else self.scale * factor,
        )

    def colours(self, paint: Paint = "silver") -> UInt8[Array, "f 3"]:
        """The RGB of every face."""
        return part_colours(self.parts, paint)

    def mesh(self, paint: Paint = "silver") -> trimesh.Trimesh:
        """The whole car with its colours, its vertices in the order of `vertices`."""
        return trimesh.Trimesh(
            self.vertices, self.faces, face_colors=self.colours(paint), process=False
        )

    def piece(self, number: int) -> trimesh.Trimesh:
        """One closed piece: 0 the shell, 1..4 the wheels, 5, 6 the mirrors, 7, 8 the plates."""
        return trimesh.Trimesh(self.vertices, self.faces[self.pieces == number])
