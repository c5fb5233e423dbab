"""A schematic world as the camera sees it, and boxes over it."""

import math
from functools import lru_cache

import cv2
import numpy as np
from jaxtyping import Float, Float32
from numpy import ndarray as Array

from mot_sim.renderers.triangles import NEAR
from mot_sim.report.canvas import Image, box, fill, text, text_width
from mot_sim.report.carbody import VAN_HEIGHT, car_faces
from mot_sim.report.colours import (
    CAR_PAINTS,
    DETECTION,
    GRASS,
    HAZE,
    PAINT,
    SHADOW,
    SKY_LOW,
    SKY_TOP,
    Colour,
    colour_of_id,
    ink_on,
    mix,
)
from mot_sim.rig import Rig, clip_polygon
from mot_sim.traffic.roads import Roads
from mot_sim.traffic.world import World, outline
from tracker.geometry import transform
from tracker.types import Camera, Cuboids, Detections, Tracks

HAZE_RANGE = 220.0  # metres in which two thirds of a colour are lost in the haze
GROUND_RANGE = 400.0  # metres of ground around the camera; beyond it is haze
LIGHT = np.array([-0.352, -0.755, -0.553])  # unit vector to the sun, in the road frame


def draw_world(world: World, rig: Rig, roads: Roads) -> Image:
    """The camera's view of a world: sky, ground, roads, and cars from far to near."""
    sky, haze = _backdrop(rig.camera)
    image = sky.copy()
    _draw_ground(image, world, rig, roads)
    image = cv2.blendLinear(image, np.full_like(image, HAZE), 1.0 - haze, haze)
    cuboids = rig.cuboids(world)
    _draw_shadows(image, world, rig)
    distance = np.hypot(cuboids.base[:, 0], cuboids.base[:, 2])
    for row in np.argsort(-distance, kind="stable").tolist():
        paint = CAR_PAINTS[int(world.ids[row]) % len(CAR_PAINTS)]
        fade = float(1.0 - np.exp(-distance[row] / HAZE_RANGE))
        _draw_car(image, cuboids.select([row]), rig.camera, paint, fade)
    return image


def draw_detections(image: Image, detections: Detections) -> None:
    """Thin grey boxes; drawn over the tracks' boxes they are the light core of the line."""
    for corners in detections.boxes:
        box(image, corners, DETECTION)


def draw_tracks(image: Image, tracks: Tracks) -> None:
    """Boxes in the colours of their ids, each with its id; the lower ones (nearer) on top."""
    for row in np.argsort(tracks.boxes[:, 3], kind="stable").tolist():
        colour = colour_of_id(int(tracks.ids[row]))
        box(image, tracks.boxes[row], colour, 3)
        _label(image, str(tracks.ids[row]), tracks.boxes[row], colour)


def _label(image: Image, words: str, corners: Float[Array, "4"], colour: Colour) -> None:
    """A tag on the upper left corner of a box, moved into the image."""
    width = text_width(words) + 8
    left = int(np.clip(round(corners[0]) - 1, 0, image.shape[1] - width))
    bottom = max(round(corners[1]), 18)
    cv2.rectangle(image, (left, bottom - 18), (left + width, bottom), colour, cv2.FILLED)
    text(image, words, (left + 4, bottom - 3), ink_on(colour))


@lru_cache(maxsize=8)
def _backdrop(camera: Camera) -> tuple[Image, Float32[Array, "h w"]]:
    """The empty sky, and how much of the haze lies over the road at every pixel."""
    width, height = camera.image_size
    v, u = np.mgrid[0:height, 0:width].astype(float)
    rays = camera.rays(np.stack((u, v), axis=-1))
    dip = rays @ camera.road_normal
    rise = np.clip(-dip / 0.24, 0.0, 1.0)[:, :, None] ** 0.8
    sky = np.array(SKY_LOW) + rise * (np.array(SKY_TOP) - np.array(SKY_LOW, dtype=float))
    sky[dip > 0.0] = HAZE
    depth = camera.height / np.maximum(dip, 1e-6)
    haze = np.where(dip > 0.0, 1.0 - np.exp(-depth / HAZE_RANGE), 0.0)
    return sky.astype(np.uint8), haze.astype(np.float32)


def _draw_ground(image: Image, world: World, rig: Rig, roads: Roads) -> None:
    """Grass, then every patch of the roads."""
    reach = GROUND_RANGE * np.array([(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)])
    patches = [(GRASS, world.ego[:2] + reach)]
    patches += [(PAINT[surface.paint], surface.corners) for surface in roads.surfaces]
    ground = rig.ground_cam(world.ego, np.concatenate([corners for _, corners in patches]))
    first = 0
    for colour, corners in patches:
        points_cam = ground[first : first + len(corners)]
        first += len(corners)
        _fill_cam(image, points_cam, rig.camera, colour)


def _draw_shadows(image: Image, world: World, rig: Rig) -> None:
    """A dark patch under every car, a little larger than the car."""
    poses = np.stack((world.x, world.y, world.heading), axis=1)
    for corners in outline(poses, world.size * (1.03, 1.0, 1.10)):
        _fill_cam(image, rig.ground_cam(world.ego, corners), rig.camera, SHADOW)


def _draw_car(image: Image, cuboid: Cuboids, camera: Camera, paint: Colour, fade: float) -> None:
    """The faces of one car that look at the camera."""
    c, s = np.cos(cuboid.yaw[0]), np.sin(cuboid.yaw[0])
    axes = np.array([(c, 0.0, -s), (-s, 0.0, -c), (0.0, -1.0, 0.0)])  # forward, right, up
    extent = cuboid.size[0, [0, 2, 1]]
    eye = camera.T_road_cam[:3, 3]
    for face in car_faces(bool(cuboid.size[0, 1] >= VAN_HEIGHT)):
        points_road = cuboid.base[0] + (face.corners * extent) @ axes
        normal = (face.normal / extent) @ axes  # normals stretch inversely to points
        if normal @ (eye - points_road[0]) > 0.0:
            towards_light = float(normal @ LIGHT) / math.sqrt(float(normal @ normal))
            colour = mix((0, 0, 0), face.colour or paint, 0.62 + 0.38 * max(0.0, towards_light))
            points_cam = transform(camera.T_cam_road, points_road)
            _fill_cam(image, points_cam, camera, mix(colour, HAZE, fade))


def _fill_cam(
    image: Image, points_cam: Float[Array, "n 3"], camera: Camera, colour: Colour
) -> None:
    """Fill a polygon of the camera frame, cut at the near plane and at the image's border."""
    clipped = clip_polygon(points_cam, points_cam[:, 2], NEAR)
    if len(clipped) < 3:
        return
    pixels = camera.project(clipped)
    low, high = pixels.min(axis=0), pixels.max(axis=0)
    height, width = image.shape[:2]
    if (high < 0.0).any() or low[0] > width or low[1] > height:
        return
    margin = 50.0
    if (low < -margin).any() or high[0] > width + margin or high[1] > height + margin:
        for axis, last in ((0, width + margin), (1, height + margin)):
            pixels = clip_polygon(pixels, pixels[:, axis], -margin)
            pixels = clip_polygon(pixels, last - pixels[:, axis])
    fill(image, pixels, colour)
