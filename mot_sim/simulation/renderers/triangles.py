"""The triangles of a view that face the camera and lie before its near plane; clipping."""

from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np
from jaxtyping import Bool, Float, Int
from numpy import ndarray as Array

from mot_sim.simulation.renderers.view import MeshInstances
from tracker.kernels import Kernel
from tracker.types import Camera

PLACE_FACES = Kernel("mot_sim.simulation.kernels.meshes", "place_faces")
CUT_TRIANGLES = Kernel("mot_sim.simulation.kernels.meshes", "cut_triangles")
ENCLOSE_TRIANGLES = Kernel("mot_sim.simulation.kernels.extents", "enclose_triangles")

NEAR_METRES = 0.3  # metres before the camera; nothing nearer is in its view
TINY_PIXELS = 1e-30  # for the length of an edge along an axis to which it is square
ROUNDING_PIXELS = 1e-9  # how far from the side that cuts an edge its end may come to lie
TOLERANCES = np.array([TINY_PIXELS, ROUNDING_PIXELS])
NO_BOX = (np.inf, np.inf, -np.inf, -np.inf)  # the box around nothing: inverted


@dataclass(frozen=True, eq=False)
class Triangles:
    """A soup of triangles in the camera's frame, grouped by object."""

    corners: Float[Array, "t 3 3"]
    """Three corners of each triangle in the camera's frame, metres."""
    objects: Int[Array, " t"]
    """Row of `MeshInstances` that each belongs to, ascending."""
    faces: Int[Array, " t"]
    """Row of that object's mesh; a face that the near plane cuts in two stands here twice."""

    def __len__(self) -> int:
        return len(self.corners)

    @classmethod
    def of(cls, instances: MeshInstances, camera: Camera, near: float) -> "Triangles":
        """What may appear in the image: back faces culled, cut at the near plane, metres."""
        rows = np.flatnonzero(sphere_in_view(instances, camera, near)).tolist()
        # (A face that the plane cuts may leave two. Memory that is never written to costs nothing.)
        most = 2 * sum(len(instances.meshes[row].faces) for row in rows)
        corners, faces = np.empty((most, 3, 3)), np.empty(most, np.int64)
        Ts_cam_object = np.ascontiguousarray(instances.T_cam_object, float)
        ends = [0]
        for row in rows:
            place = Ts_cam_object[row], near, ends[-1], corners, faces
            ends.append(PLACE_FACES(*instances.meshes[row].geometry, *place))
        objects = np.repeat(np.array(rows, np.int64), np.diff(ends))
        return cls(corners[: ends[-1]], objects, faces[: ends[-1]])

    def select(self, keep: Bool[Array, " t"]) -> "Triangles":
        """The chosen ones."""
        return Triangles(self.corners[keep], self.objects[keep], self.faces[keep])

    def at(self, rows: Int[Array, " k"]) -> "Triangles":
        """Those of some rows."""
        return Triangles(self.corners[rows], self.objects[rows], self.faces[rows])

    @cached_property
    def normals(self) -> Float[Array, "t 3"]:
        """Unit normals away from the objects; zero for triangles without area."""
        a, b, c = self.corners.swapaxes(0, 1)
        across = np.cross(b - a, c - a)
        length = np.sqrt(np.einsum("ti,ti->t", across, across))[:, None]
        return across / np.where(length > 0.0, length, 1.0)

    def of_objects(self, rows: Int[Array, " k"]) -> "Triangles":
        """Those of some objects, in ascending order."""
        bounds = np.searchsorted(self.objects, np.stack((rows, rows + 1), axis=1)).tolist()
        if len(bounds) == 1:
            part = slice(*bounds[0])
            return Triangles(self.corners[part], self.objects[part], self.faces[part])
        return self.select(np.isin(self.objects, rows))

    def slices(self, count: int) -> Int[Array, "count 2"]:
        """Where each of `count` objects' triangles begin and end."""
        ends = np.searchsorted(self.objects, np.arange(count + 1))
        return np.stack((ends[:-1], ends[1:]), axis=1)


def sphere_in_view(instances: MeshInstances, camera: Camera, near: float) -> Bool[Array, " n"]:
    """Whether any of an object's bounding sphere lies in the camera's view, past the near plane."""
    if not len(instances):
        return np.zeros(0, bool)
    centres = np.stack([mesh.sphere[0] for mesh in instances.meshes])
    radii = np.array([mesh.sphere[1] for mesh in instances.meshes])
    T = instances.T_cam_object
    centres_cam = np.einsum("nij,nj->ni", T[:, :3, :3], centres) + T[:, :3, 3]
    distances = centres_cam @ side_planes(camera).T
    return (centres_cam[:, 2] + radii > near) & (distances >= -radii[:, None]).all(axis=1)


@lru_cache(maxsize=8)
def side_planes(camera: Camera) -> Float[Array, "4 3"]:
    """Unit normals, inwards, of the view's four sides, through the outer edges of its pixels."""
    width, height = camera.image_size
    outer = np.array([(0, 0), (width, 0), (width, height), (0, height)]) - 0.5
    rays = camera.rays(outer)
    normals = np.cross(rays, np.roll(rays, -1, axis=0))
    return normals / np.linalg.norm(normals, axis=1, keepdims=True)


def cut_near(
    corners: Float[Array, "t 3 3"], near: float
) -> tuple[Float[Array, "s 3 3"], Int[Array, " s"]]:
    """The triangles' parts from the near plane on, and which triangle each comes from.

    A triangle with one corner behind the plane leaves a quadrilateral, that is two triangles.
    """
    parts, rows = np.empty((2 * len(corners), 3, 3)), np.empty(2 * len(corners), np.int64)
    count = CUT_TRIANGLES(np.ascontiguousarray(corners), near, parts, rows)
    return parts[:count], rows[:count]


def boxes_inside(triangles: Float[Array, "t 3 2"], far: Float[Array, "2"]) -> Float[Array, "t 4"]:
    """The boxes around what triangles cover of the rectangle from (0, 0) to `far`, pixels.

    Cut triangles have their corners where edges are cut, and where they cover the rectangle's
    own corners. Inverted where a triangle covers nothing.
    """
    boxes = np.tile(NO_BOX, (len(triangles), 1))
    ENCLOSE_TRIANGLES(np.ascontiguousarray(triangles), far, TOLERANCES, boxes)
    return boxes


def enclose(boxes: Float[Array, "m 4"], rows: Int[Array, " k"], parts: Float[Array, "k 4"]) -> None:
    """Widen the boxes of some rows, in place, so that they hold the boxes of parts."""
    np.minimum.at(boxes[:, :2], rows, parts[:, :2])
    np.maximum.at(boxes[:, 2:], rows, parts[:, 2:])


def clip_polygon(
    points: Float[Array, "n d"], depth: Float[Array, " n"], near: float = 0.0
) -> Float[Array, "m d"]:
    """The part of a convex polygon where `depth`, linear over it, is at least `near`.

    Sutherland and Hodgman's rule for one plane; no point is left of what lies wholly behind.
    """
    inside = depth >= near
    if inside.all():
        return points
    if not inside.any():
        return points[:0]
    after, depth_after = np.roll(points, -1, axis=0), np.roll(depth, -1)
    kept: list[Float[Array, " d"]] = []
    for i, leaves in enumerate(inside != np.roll(inside, -1)):
        if inside[i]:
            kept.append(points[i])
        if leaves:
            share = (near - depth[i]) / (depth_after[i] - depth[i])
            kept.append(points[i] + share * (after[i] - points[i]))
    return np.array(kept)
