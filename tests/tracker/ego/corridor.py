"""A street between textured walls, drawn ray by ray: what visual odometry is tested on.

Its world is the `road` frame of the start: x right, y down, z forward, the road at y = 0.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from itertools import pairwise

import cv2
import numpy as np
from numpy import ndarray as Array

from tracker.geometry import homogeneous, invert, rotation_y, transform
from tracker.types import Camera

TEXELS = 25.0  # a metre
K = np.array([[360.0, 0.0, 310.0], [0.0, 360.0, 86.0], [0.0, 0.0, 1.0]])
CAMERA = Camera.mounted(K, (620, 188), 1.65)
NO_BOXES = np.zeros((0, 4))


@dataclass(frozen=True, eq=False)
class Plane:
    """A rectangle: a corner, two unit vectors along its sides, and what is painted on it."""

    corner: Array
    sides: Array
    paint: Array


def paint(seed: int, width: float, height: float) -> Array:
    """Grey noise of several coarsenesses over so many metres."""
    rng = np.random.default_rng(seed)
    w, h = int(width * TEXELS), int(height * TEXELS)
    total = np.full((h, w), 118.0)
    for coarse, weight in ((2, 14.0), (6, 18.0), (20, 22.0), (60, 22.0)):
        noise = rng.normal(size=(h // coarse + 2, w // coarse + 2)).astype(np.float32)
        total += weight * cv2.resize(noise, (w, h), interpolation=cv2.INTER_CUBIC)
    return np.clip(total, 5, 250).astype(np.float32)


@cache
def street() -> tuple[Plane, ...]:
    """The road, houses left and right, some of them nearer, and a wall at the far end."""
    right, down, forward = np.eye(3)
    planes = [
        Plane(np.array([-14.0, 0.0, -12.0]), np.stack((forward, right)), paint(1, 122.0, 28.0)),
        Plane(np.array([-14.0, -9.0, 105.0]), np.stack((right, down)), paint(2, 28.0, 9.0)),
        Plane(np.array([-9.0, -7.0, -12.0]), np.stack((forward, down)), paint(3, 118.0, 7.0)),
        Plane(np.array([8.0, -8.0, -12.0]), np.stack((forward, down)), paint(4, 118.0, 8.0)),
    ]
    for number, (x, z) in enumerate(((-7.0, 14.0), (5.0, 24.0), (-6.0, 38.0), (6.0, 55.0))):
        corner = np.array([min(x, 2.5 * x), -3.0, z])
        width = 1.5 * abs(x)
        planes.append(Plane(corner, np.stack((right, down)), paint(10 + number, width, 3.0)))
    return tuple(planes)


def place(plane: Plane, T_world_cam: Array, camera: Camera, fine: int) -> tuple[slice, slice]:
    """The rows and columns of the image's finer grid that a plane may cover."""
    across, along = np.array(plane.paint.shape) / TEXELS
    ends = [
        a * along * plane.sides[0] + b * across * plane.sides[1] for a in (0, 1) for b in (0, 1)
    ]
    at = camera.project(transform(invert(T_world_cam), plane.corner + np.array(ends)))
    if not np.isfinite(at).all():
        return slice(None), slice(None)
    (u0, v0), (u1, v1) = np.maximum((at.min(axis=0) - 1, at.max(axis=0) + 2), 0.0)
    return slice(int(v0 * fine), int(v1 * fine)), slice(int(u0 * fine), int(u1 * fine))


def draw(T_world_cam: Array, camera: Camera = CAMERA, fine: int = 2) -> Array:
    """The RGB image of the street from a camera pose, averaged over fine x fine rays a pixel."""
    width, height = camera.image_size
    steps = (np.arange(fine) + 0.5) / fine - 0.5
    u = (np.arange(width)[:, None] + steps).ravel()
    v = (np.arange(height)[:, None] + steps).ravel()
    rays = camera.rays(np.stack(np.meshgrid(u, v), axis=-1)) @ T_world_cam[:3, :3].T
    nearest = np.full(rays.shape[:2], np.inf)
    image = np.full(rays.shape[:2], 200.0, np.float32)
    for plane in street():
        rows, columns = part = place(plane, T_world_cam, camera, fine)
        if not nearest[part].size:
            continue
        normal = np.cross(*plane.sides)
        with np.errstate(divide="ignore", invalid="ignore"):
            reach = normal @ (plane.corner - T_world_cam[:3, 3]) / (rays[part] @ normal)
            start = plane.sides @ (T_world_cam[:3, 3] - plane.corner)
            texels = rays[part] @ plane.sides.T * reach[..., None] + start
            texels = (texels * TEXELS).astype(np.float32)
        seen = (reach > 0.0) & (reach < nearest[rows, columns])
        found = cv2.remap(
            plane.paint, texels, None, cv2.INTER_LINEAR,
            borderMode=cv2.BORDER_CONSTANT, borderValue=-1.0,
        )  # fmt: skip
        seen &= found >= 4.0
        image[part][seen], nearest[part][seen] = found[seen], reach[seen]
    grey = image.reshape(height, fine, width, fine).mean(axis=(1, 3))
    return np.repeat(np.round(grey).astype(np.uint8)[:, :, None], 3, axis=2)


def pose(x: float, z: float, yaw: float, camera: Camera = CAMERA) -> Array:
    """T_world_cam of a camera whose car stands there; yaw > 0 turns to the right."""
    return homogeneous(rotation_y(yaw), np.array([x, 0.0, z])) @ camera.T_road_cam


def drive(steps: Sequence[tuple[float, float]], camera: Camera = CAMERA) -> list[Array]:
    """Poses from the start on, after each of the steps: metres ahead, then radians of yaw."""
    x, z, yaw = 0.0, 0.0, 0.0
    poses = [pose(x, z, yaw, camera)]
    for metres, turn in steps:
        x, z, yaw = x + metres * np.sin(yaw), z + metres * np.cos(yaw), yaw + turn
        poses.append(pose(x, z, yaw, camera))
    return poses


def motions(poses: Sequence[Array]) -> list[Array]:
    """The true T_now_before of every pose but the first."""
    return [invert(now) @ before for before, now in pairwise(poses)]


@cache
def filmed(steps: tuple[tuple[float, float], ...]) -> tuple[list[Array], list[Array]]:
    """The images of a drive with a little noise of the sensor, and its true motions."""
    poses, rng = drive(steps), np.random.default_rng(5)
    noisy = []
    for each in poses:
        image = draw(each)
        noise = np.round(rng.normal(0.0, 1.5, image.shape[:2]))[:, :, None]
        noisy.append(np.clip(image + noise, 0, 255).astype(np.uint8))
    return noisy, motions(poses)


def misses(T: Array, truth: Array) -> tuple[float, float, float]:
    """Errors: rotation in degrees, direction in degrees, length as a share."""
    R = T[:3, :3].T @ truth[:3, :3]
    sine = 0.5 * np.linalg.norm([R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]])
    size, true_size = np.linalg.norm(T[:3, 3]), np.linalg.norm(truth[:3, 3])
    along = T[:3, 3] @ truth[:3, 3] / max(size * true_size, 1e-12)
    rotation, direction = np.arctan2(sine, 0.5 * (np.trace(R) - 1.0)), np.arccos(min(along, 1.0))
    length = size / max(true_size, 1e-12) - 1.0
    return float(np.degrees(rotation)), float(np.degrees(direction)), float(length)


STRAIGHT = ((0.9, 0.0),) * 8
CURVE = ((0.7, 0.012),) * 7
