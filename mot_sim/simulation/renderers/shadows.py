"""Soft shadows on the road: the cast ones of the sun, and the dark around and beneath objects."""

from dataclasses import dataclass
from functools import cached_property, lru_cache

import cv2
import numpy as np
from jaxtyping import Float, Int, Int32, UInt8
from numpy import ndarray as Array

from mot_sim.simulation.renderers.surroundings import Sun
from mot_sim.simulation.renderers.triangles import clip_polygon, side_planes
from mot_sim.simulation.renderers.view import Mesh, View
from tracker.geometry import transform
from tracker.kernels import Kernel
from tracker.types import Camera

CLOSE_SKY = Kernel("mot_sim.simulation.kernels.backdrop", "close_sky")
PROJECT_OUTLINES = Kernel("mot_sim.simulation.kernels.backdrop", "project_outlines")

SUBPIXEL_BITS = 4  # fractional bits of the polygons' corners
MAX_PIXEL = 8000.0  # pixels; OpenCV's fixed-point corners overflow beyond 16 bits
MAX_SHADOW_METRES = 150.0  # metres: a shadow farther away is a quarter of a pixel high
# Layers, from light to dark: how far the outline is moved out in metres, and how much of the
# full darkness it has.
CAST_LAYERS = ((0.10, 0.3), (0.03, 0.65), (-0.05, 1.0))
CLEARANCE_METRES = 0.14  # of objects above the road: light comes in beneath them so far
CLOSED_REACH_METRES = 1.5  # beside an object, to where it takes light from the road
MOST_CLOSED = 0.94  # of the sky, beneath an object


@dataclass(frozen=True, eq=False)
class Outlines:
    """Convex outlines on the road, one after the other."""

    corners: Float[Array, "k 2"]
    """Corners x, z in the `road` frame of all outlines, metres."""
    ends: Int[Array, " n"]
    """Row after the last corner of each outline."""

    @classmethod
    def around(cls, groups: list[Float[Array, "_ 2"]]) -> "Outlines":
        """The convex hulls of groups of points on the road."""
        hulls = [cv2.convexHull(points.astype(np.float32))[:, 0] for points in groups]
        ends = np.cumsum([len(hull) for hull in hulls])
        return cls(np.concatenate(hulls).astype(np.float64), ends)

    @cached_property
    def middle_and_half(self) -> tuple[Float[Array, "k 2"], Float[Array, "k 1"]]:
        """For each corner its outline's middle, and half its outline's shorter side."""
        starts = np.concatenate(([0], self.ends[:-1]))
        low = np.minimum.reduceat(self.corners, starts)
        high = np.maximum.reduceat(self.corners, starts)
        middle, half = 0.5 * (low + high), 0.5 * (high - low).min(axis=1, keepdims=True)
        length = self.ends - starts
        return np.repeat(middle, length, axis=0), np.repeat(half, length, axis=0)

    def grown(self, distance: float) -> Float[Array, "k 2"]:
        """All corners, moved out from their outlines' middles by about a distance, metres."""
        middle, half = self.middle_and_half
        scale = np.maximum(1.0 + distance / np.maximum(half, 1e-9), 0.0)
        return middle + (self.corners - middle) * scale


def shadow_mask(view: View, near: float, rows: Int[Array, " k"]) -> UInt8[Array, "h w"]:
    """How much of the sun shadows take from the road at each pixel, 255 = all of it.

    rows: of the objects, see `casters`.
    """
    width, height = view.camera.image_size
    mask = np.zeros((height, width), np.uint8)
    if not len(rows) or view.sun.shade <= 0.0:
        return mask
    outlines = outlines_of(view, rows)
    for distance, darkness in CAST_LAYERS:
        corners = outlines.grown(distance)
        for polygon in drawn(view.camera, corners, outlines.ends, near):
            cv2.fillConvexPoly(mask, polygon, 255.0 * darkness, cv2.LINE_8, SUBPIXEL_BITS)
    return cv2.blur(mask, (3, 3))


def closed_mask(
    view: View, first: int, rows: Int[Array, " k"], numbers: Int32[Array, "h w"]
) -> UInt8[Array, "h w"]:
    """How much of the sky objects hide from the road at each pixel from a row on, 255 = all.

    rows: of the objects, see `casters`. numbers: over 0 where nobody asks.
    """
    width, height = view.camera.image_size
    mask = np.zeros((height, width), np.uint8)
    if not len(rows):
        return mask
    meshes = [view.instances.meshes[row] for row in rows.tolist()]
    low, high = (np.stack([mesh.bounds[side] for mesh in meshes]) for side in (0, 1))
    middle, half = 0.5 * (low + high), 0.5 * (high - low)
    T_road_object = view.camera.T_road_cam @ view.instances.T_cam_object[rows]
    axes = T_road_object[:, :3, [0, 2]].swapaxes(1, 2)  # x and z of the objects in the road's frame
    A_road_pixel, height_above = view.camera.A_road_pixel, view.camera.height
    # A ray meets the road where it has gone down the camera's height.
    As = np.empty((len(rows), 3, 3))
    away = (axes @ T_road_object[:, :3, 3:])[..., 0] + middle[:, [0, 2]]
    As[:, :2] = height_above * (axes[..., [0, 2]] @ A_road_pixel[[0, 2]])
    # The camera stands at road (0, -height, 0).
    As[:, :2] -= away[..., None] * A_road_pixel[1]
    As[:, 2] = A_road_pixel[1]
    sizes = np.ascontiguousarray(half[:, [0, 2, 1]]) * (1.0, 1.0, 2.0)
    CLOSE_SKY(As, sizes, CLEARANCE_METRES, CLOSED_REACH_METRES, first, numbers, mask)
    return mask


