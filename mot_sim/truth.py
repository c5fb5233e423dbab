"""Ground truth from cuboids: exact boxes, truncation, visible fraction, KITTI's levels."""

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from jaxtyping import Float, Int
from numpy import ndarray as Array

from mot_sim.rig import Rig, clip_polygon
from mot_sim.traffic.world import World
from tracker.geometry import polygon_area, transform
from tracker.types import Camera, Cuboids, Rows, Tracks

NEAR = 0.3  # metres before the camera; nothing nearer is in its view
EDGES = np.array(
    [(0, 1), (1, 2), (2, 3), (3, 0), (4, 5), (5, 6), (6, 7), (7, 4), (0, 4), (1, 5), (2, 6), (3, 7)]
)
# Visible fractions from which KITTI's occlusion is 0 (fully visible), 1 (partly) and 2 (largely
# occluded); below the last it is 3 (unknown), which nobody has to find. KITTI's annotators
# judged by eye: the numbers are ours.
OCCLUSION_LEVELS = (0.8, 0.5, 0.2)
# A car is truncated (KITTI's level 1) when more than this part of its box is outside the image.
MAX_CUT = 0.05
SHIFT = 4  # fractional bits of the polygons' corners


@dataclass(frozen=True, eq=False)
class Truth(Rows):
    """What is true of every car in every frame, in the order of frames and ids.

    tracks: boxes clipped to the image, KITTI's levels, cuboids in the road frame. visible:
    pixels seen over the pixels of the whole silhouette inside the image. cut: part of the
    unclipped box's area that is outside the image. full_boxes: not clipped to the image, of
    what is before the camera. speed: m/s.
    """

    tracks: Tracks
    visible: Float[Array, " n"]
    cut: Float[Array, " n"]
    full_boxes: Float[Array, "n 4"]
    speed: Float[Array, " n"]


def exact_truth(worlds: Sequence[World], rig: Rig) -> Truth:
    """The truth of all frames; world i is frame i."""
    return Truth.concatenate([frame_truth(world, rig, frame) for frame, world in enumerate(worlds)])


def frame_truth(world: World, rig: Rig, frame: int) -> Truth:
    """The truth of one frame: every car with a pixel in the image, hidden ones too."""
    camera = rig.camera
    cuboids = rig.cuboids(world)
    pixels = project_edges(cuboids, camera)
    full_boxes = boxes_around(pixels)
    boxes, cut = clip_to_image(full_boxes, camera)
    outlines = [silhouette(points, camera) for points in pixels]
    distance = np.hypot(cuboids.base[:, 0], cuboids.base[:, 2])
    seen, whole = count_pixels(outlines, np.argsort(-distance, kind="stable"), camera)
    visible = seen / np.maximum(whole, 1)
    count = len(world)
    tracks = Tracks(
        frames=np.full(count, frame),
        ids=world.ids,
        boxes=boxes,
        kinds=np.full(count, "Car", dtype="<U8"),
        truncation=(cut > MAX_CUT).astype(np.int64),
        occlusion=occlusion_level(visible),
        cuboids=cuboids,
    )
    truth = Truth(tracks, visible, cut, full_boxes, world.speed)
    has_area = (boxes[:, 2:] > boxes[:, :2]).all(axis=1)
    return truth.select((whole > 0) & has_area)


def occlusion_level(visible: Float[Array, " n"]) -> Int[Array, " n"]:
    """KITTI's level of a visible fraction: 0 from .8 on, 1 from .5, 2 from .2, else 3."""
    return (visible[:, None] < np.array(OCCLUSION_LEVELS)).sum(axis=1).astype(np.int64)


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
    behind, crosses = depth < NEAR, (depth < NEAR) & (other > NEAR)
    share = np.where(crosses, (NEAR - depth) / np.where(crosses, other - depth, 1.0), 0.0)
    moved = points + share * (others - points)
    return np.where(behind & ~crosses, np.nan, moved)


def boxes_around(pixels: Float[Array, "n p 2"]) -> Float[Array, "n 4"]:
    """Upright boxes around points, NaN points left out; an inverted box where all are NaN."""
    known = np.isfinite(pixels)
    low = np.where(known, pixels, np.inf).min(axis=1, initial=np.inf)
    high = np.where(known, pixels, -np.inf).max(axis=1, initial=-np.inf)
    return np.concatenate((low, high), axis=1)


def clip_to_image(
    boxes: Float[Array, "n 4"], camera: Camera
) -> tuple[Float[Array, "n 4"], Float[Array, " n"]]:
    """The boxes inside the image, and the part of each one's area that is outside."""
    width, height = camera.image_size
    clipped = boxes.clip(0.0, (width - 1.0, height - 1.0, width - 1.0, height - 1.0))
    in_front = np.isfinite(boxes).all(axis=1)
    sides = np.where(in_front[:, None], boxes[:, 2:] - boxes[:, :2], 1.0)
    inside = np.maximum(clipped[:, 2:] - clipped[:, :2], 0.0) / np.maximum(sides, 1e-9)
    return clipped, np.where(in_front, 1.0 - inside.prod(axis=1), 1.0)


def silhouette(points: Float[Array, "p 2"], camera: Camera) -> Float[Array, "q 2"]:
    """The convex hull of the points in pixels, cut by the image's border; perhaps no corner."""
    known = points[np.isfinite(points).all(axis=1)]
    if len(known) < 3:
        return known[:0]
    hull = cv2.convexHull(known.astype(np.float32))[:, 0].astype(np.float64)
    width, height = camera.image_size
    for axis, last in ((0, width - 1.0), (1, height - 1.0)):
        hull = clip_polygon(hull, hull[:, axis])
        hull = clip_polygon(hull, last - hull[:, axis])
    if len(hull) < 3 or polygon_area(hull[None])[0] <= 0.0:
        return hull[:0]
    return hull


def count_pixels(
    outlines: Sequence[Float[Array, "_ 2"]], far_to_near: Int[Array, " n"], camera: Camera
) -> tuple[Int[Array, " n"], Int[Array, " n"]]:
    """Pixels seen of every silhouette when the nearer cover the farther, and all its pixels."""
    width, height = camera.image_size
    numbers = np.zeros((height, width), np.int32)  # 1 + row of the nearest car; 0: none
    whole = np.zeros(len(outlines), np.int64)
    for row in far_to_near.tolist():
        if len(outlines[row]):
            fixed = np.round(outlines[row] * (1 << SHIFT)).astype(np.int32)
            alone = np.zeros((height, width), np.uint8)
            cv2.fillConvexPoly(alone, fixed, 1, cv2.LINE_8, SHIFT)
            cv2.fillConvexPoly(numbers, fixed, row + 1, cv2.LINE_8, SHIFT)
            whole[row] = cv2.countNonZero(alone)
    return np.bincount(numbers.ravel(), minlength=len(outlines) + 1)[1:], whole
