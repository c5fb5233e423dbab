"""Boxes of cuboids, exact: edges and faces are cut at the near plane, then projected."""

import numpy as np
from jaxtyping import Float
from numpy import ndarray as Array

from mot_sim.simulation.renderers.triangles import (
    NEAR_METRES,
    NO_BOX,
    boxes_inside,
    cut_near,
    enclose,
)
from tracker.geometry import transform
from tracker.types import Camera, Cuboids

EDGES = np.array(
    [(0, 1), (1, 2), (2, 3), (3, 0), (4, 5), (5, 6), (6, 7), (7, 4), (0, 4), (1, 5), (2, 6), (3, 7)]
)

QUADS = ((0, 1, 2, 3), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7))
FACES = np.array([(a, *two) for a, b, c, d in QUADS for two in ((b, c), (c, d))])


def project_edges(cuboids: Cuboids, camera: Camera) -> Float[Array, "n 24 2"]:
    """Both ends of the twelve edges in pixels, cut at the near plane; NaN for edges behind it.

    The convex hull of a row is the exact silhouette of what lies before the camera.
    """
    corners = transform(camera.T_cam_road, cuboids.corners())
    start, end = corners[:, EDGES[:, 0]], corners[:, EDGES[:, 1]]
    near = np.concatenate((_cut_near(start, end), _cut_near(end, start)), axis=1)
    return camera.project(near)


def _cut_near(
    points: Float[Array, "n e 3"], others: Float[Array, "n e 3"]
) -> Float[Array, "n e 3"]:
    """The points, those behind the near plane moved onto it along their edges; else NaN."""
    depth, other = points[..., 2:], others[..., 2:]
    behind, crosses = depth < NEAR_METRES, (depth < NEAR_METRES) & (other > NEAR_METRES)
    share = np.where(crosses, (NEAR_METRES - depth) / np.where(crosses, other - depth, 1.0), 0.0)
    moved = points + share * (others - points)
    return np.where(behind & ~crosses, np.nan, moved)


def boxes_around(pixels: Float[Array, "n p 2"]) -> Float[Array, "n 4"]:
    """Upright boxes around points, NaN points left out; an inverted box where all are NaN."""
    known = np.isfinite(pixels)
    low = np.where(known, pixels, np.inf).min(axis=1, initial=np.inf)
    high = np.where(known, pixels, -np.inf).max(axis=1, initial=-np.inf)
    return np.concatenate((low, high), axis=1)


def boxes_in_image(cuboids: Cuboids, camera: Camera) -> Float[Array, "n 4"]:
    """Upright boxes around the parts inside the image, as KITTI labels cars; inverted: none."""
    corners = transform(camera.T_cam_road, cuboids.corners())
    triangles, rows = cut_near(corners[:, FACES].reshape(-1, 3, 3), NEAR_METRES)
    boxes = np.tile(NO_BOX, (len(corners), 1))
    parts = boxes_inside(camera.project(triangles), camera.far_corner[2:])
    enclose(boxes, rows // len(FACES), parts)
    return boxes


def truncation_of(boxes: Float[Array, "n 4"], camera: Camera) -> Float[Array, " n"]:
    """The part of each box's area that is outside the image; 1 of an inverted one."""
    clipped, in_front = camera.clip_boxes(boxes), np.isfinite(boxes).all(axis=1)
    sides = np.where(in_front[:, None], boxes[:, 2:] - boxes[:, :2], 1.0)
    inside = np.maximum(clipped[:, 2:] - clipped[:, :2], 0.0) / np.maximum(sides, 1e-9)
    return np.where(in_front, 1.0 - inside.prod(axis=1), 1.0)
