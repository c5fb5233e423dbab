"""One car, ready to be drawn and measured, and what cars are painted with."""

from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from jaxtyping import Float, Int, UInt8
from numpy import ndarray as Array

from mot_sim.simulation.cars.topology import PARTS
from tracker.errors import BadConfig, UnknownName

if TYPE_CHECKING:
    import trimesh

# RGB, and the share of cars: roughly German streets around 2011, when KITTI was driven.
PAINTS: dict[str, tuple[tuple[int, int, int], float]] = {
    "black": ((24, 24, 27), 0.29),
    "grey": ((98, 101, 105), 0.17),
    "silver": ((176, 179, 182), 0.18),
    "white": ((232, 232, 228), 0.11),
    "blue": ((32, 58, 112), 0.11),
    "red": ((150, 22, 26), 0.07),
    "green": ((36, 74, 52), 0.03),
    "brown": ((88, 66, 52), 0.02),
    "yellow": ((226, 186, 40), 0.02),
}
PART_COLOURS: dict[str, tuple[int, int, int]] = {
    "glass": (15, 18, 20),
    "trim": (25, 25, 27),
    "headlight": (228, 232, 236),
    "taillight": (170, 16, 20),
    "plate": (236, 236, 232),
    "tyre": (22, 22, 23),
    "rim": (150, 153, 157),
}
Paint = str | tuple[int, int, int]


def paint_colour(paint: Paint) -> tuple[int, int, int]:
    """The RGB of a paint; UnknownName unless it is one of PAINTS or a colour itself."""
    if not isinstance(paint, str):
        return paint
    if paint not in PAINTS:
        raise UnknownName.of("colour", paint, PAINTS)
    return PAINTS[paint][0]


def part_colours(parts: Int[Array, " f"], paint: Paint) -> UInt8[Array, "f 3"]:
    """The RGB of faces from their parts."""
    palette = [paint_colour(paint), *(PART_COLOURS[part] for part in PARTS[1:])]
    return np.array(palette, dtype=np.uint8)[parts]


def choose(shares: list[float], draws: Float[Array, " n"]) -> Int[Array, " n"]:
    """Which share each number of [0, 1) falls into; the shares need not sum up to 1."""
    bounds = np.cumsum(shares)
    return np.minimum(np.searchsorted(bounds / bounds[-1], draws, side="right"), len(bounds) - 1)


@dataclass(frozen=True, eq=False)
class CarShape:
    """A car in the `object` frame: x forward, y down, z left, origin on the road, metres."""

    vertices: Float[Array, "v 3"]
    """Points of the mesh."""
    faces: Int[Array, "f 3"]
    """Rows of `vertices`, counter-clockwise from outside."""
    parts: Int[Array, " f"]
    """Index into PARTS of each face."""
    pieces: Int[Array, " f"]
    """Which closed piece each face belongs to: see `piece`."""
    keypoints: Float[Array, "36 3"] | None = None
    """KEYPOINTS_36; None for a car that does not come from the fleet."""
    keypoints_14: Float[Array, "14 3"] | None = None
    """KEYPOINTS_14; None for a car that does not come from the fleet."""
    coefficients: Float[Array, " b"] | None = None
    """Of eq. 1; None for a car that does not come from the fleet."""
    scale: Float[Array, "3"] | None = None
    """Factors by which the fleet's shape was stretched along x, y, z; None as `coefficients`."""

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

    def mesh(self, paint: Paint = "silver") -> "trimesh.Trimesh":
        """The whole car with its colours, its vertices in the order of `vertices`."""
        import trimesh

        return trimesh.Trimesh(
            self.vertices, self.faces, face_colors=self.colours(paint), process=False
        )

    def piece(self, number: int) -> "trimesh.Trimesh":
        """One closed piece: 0 the shell, 1..4 the wheels, 5, 6 the mirrors, 7, 8 the plates."""
        import trimesh

        return trimesh.Trimesh(self.vertices, self.faces[self.pieces == number])
