"""The triangles of a view that face the camera and lie before its near plane; clipping."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from jaxtyping import Bool, Float, Int
from numpy import ndarray as Array

from mot_sim.simulation.renderers.view import MeshInstances
from tracker.types import Camera

NEAR_METRES = 0.3  # metres before the camera; nothing nearer is in its view
TINY_PIXELS = 1e-30  # for the length of an edge along an axis to which it is square
ROUNDING_PIXELS = 1e-9  # how far from the side that cuts an edge its end may come to lie
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
        corners, objects, faces = [np.zeros((0, 3, 3))], [], [np.zeros(0, np.int64)]
        for row in np.flatnonzero(sphere_in_view(instances, camera, near)).tolist():
            mesh, T_cam_object = instances.meshes[row], instances.T_cam_object[row]
            eye = -T_cam_object[:3, :3].T @ T_cam_object[:3, 3]  # the camera, seen by the object
            facing = np.flatnonzero(mesh.normals @ eye > mesh.offsets)
            vertices_cam = mesh.vertices @ T_cam_object[:3, :3].T + T_cam_object[:3, 3]
            shown = vertices_cam.take(mesh.faces.take(facing, axis=0), axis=0)
            if shown.size and vertices_cam[:, 2].min() < near:
                shown, kept = cut_near(shown, near)
                facing = facing[kept]
            corners.append(shown)
            objects.append(np.full(len(shown), row))
            faces.append(facing)
        rows = np.concatenate(objects) if objects else np.zeros(0, np.int64)
        return cls(np.concatenate(corners), rows, np.concatenate(faces))

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

    @cached_property
    def depths(self) -> tuple[float, float]:
        """The smallest and the largest depth; 1, 1 for no triangle."""
        if not len(self):
            return 1.0, 1.0
        return float(self.corners[..., 2].min()), float(self.corners[..., 2].max())


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
    behind = corners[..., 2] < near
    count = behind.sum(axis=1)
    whole, one, two = (np.flatnonzero(count == number) for number in (0, 1, 2))
    # Turn each triangle so that its odd corner comes first; its sense of rotation stays.
    a, b, c = _turned(corners[one], behind[one].argmax(axis=1))
    ab, ac = _meet(a, b, near), _meet(a, c, near)
    p, q, r = _turned(corners[two], (~behind[two]).argmax(axis=1))
    pieces = (
        corners[whole],
        np.stack((ab, b, c), axis=1),
        np.stack((ab, c, ac), axis=1),
        np.stack((p, _meet(p, q, near), _meet(p, r, near)), axis=1),
    )
    return np.concatenate(pieces), np.concatenate((whole, one, one, two))


def _turned(corners: Float[Array, "t 3 3"], first: Int[Array, " t"]) -> Float[Array, "3 t 3"]:
    """The corners, each triangle's begun with the named one; corner by corner."""
    order = (first[:, None] + np.arange(3)) % 3
    return np.take_along_axis(corners, order[..., None], axis=1).swapaxes(0, 1)


def _meet(a: Float[Array, "t 3"], b: Float[Array, "t 3"], near: float) -> Float[Array, "t 3"]:
    """Where the edges from a to b meet the near plane; a and b lie on different sides."""
    share = (near - a[:, 2:]) / (b[:, 2:] - a[:, 2:])
    met = a + share * (b - a)
    met[:, 2] = near
    return met


def boxes_inside(triangles: Float[Array, "t 3 2"], far: Float[Array, "2"]) -> Float[Array, "t 4"]:
    """The boxes around what triangles cover of the rectangle from (0, 0) to `far`, pixels.

    Cut triangles have their corners where edges are cut, and where they cover the rectangle's
    own corners. Inverted where a triangle covers nothing.
    """
    a, b, c = triangles.swapaxes(0, 1)
    boxes = np.concatenate(
        (np.minimum(np.minimum(a, b), c), np.maximum(np.maximum(a, b), c)), axis=1
    )
    left, top, right, bottom = boxes.T
    whole = (left >= 0.0) & (top >= 0.0) & (right <= far[0]) & (bottom <= far[1])
    beyond = (right < 0.0) | (bottom < 0.0) | (left > far[0]) | (top > far[1])
    boxes[beyond] = NO_BOX
    cut = np.flatnonzero(~(whole | beyond))
    starts = triangles[cut]
    edges = np.roll(starts, -1, axis=1) - starts
    # Liang and Barsky's rule: an edge is inside between its last entry and its first exit.
    sides = np.stack((-starts, far - starts)) / np.where(edges == 0.0, TINY_PIXELS, edges)
    first = sides.min(axis=0).max(axis=2).clip(min=0.0)
    last = sides.max(axis=0).min(axis=2).clip(max=1.0)
    corners = np.array([(u, v) for u in (0.0, far[0]) for v in (0.0, far[1])])
    ends = np.stack((first, last), axis=1)[..., None] * edges[:, None] + starts[:, None]
    points = np.concatenate(
        (ends.reshape(-1, 6, 2), np.broadcast_to(corners, (len(cut), 4, 2))), axis=1
    )
    is_inside = (first <= last)[:, [0, 1, 2, 0, 1, 2]]
    kept = np.concatenate((is_inside, _covered(corners, starts)), axis=1)[..., None]
    points = np.where(points < ROUNDING_PIXELS, 0.0, points)
    points = np.where(points > far - ROUNDING_PIXELS, far, points)
    boxes[cut, :2] = np.where(kept, points, np.inf).min(axis=1)
    boxes[cut, 2:] = np.where(kept, points, -np.inf).max(axis=1)
    return boxes


def _covered(points: Float[Array, "p 2"], triangles: Float[Array, "t 3 2"]) -> Bool[Array, "t p"]:
    """Which points lie inside each of the triangles, not on its edges."""
    u, v = (triangles[:, None] - points[:, None]).transpose(3, 0, 1, 2)
    turns = u * np.roll(v, -1, axis=2) - v * np.roll(u, -1, axis=2)
    return (turns > 0.0).all(axis=2) | (turns < 0.0).all(axis=2)


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
