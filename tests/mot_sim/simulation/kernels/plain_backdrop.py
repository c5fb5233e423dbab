"""The road below the horizon, which picture each row shows, and outlines on it, in plain NumPy."""

import cv2
import numpy as np

from mot_sim.simulation.renderers import Road, Semantic, View
from mot_sim.simulation.renderers.ground import (
    MAX_SUPERSAMPLING,
    MAX_TEXELS_PER_ROW,
    MIN_TEXELS_PER_PIXEL,
    horizon,
    road_warp,
)
from mot_sim.simulation.renderers.shadows import (
    CLEARANCE_METRES,
    CLOSED_REACH_METRES,
    MAX_PIXEL,
    MOST_CLOSED,
    SUBPIXEL_BITS,
)
from mot_sim.simulation.renderers.surroundings import Level
from tracker.types import Camera


def plain_shaded(
    ground: np.ndarray, dark: np.ndarray, closed: np.ndarray, shade: float
) -> np.ndarray:
    """RGB with less light: the sun's share `shade` is taken where dark is 255, the sky's by closed.

    Beneath an object no sun comes either.
    """
    sun, sky = 1.0 - dark / 255.0, 1.0 - MOST_CLOSED * (closed / 255.0)
    beneath = ((closed / 255.0 - 0.42) / 0.12).clip(0.0, 1.0)
    left = np.round(255.0 * ((1.0 - shade) * sky + shade * sun * (1.0 - beneath))).astype(np.uint8)
    return cv2.multiply(ground, cv2.merge((left, left, left)), scale=1.0 / 255.0)


def plain_closed(view: View) -> np.ndarray:
    """How much of the sky boxes hide from the road at each pixel, 255 = all: the darkest counts."""
    (width, height), camera = view.camera.image_size, view.camera
    v, u = np.mgrid[:height, :width].astype(float)
    points = camera.touch_road(np.stack((u, v), axis=-1).reshape(-1, 2))
    found = np.zeros(len(points))
    for mesh, T in zip(view.instances.meshes, view.instances.T_cam_object, strict=True):
        x, _, z = ((points - T[:3, 3]) @ T[:3, :3]).T
        (half_x, _, half_z), high = 0.5 * np.ptp(mesh.vertices, axis=0), np.ptp(mesh.vertices[:, 1])
        out = np.stack((abs(x) - half_x, abs(z) - half_z))
        inside, apart = -out.max(axis=0), np.hypot(*np.maximum(out, 0.0))

        def beside(apart: np.ndarray, high: float = high) -> np.ndarray:
            return 0.5 * (1.0 - apart / np.hypot(apart, high))

        beneath = 0.5 + 0.5 * inside / np.hypot(inside, CLEARANCE_METRES)
        hidden, least = np.where(inside > 0.0, beneath, beside(apart)), beside(CLOSED_REACH_METRES)
        near = (out <= CLOSED_REACH_METRES).all(axis=0)
        share = np.where(near, (hidden - least) / (1.0 - least), 0.0)
        found = np.fmax(found, share.clip(0.0, 1.0))
    return (255.0 * found).reshape(height, width)


def plain_kinds(rgba: np.ndarray, camera: Camera) -> np.ndarray:
    """Sky, road or ground by what `road_rgba` gave."""
    seen, (width, height) = horizon(camera), camera.image_size
    kinds = np.full((height, width), Semantic.SKY, np.uint8)
    below = np.where(rgba[..., 3] > 127, Semantic.ROAD, Semantic.GROUND)
    kinds[seen.first :] = np.where(seen.below[seen.first :] > 0, below, Semantic.SKY)
    return kinds


def plain_cuts(camera: Camera, road: Road) -> list[tuple[int, int]]:
    """Which picture each row from the horizon on shows, and how many times higher it is drawn."""
    rows = camera.image_size[1] - horizon(camera).first
    chosen, finer, sharp = np.zeros(rows, int), np.ones(rows, int), np.zeros(rows, bool)
    for number in reversed(range(len(road.levels))):
        along, across, inside = _footprints(camera, road.levels[number])
        is_last = number == len(road.levels) - 1
        takes = np.ones(rows, bool) if is_last else inside & ~sharp
        steps = np.ceil(np.log2(np.maximum(along, 1e-9) / MAX_TEXELS_PER_ROW))
        steps = steps.clip(0, np.log2(MAX_SUPERSAMPLING))
        smooth = 2 ** np.maximum.accumulate(steps[::-1])[::-1]
        chosen[takes], finer[takes] = number, smooth[takes].astype(int)
        sharp |= takes & (across >= MIN_TEXELS_PER_PIXEL)
    return list(zip(chosen.tolist(), finer.tolist(), strict=True))


def _footprints(camera: Camera, level: Level) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """For each row with road: a pixel's texels down and across; whether the level covers it."""
    first, (width, height) = horizon(camera).first, camera.image_size
    A_texture_image = np.linalg.inv(road_warp(camera, level))
    rows, middle = np.arange(first, height + 1, dtype=float), 0.5 * width
    u = np.array([middle, middle + 1.0, -0.5, width - 0.5])[:, None] + np.zeros_like(rows)
    seen = np.tensordot(A_texture_image, np.stack((u, u * 0.0 + rows, u * 0.0 + 1.0)), axes=1)
    points = seen[:2] / seen[2]
    along = np.hypot(*np.diff(points[:, 0], axis=1))
    across = np.hypot(*(points[:, 1] - points[:, 0]))[:-1]
    size = np.array(level.texture.size)[:, None, None] - 1.0
    inside = ((points[:, 2:] >= 0.0) & (points[:, 2:] <= size)).all(axis=(0, 1))
    deep = horizon(camera).depth[first:].max(axis=1) <= level.reach
    return along, across, inside[:-1] & inside[1:] & deep


def plain_touched(outline: np.ndarray, count: int) -> np.ndarray:
    """Which of count x count tiles of side 1 a convex outline touches, by separating edges."""
    steps = np.arange(count, dtype=float)
    low, high = outline.min(axis=0), outline.max(axis=0)
    touched = ((steps < high[0]) & (steps + 1.0 > low[0]))[None] & (
        (steps < high[1]) & (steps + 1.0 > low[1])
    )[:, None]
    edges = np.roll(outline, -1, axis=0) - outline
    normals = np.stack((edges[:, 1], -edges[:, 0]), axis=1)
    middle = outline.mean(axis=0)
    normals *= np.sign(((outline - middle) * normals).sum(axis=1))[:, None]  # outwards
    offsets = (outline * normals).sum(axis=1)
    corner = np.where(normals < 0.0, 1.0, 0.0)
    u, v = steps[:, None] + corner[:, 0], steps[:, None] + corner[:, 1]
    inner = u[None] * normals[:, 0] + v[:, None] * normals[:, 1]
    return touched & (inner <= offsets + 1e-9).all(axis=2)


def plain_drawn(
    camera: Camera, corners: np.ndarray, ends: np.ndarray, near: float
) -> list[np.ndarray | None]:
    """Outlines on the road in fixed-point pixels; None for those that have to be cut."""
    T, polygons = camera.T_cam_road, []
    for points in np.split(corners, ends[:-1]):
        points_cam = points @ T[:3, [0, 2]].T + T[:3, 3]
        pixels = camera.project(points_cam)
        whole = (points_cam[:, 2] >= near).all() and (np.abs(pixels) < MAX_PIXEL).all()
        fixed = np.round(np.nan_to_num(pixels) * (1 << SUBPIXEL_BITS))
        polygons.append(fixed.astype(np.int64) if whole else None)
    return polygons
