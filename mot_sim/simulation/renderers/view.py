"""What a renderer is given and what it gives: meshes, a view of them, and the rendered frame."""

from collections.abc import Callable
from dataclasses import dataclass, field
from enum import IntEnum
from functools import cached_property

import numpy as np
from jaxtyping import Float, Float32, Int, Int32, UInt8
from numpy import ndarray as Array

from mot_sim.simulation.renderers.surroundings import Cover, Road, Sky, Sun
from tracker.errors import BadConfig
from tracker.types import Camera

NO_INSTANCE = -1  # the instance id of scenery, road and sky


class Semantic(IntEnum):
    """What a pixel or a face is made of; the ids of the semantic image."""

    SKY = 0
    ROAD = 1  # the drawn part of the road plane
    GROUND = 2  # the rest of it
    CAR = 3  # bodywork
    GLASS = 4
    TYRE = 5
    LIGHT = 6
    PLATE = 7
    TRIM = 8  # sills, grilles, bumpers
    BUILDING = 9
    VEGETATION = 10
    POLE = 11
    WALL = 12
    OTHER = 13


class Pattern(IntEnum):
    """What is painted on a face beside its colour."""

    PLAIN = 0
    WHEEL = 1  # spokes, the rim's edge, the tyre around
    PLATE = 2  # characters on a number plate


class Material(IntEnum):
    """What a face of scenery is made of; it is painted pixel by pixel."""

    PLAIN = 0
    PLASTER = 1
    BRICK = 2
    BOARDS = 3
    BLOCKS = 4  # of stone
    TILES = 5  # of a roof
    PANE = 6
    BARK = 7
    LEAF = 8  # of what is closed: a hedge, the inside of a crown
    TUFT = 9  # of leaves, with gaps between them
    SHOP = 16  # added to a wall's: the lowest storey is a shop's front


def cross(a: Float[Array, "n 3"], b: Float[Array, "n 3"]) -> Float[Array, "n 3"]:
    """`np.cross` of two lists of vectors, the same bits; for few of them much faster."""
    (ax, ay, az), (bx, by, bz) = a.T, b.T
    across = np.empty((len(a), 3))
    across[:, 0], across[:, 1] = ay * bz - az * by, az * bx - ax * bz
    across[:, 2] = ax * by - ay * bx
    return across


@dataclass(frozen=True, eq=False)
class Skin:
    """How a car's surface takes the light between the corners of its faces."""

    normals: Float[Array, "f 3 3"]
    """Unit normals at the corners of each face, evened out over what is smooth."""
    openness: Float[Array, "f 3"]
    """Share of the light from all around that the car and the dark beneath it leave each corner,
    0 to 1."""
    patterns: Int[Array, " f"]
    """A `Pattern` of each face."""
    marks: Float[Array, "8"]
    """Where patterns are: x of the front and the rear hubs, radius of a wheel along x and along y,
    y of the front and the rear plate's middle, half a plate's width, its height; metres."""


