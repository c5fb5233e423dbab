"""Faces before the camera, boxes around them, and what may hide them, in plain NumPy."""

import numpy as np

from mot_sim.simulation.renderers import NO_INSTANCE, MeshInstances
from mot_sim.simulation.renderers.triangles import (
    NO_BOX,
    ROUNDING_PIXELS,
    TINY_PIXELS,
    Triangles,
    sphere_in_view,
)
from tracker.types import Camera


def plain_triangles(instances: MeshInstances, camera: Camera, near: float) -> Triangles:
    """`Triangles.of`: back faces culled, the rest cut at the near plane."""
    corners, objects, faces = [np.zeros((0, 3, 3))], [np.zeros(0, int)], [np.zeros(0, int)]
    for row in np.flatnonzero(sphere_in_view(instances, camera, near)):
        mesh, T = instances.meshes[row], instances.T_cam_object[row]
        eye = -T[:3, :3].T @ T[:3, 3]
        facing = np.flatnonzero(mesh.normals @ eye > mesh.offsets)
        vertices = mesh.vertices @ T[:3, :3].T + T[:3, 3]
        shown, kept = plain_cut(vertices[mesh.faces[facing]], near)
        corners.append(shown)
        objects.append(np.full(len(shown), row))
        faces.append(facing[kept])
    return Triangles(np.concatenate(corners), np.concatenate(objects), np.concatenate(faces))


def plain_cut(corners: np.ndarray, near: float) -> tuple[np.ndarray, np.ndarray]:
    """`cut_near`, by the number of corners behind the plane."""
    behind = corners[..., 2] < near
    count = behind.sum(axis=1)
    whole, one, two = (np.flatnonzero(count == number) for number in (0, 1, 2))
    a, b, c = _turned(corners[one], behind[one].argmax(axis=1))
    ab, ac = _meet(a, b, near), _meet(a, c, near)
    p, q, r = _turned(corners[two], (~behind[two]).argmax(axis=1))
    pieces = (
        corners[whole],
        np.stack((ab, b, c), axis=1),
        np.stack((ab, c, ac), axis=1),
        np.stack((p, _meet(p, q, near), _meet(p, r, near)), axis=1),
    )
    rows = np.concatenate((whole, one, one, two))
    order = np.argsort(rows, kind="stable")
    return np.concatenate(pieces)[order], rows[order]


def _turned(corners: np.ndarray, first: np.ndarray) -> np.ndarray:
    order = (first[:, None] + np.arange(3)) % 3
    return np.take_along_axis(corners, order[..., None], axis=1).swapaxes(0, 1)


def _meet(a: np.ndarray, b: np.ndarray, near: float) -> np.ndarray:
    met = a + (near - a[:, 2:]) / (b[:, 2:] - a[:, 2:]) * (b - a)
    met[:, 2] = near
    return met


def plain_boxes_inside(triangles: np.ndarray, far: np.ndarray) -> np.ndarray:
    """`boxes_inside`: all edges cut at all sides at once."""
    low, high = triangles.min(axis=1), triangles.max(axis=1)
    boxes = np.concatenate((low, high), axis=1)
    whole = ((low >= 0.0) & (high <= far)).all(axis=1)
    beyond = ((high < 0.0) | (low > far)).any(axis=1)
    boxes[beyond] = NO_BOX
    cut = np.flatnonzero(~(whole | beyond))
    starts = triangles[cut]
    edges = np.roll(starts, -1, axis=1) - starts
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


def _covered(points: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Which points lie inside each of the triangles, not on its edges."""
    u, v = (triangles[:, None] - points[:, None]).transpose(3, 0, 1, 2)
    turns = u * np.roll(v, -1, axis=2) - v * np.roll(u, -1, axis=2)
    return (turns > 0.0).all(axis=2) | (turns < 0.0).all(axis=2)


def projected(triangles: Triangles, camera: Camera) -> np.ndarray:
    """Pixels (t, 3, 2) of corners that lie before the camera."""
    pixels = triangles.corners @ camera.K[:2].T
    return pixels / triangles.corners[..., 2:]


def plain_extents(
    triangles: Triangles, camera: Camera, owners: np.ndarray, ids: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Boxes around instances' triangles, around their parts in the image, and largest depths."""
    pixels, mine = projected(triangles, camera), owners[triangles.objects]
    inside = plain_boxes_inside(pixels, camera.far_corner[2:])
    boxes, clipped, farthest = [], [], []
    for number in ids:
        rows = mine == number
        points = pixels[rows].reshape(-1, 2)
        low, high = points.min(axis=0, initial=np.inf), points.max(axis=0, initial=-np.inf)
        boxes.append(np.concatenate((low, high)))
        low = inside[rows, :2].min(axis=0, initial=np.inf)
        clipped.append((*low, *inside[rows, 2:].max(axis=0, initial=-np.inf)))
        farthest.append(triangles.corners[rows, :, 2].max(initial=-np.inf))
    return (
        np.array(boxes).reshape(-1, 4),
        np.array(clipped).reshape(-1, 4),
        np.array(farthest).reshape(-1),
    )


def plain_hiders(
    triangles: Triangles, camera: Camera, owners: np.ndarray, boxes: np.ndarray, deep: np.ndarray
) -> np.ndarray:
    """Which triangles are an instance's, or of scenery that may hide something in some boxes."""
    pixels, nearest = projected(triangles, camera), triangles.corners[..., 2].min(axis=1)
    low, high = pixels.min(axis=1)[:, None], pixels.max(axis=1)[:, None]
    close = (low < boxes[:, 2:] + 1.0) & (high > boxes[:, :2] - 1.0)
    hides = (close.all(axis=2) & (nearest[:, None] < deep)).any(axis=1)
    return hides | (owners[triangles.objects] != NO_INSTANCE)


def plain_beside(boxes: np.ndarray, camera: Camera) -> np.ndarray:
    """Which pixels lie farther than four or five from a box around some boxes."""
    columns, rows = (np.arange(size) for size in camera.image_size)
    low = np.floor(boxes[:, :2].min(axis=0, initial=np.inf) - 3.0) - 1.0
    high = np.ceil(boxes[:, 2:].max(axis=0, initial=-np.inf) + 3.0) + 1.0
    inside = (columns >= low[0]) & (columns <= high[0])
    return ~(inside & (rows[:, None] >= low[1]) & (rows[:, None] <= high[1]))
