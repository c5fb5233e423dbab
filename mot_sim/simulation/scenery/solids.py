"""Triangles of things that stand beside roads, in metres: x, y of the world and height above it."""

from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float, UInt8
from numpy import ndarray as Array

from mot_sim.simulation.renderers import Mesh, Semantic, cross

Colour = tuple[int, int, int]
# The eight corners of a box between 0 and 1, and its six sides.
UNIT_CORNERS = np.array([(x, y, h) for x in (0.0, 1.0) for y in (0.0, 1.0) for h in (0.0, 1.0)])
BOX_SIDES = np.array([(0, 1, 3, 2), (4, 5, 7, 6), (0, 1, 5, 4), (2, 3, 7, 6), (1, 3, 7, 5)])


@dataclass(frozen=True, eq=False)
class Solid:
    """Coloured triangles; which side of each is outside is settled."""

    corners: Float[Array, "k 3 3"]
    """Three corners of each triangle: x, y and the height above the ground, metres."""
    colours: UInt8[Array, "k 3"]
    """RGB of each triangle."""
    semantics: UInt8[Array, " k"]
    """A `Semantic` of each triangle."""
    materials: UInt8[Array, " k"]
    """A `Material` of each triangle."""

    def __len__(self) -> int:
        return len(self.corners)

    def moved(
        self, place: tuple[float, float], turn: float = 0.0, scale: tuple[float, float] = (1.0, 1.0)
    ) -> "Solid":
        """Scaled (across, up), turned from x towards y, and put down at a place."""
        c, s = np.cos(turn) * scale[0], np.sin(turn) * scale[0]
        A = np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, scale[1]]])
        return replace(self, corners=self.corners @ A + (*place, 0.0))

    def mesh(self, origin: Float[Array, "2"]) -> Mesh:
        """The mesh in the object's frame (x forward, y down, z left), which stands at an origin."""
        points = self.corners.reshape(-1, 3) - (*origin, 0.0)
        vertices = points[:, [0, 2, 1]] * (1.0, -1.0, -1.0)
        faces = np.arange(len(vertices)).reshape(-1, 3)
        return Mesh(vertices, faces, self.colours, self.semantics, self.materials, casts=False)

    def made_of(self, material: int) -> "Solid":
        """The same, all of one `Material`."""
        return replace(self, materials=np.full(len(self), material, np.uint8))


def join(solids: list[Solid]) -> Solid:
    """All of them as one."""
    if not solids:
        nothing = np.zeros(0, np.uint8)
        return Solid(np.zeros((0, 3, 3)), np.zeros((0, 3), np.uint8), nothing, nothing)
    return Solid(
        np.concatenate([one.corners for one in solids]),
        np.concatenate([one.colours for one in solids]),
        np.concatenate([one.semantics for one in solids]),
        np.concatenate([one.materials for one in solids]),
    )


def facing(
    polygons: Float[Array, "k c 3"],
    colours: Float[Array, "k 3"] | UInt8[Array, "k 3"] | Colour,
    semantic: Semantic,
    inside: Float[Array, "3"] | Float[Array, "k 3"] | tuple[float, float, float],
) -> Solid:
    """Convex polygons, 3 or 4 corners each, that look away from a point (or one each)."""
    normals = cross(polygons[:, 1] - polygons[:, 0], polygons[:, 2] - polygons[:, 0])
    middles = polygons.sum(axis=1) / polygons.shape[1]
    away = ((middles - inside) * normals).sum(axis=1)
    # x, y and height are a left-handed frame: anticlockwise from outside turns around.
    turned, is_mirrored = np.array(polygons, float), away > 0.0
    turned[is_mirrored] = polygons[is_mirrored, ::-1]
    painted = np.empty((len(polygons), 3), np.uint8)
    painted[:] = np.minimum(np.maximum(np.asarray(colours, float), 0.0), 255.0).astype(np.uint8)
    if polygons.shape[1] == 4:
        turned = np.concatenate((turned[:, :3], turned[:, [0, 2, 3]]))
        painted = np.concatenate((painted, painted))
    semantics = np.empty(len(turned), np.uint8)
    semantics.fill(int(semantic))
    return Solid(turned, painted, semantics, np.zeros(len(turned), np.uint8))


def box(
    low: tuple[float, float, float],
    high: tuple[float, float, float],
    colour: Colour,
    semantic: Semantic,
) -> Solid:
    """An upright box without a bottom."""
    corners = np.array(low) + UNIT_CORNERS * (np.array(high) - np.array(low))
    return facing(corners[BOX_SIDES], colour, semantic, 0.5 * (np.array(low) + np.array(high)))


def prism(
    radius: float,
    low: float,
    high: float,
    colour: Colour,
    semantic: Semantic,
    sides: int = 6,
    top: float | None = None,
) -> Solid:
    """A post around the origin between two heights; top: its radius there."""
    turn = np.arange(sides + 1) * (2.0 * np.pi / sides)
    circle = np.stack((np.cos(turn), np.sin(turn)), axis=1)
    upper = radius if top is None else top
    below = np.column_stack((radius * circle, np.full(sides + 1, low)))
    above = np.column_stack((upper * circle, np.full(sides + 1, high)))
    walls = np.stack((below[:-1], below[1:], above[1:], above[:-1]), axis=1)
    return facing(walls, colour, semantic, (0.0, 0.0, 0.5 * (low + high)))


def shaded(colour: Colour, amounts: Float[Array, " n"]) -> Float[Array, "n 3"]:
    """A colour, brighter or darker."""
    return np.array(colour, float) * amounts[:, None]