@dataclass(frozen=True, eq=False)
class Mesh:
    """Coloured triangles in the object's frame: x forward, y down, z to the left, metres."""

    vertices: Float[Array, "v 3"]
    """Points in the object's frame, metres, finite."""
    faces: Int[Array, "f 3"]
    """Rows of `vertices`, anticlockwise seen from outside; only that side is drawn."""
    colours: UInt8[Array, "f 3"]
    """RGB of each face."""
    semantics: UInt8[Array, " f"]
    """A `Semantic` of each face."""
    materials: UInt8[Array, " f"] | None = None
    """A `Material` of each face; None: all are plain."""
    casts: bool = True
    """Whether it casts a shadow on the road; for what stands still, the road's picture may hold
    it."""
    make_skin: Callable[[], Skin | None] | None = None
    """Makes `skin`, which only pictures need; None: there is none."""

    def __post_init__(self) -> None:
        if not np.isfinite(self.vertices).all():
            raise BadConfig("a mesh has vertices that are not finite")
        if self.faces.size and not 0 <= self.faces.min() <= self.faces.max() < len(self.vertices):
            raise BadConfig(
                f"faces name vertices {self.faces.min()} to {self.faces.max()}; "
                f"there are {len(self.vertices)}, counted from 0"
            )

    @cached_property
    def skin(self) -> Skin | None:
        """How light changes between the corners of faces; None: each face has one colour."""
        return None if self.make_skin is None else self.make_skin()

    @cached_property
    def corners(self) -> Float[Array, "f 3 3"]:
        """The three corners of each face."""
        return self.vertices[self.faces]

    @cached_property
    def normals(self) -> Float[Array, "f 3"]:
        """Unit normals away from the object; zero for faces without area."""
        a, b, c = self.corners.swapaxes(0, 1)
        across = cross(b - a, c - a)
        length = np.sqrt((across * across).sum(axis=1, keepdims=True))
        return across / np.where(length > 0.0, length, 1.0)

    @cached_property
    def codes(self) -> UInt8[Array, "f 4"]:
        """Colour and semantic id of each face."""
        return np.column_stack((self.colours, self.semantics))

    @cached_property
    def offsets(self) -> Float[Array, " f"]:
        """How far the faces' planes lie from the origin, along their normals."""
        return (self.normals * self.corners[:, 0]).sum(axis=1)

    @cached_property
    def geometry(self) -> tuple[Array, Array, Array, Array]:
        """Vertices, faces, normals and offsets as the kernels take them."""
        vertices, normals = (
            np.ascontiguousarray(one, float) for one in (self.vertices, self.normals)
        )
        faces, offsets = np.ascontiguousarray(self.faces, np.int64), self.offsets.astype(float)
        return vertices, faces, normals, offsets

    @cached_property
    def sphere(self) -> tuple[Float[Array, "3"], float]:
        """Centre and radius of a sphere around all vertices."""
        if not len(self.vertices):
            return np.zeros(3), 0.0
        centre = 0.5 * (self.vertices.min(axis=0) + self.vertices.max(axis=0))
        return centre, float(np.linalg.norm(self.vertices - centre, axis=1).max())

    @cached_property
    def bounds(self) -> Float[Array, "2 3"]:
        """The smallest and the largest coordinates of the vertices; zero where there are none."""
        if not len(self.vertices):
            return np.zeros((2, 3))
        return np.stack((self.vertices.min(axis=0), self.vertices.max(axis=0)))

    @cached_property
    def extremes(self) -> Float[Array, "k 3"]:
        """The vertices that shape its shadow: the outermost in each of many directions."""
        if len(self.vertices) < 64:
            return self.vertices
        turn = np.arange(32) * (np.pi / 16.0)
        level = np.stack((np.cos(turn), np.zeros(32), np.sin(turn)), axis=1)
        tilted = [level + (0.0, tilt, 0.0) for tilt in (-2.0, -0.6, 0.0, 0.6)]
        directions = np.concatenate([[(0.0, -1.0, 0.0), (0.0, 1.0, 0.0)], *tilted])
        return self.vertices[np.unique((self.vertices @ directions.T).argmax(axis=0))]


@dataclass(frozen=True, eq=False)
class MeshInstances:
    """Objects before the camera, one row each."""

    meshes: tuple[Mesh, ...]
    """Shape of each object; several may share one."""
    T_cam_object: Float[Array, "n 4 4"]
    """From each object's frame to the camera's, rigid, finite."""
    ids: Int[Array, " n"]
    """Id of each object, >= 0, or NO_INSTANCE for scenery; rows with the same id are parts of one
    thing."""
    unlit: tuple[int, ...] = ()
    """Ids of cars whose lamps are off."""

    def __post_init__(self) -> None:
        if not len(self.meshes) == len(self.T_cam_object) == len(self.ids):
            raise BadConfig(
                f"{len(self.meshes)} meshes, {len(self.T_cam_object)} places and "
                f"{len(self.ids)} instance ids: give one of each per object"
            )
        if not np.isfinite(self.T_cam_object).all():
            raise BadConfig("an object's place T_cam_object is not finite")
        if self.ids.size and self.ids.min() < NO_INSTANCE:
            raise BadConfig(f"instance id {self.ids.min()}: ids are 0 or more, -1 is scenery")

    @classmethod
    def empty(cls) -> "MeshInstances":
        """No object at all."""
        return cls((), np.zeros((0, 4, 4)), np.zeros(0, np.int64))

    def beside(self, others: "MeshInstances") -> "MeshInstances":
        """These objects, and then the others."""
        return MeshInstances(
            self.meshes + others.meshes,
            np.concatenate((self.T_cam_object, others.T_cam_object)),
            np.concatenate((self.ids, others.ids)),
            self.unlit + others.unlit,
        )

    def __len__(self) -> int:
        return len(self.meshes)


@dataclass(frozen=True, eq=False)
class View:
    """Everything in front of a camera."""

    camera: Camera
    """Where it is seen from, and the image's size."""
    instances: MeshInstances
    """Objects, on or above the road; what is below the road is drawn over it."""
    road: Road | None = field(default_factory=Road)
    """The painted road plane; None: no ground, the sky goes on below."""
    sky: Sky = field(default_factory=Sky)
    """What is seen above the horizon."""
    sun: Sun = field(default_factory=Sun)
    """Light and shadows."""
    cover: Cover | None = None
    """Where what stands still keeps the sun from cars; None: nowhere."""


@dataclass(frozen=True, eq=False)
class Rendered:
    """A frame, all of it from one pass; row v, column u."""

    image: UInt8[Array, "h w 3"]
    """RGB."""
    depth: Float32[Array, "h w"]
    """Metres along the optical axis; inf: sky."""
    instances: Int32[Array, "h w"]
    """Id of the object seen, or NO_INSTANCE."""
    semantics: UInt8[Array, "h w"]
    """`Semantic` of what is seen."""
    unlit: tuple[int, ...] = ()
    """Ids of cars whose lamps are off."""
