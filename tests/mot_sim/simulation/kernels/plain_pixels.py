"""Filled, laid over one another, counted and painted triangles, in plain NumPy."""

import numpy as np

from mot_sim.simulation.renderers import NO_INSTANCE, Scan, Semantic, Sun
from mot_sim.simulation.renderers.raster import (
    GROUND_LIGHT_SHARE,
    ROAD_LIGHT_SHARE,
    ROUNDING,
    SHINE,
    SKY_COLOUR,
    SUN_GLINT_LEVELS,
)
from mot_sim.simulation.renderers.triangles import Triangles
from mot_sim.simulation.truth.annotate import SLANT_PIXELS, THICKNESS_METRES
from tests.mot_sim.simulation.kernels.plain_triangles import projected
from tracker.types import Camera


def plain_nearness(triangles: Triangles, camera: Camera) -> tuple[np.ndarray, np.ndarray]:
    """How near each triangle is at each pixel (t, h, w), 0 where it is not; where that is clear.

    Not clear is what an edge passes closer than 1e-7 pixels.
    """
    (width, height), count = camera.image_size, len(triangles)
    near, clear = np.zeros((count, height, width)), np.ones((count, height, width), bool)
    v, u = np.mgrid[:height, :width].astype(float)
    for row, corners in enumerate(projected(triangles, camera)):
        edges = np.roll(corners, -1, axis=0) - corners
        area = edges[0, 0] * edges[1, 1] - edges[0, 1] * edges[1, 0]
        if abs(area) < 1e-9:
            continue
        sides = np.stack([
            (a * (v - start[1]) - b * (u - start[0])) / area
            for (a, b), start in zip(edges, corners, strict=True)
        ])  # fmt: skip
        inverse = np.tensordot(1.0 / triangles.corners[row, :, 2], sides[[1, 2, 0]], 1)
        near[row] = np.where((sides >= 0.0).all(axis=0), inverse, 0.0)
        lengths = np.hypot(*edges.T)[:, None, None]
        clear[row] = (np.abs(sides * area) > 1e-7 * lengths).all(axis=0)
    return near, clear


def plain_counts(crops: np.ndarray) -> tuple[np.ndarray, ...]:
    """Of the nearness of layers (k, h, w), the first of scenery: nearest, and the measures.

    numbers, whole, visible, visible boxes of all but the first, and (hidden, hiding, pixels).
    """
    numbers = np.where(crops.max(axis=0) > 0.0, crops.argmax(axis=0) + 1, 0)
    whole, visible, boxes, hidden = [], [], [], []
    for layer in range(1, len(crops)):
        silhouette, mine = crops[layer] > 0.0, numbers == layer + 1
        whole.append(silhouette.sum())
        visible.append(mine.sum())
        v, u = np.nonzero(mine)
        around = (np.inf, np.inf, -np.inf, -np.inf)
        boxes.append((u.min(), v.min(), u.max(), v.max()) if len(u) else around)
        others, pixels = np.unique(numbers[silhouette & ~mine], return_counts=True)
        hidden += [(layer, other - 1, count) for other, count in zip(others, pixels, strict=True)]
    measures = np.array(whole, int), np.array(visible, int), np.array(boxes, float).reshape(-1, 4)
    return numbers, *measures, np.array(hidden, int).reshape(-1, 3)


def plain_states(
    points: np.ndarray, faces_us: np.ndarray, ids: np.ndarray, scanned: Scan, camera: Camera
) -> np.ndarray:
    """A `KeypointVisibility` of each point (n, k, 3), one after the other."""
    (width, height), states = camera.image_size, np.full(points.shape[:2], 3, np.uint8)
    for car, point in np.ndindex(*states.shape):
        depth = points[car, point, 2]
        if not depth > 0.3:
            continue
        column, row = np.floor(camera.project(points[car, point]) + 0.5).astype(int)
        if not (0 <= column < width and 0 <= row < height):
            continue
        other = scanned.instances[row, column] != ids[car] and scanned.nearness[row, column] > 0.0
        states[car, point] = 2 if other else 0
        around = []
        for layer in scanned.layers:
            if layer.instance == ids[car]:
                left, top, right, bottom = layer.box
                whole = np.zeros((height + 2, width + 2))
                whole[top + 1 : bottom + 1, left + 1 : right + 1] = layer.nearness
                around = whole[row : row + 3, column : column + 3].ravel()
        drawn = [1.0 / near for near in around if near > 0.0]
        allowed = THICKNESS_METRES + SLANT_PIXELS * depth / camera.K[0, 0]
        if not faces_us[car, point] or (drawn and max(drawn) < depth - allowed):
            states[car, point] = 1
    return states


def plain_paint(triangles: Triangles, codes: np.ndarray, camera: Camera, sun: Sun) -> np.ndarray:
    """Lit colours and semantic ids, all triangles at once."""
    R_cam_road = camera.T_cam_road[:3, :3]
    to_up, to_sun = -R_cam_road[:, 1], R_cam_road @ sun.direction
    normals, semantics = triangles.normals, codes[:, 3]
    up, towards = normals @ to_up, normals @ to_sun
    sky = sun.ambient * (0.5 * (1.0 + ROAD_LIGHT_SHARE) + 0.5 * (1.0 - ROAD_LIGHT_SHARE) * up)
    leaves = semantics == Semantic.VEGETATION
    direct = np.where(leaves, 0.4 + 0.35 * towards, np.maximum(towards, 0.0))
    level = sun.ambient + (1.0 - sun.ambient) * -sun.direction[1]
    strength = (sky + (1.0 - sun.ambient) * direct) / level
    straight, flat, narrow = SHINE[semantics].T
    points = triangles.corners[:, 0]
    distance = np.linalg.norm(points, axis=1)
    facing = (-(normals * points).sum(axis=1) / distance).clip(0.0, 1.0)
    mirrored = 2.0 * facing[:, None] * normals + points / distance[:, None]
    seen_sky = GROUND_LIGHT_SHARE + (1.0 - GROUND_LIGHT_SHARE) * np.clip(
        2.0 * mirrored @ to_up + 0.35, 0.0, 1.0
    )
    share = (straight + flat * (1.0 - facing) ** 4) * seen_sky
    glint = np.where(narrow > 0.0, np.maximum(mirrored @ to_sun, 1e-3) ** narrow, 0.0)
    light = share[:, None] * SKY_COLOUR + (SUN_GLINT_LEVELS * sun.shade * glint)[:, None]
    colours = codes[:, :3] * strength[:, None] + light
    painted = codes.copy()
    painted[:, :3] = np.minimum(colours + ROUNDING, 255.0)
    return painted


def plain_instances(numbers: np.ndarray, ids: np.ndarray) -> np.ndarray:
    """Ids by triangle number."""
    return np.concatenate(([NO_INSTANCE], ids))[numbers]


def plain_seen(triangles: Triangles, numbers: np.ndarray) -> np.ndarray:
    """Which triangles stand in an image of numbers, 1 + row each."""
    return np.isin(np.arange(1, len(triangles) + 1), numbers)