@lru_cache(maxsize=8)
def light_left(shade: float) -> UInt8[Array, "256 256"]:
    """The road's light, 255 = all, by how much of the sun and of the sky is hidden, 255 = all.

    shade: the sun's share of the light, 0 to 1.
    """
    hidden = np.arange(256) / 255.0
    sky = (1.0 - shade) * (1.0 - MOST_CLOSED * hidden)
    beneath = ((hidden - 0.42) / 0.12).clip(0.0, 1.0)  # an object no sun comes either
    left = sky + shade * (1.0 - hidden[:, None]) * (1.0 - beneath)
    return np.round(255.0 * left).astype(np.uint8)


def casters(view: View, near: float) -> Int[Array, " k"]:
    """The objects whose shadows may lie in the image; a few more, never fewer."""
    instances = view.instances
    rows = np.array(
        [row for row, mesh in enumerate(instances.meshes) if has_shadow(mesh)], np.int64
    )
    if not len(rows):
        return rows
    spheres = [instances.meshes[row].sphere for row in rows.tolist()]
    T_road_object = view.camera.T_road_cam @ instances.T_cam_object[rows]
    centres = transforms(T_road_object, np.stack([centre for centre, _ in spheres])[:, None])[:, 0]
    radii = np.array([radius for _, radius in spheres])
    x, y, z = view.sun.direction
    highest = np.maximum(radii - centres[:, 1], 0.0)
    half = 0.5 * highest[:, None] * np.array([x, z]) / y  # the shadow's middle lies so far aside
    centres[:, [0, 2]] += half
    around = transform(view.camera.T_cam_road, centres)
    reach = radii + np.hypot(*half.T) + 0.5
    inside = around @ side_planes(view.camera).T >= -reach[:, None]
    depth = around[:, 2]
    return rows[(depth + reach > near) & (depth - reach < MAX_SHADOW_METRES) & inside.all(axis=1)]


def outlines_of(view: View, rows: Int[Array, " k"]) -> Outlines:
    """The outlines on the road of the shadows that some objects cast."""
    extremes = [view.instances.meshes[row].extremes for row in rows.tolist()]
    lengths = [len(points) for points in extremes]
    T_road_object = view.camera.T_road_cam @ view.instances.T_cam_object[rows]
    points = transforms(
        np.repeat(T_road_object, lengths, axis=0), np.concatenate(extremes)[:, None]
    )
    return Outlines.around(np.split(fall(points[:, 0], view.sun), np.cumsum(lengths)[:-1]))


def transforms(Ts: Float[Array, "n 4 4"], points: Float[Array, "n k 3"]) -> Float[Array, "n k 3"]:
    """Each group of points, moved by its own transform."""
    return points @ Ts[:, :3, :3].swapaxes(1, 2) + Ts[:, None, :3, 3]


def has_shadow(mesh: Mesh) -> bool:
    """Whether a mesh darkens the road."""
    return mesh.casts and len(mesh.vertices) >= 3


def fall(points_road: Float[Array, "k 3"], sun: Sun) -> Float[Array, "k 2"]:
    """Where the sun's light through the points meets the road, (x, z)."""
    x, y, z = sun.direction
    return points_road[:, [0, 2]] - points_road[:, 1:2] * np.array([x, z]) / y


def drawn(
    camera: Camera, corners: Float[Array, "k 2"], ends: Int[Array, " n"], near: float
) -> list[Int32[Array, "_ 2"]]:
    """Outlines on the road in OpenCV's fixed-point pixels, their parts behind `near` cut off."""
    T, fixed, whole = (
        camera.T_cam_road,
        np.empty(corners.shape, np.int32),
        np.empty(len(ends), bool),
    )
    places = np.ascontiguousarray(corners), ends, T, np.ascontiguousarray(camera.K, float)
    PROJECT_OUTLINES(*places, near, MAX_PIXEL, float(1 << SUBPIXEL_BITS), fixed, whole)
    polygons, start = [], 0
    for end, is_whole in zip(ends.tolist(), whole.tolist(), strict=True):
        if is_whole:
            polygons.append(fixed[start:end])
        else:
            polygon = _cut(camera, corners[start:end] @ T[:3, [0, 2]].T + T[:3, 3], near)
            if len(polygon) >= 3:
                polygons.append(_fixed(polygon))
        start = end
    return polygons


def _cut(camera: Camera, points_cam: Float[Array, "k 3"], near: float) -> Float[Array, "q 2"]:
    """The pixels of an outline's part before `near`, not farther out than OpenCV can count."""
    polygon = camera.project(clip_polygon(points_cam, points_cam[:, 2], near))
    for axis in (0, 1):
        for side in (1.0, -1.0):
            polygon = clip_polygon(polygon, MAX_PIXEL + side * polygon[:, axis])
    return polygon


def _fixed(pixels: Float[Array, "n 2"]) -> Int32[Array, "n 2"]:
    return np.round(pixels * (1 << SUBPIXEL_BITS)).astype(np.int32)
