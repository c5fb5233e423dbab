"""The backdrop of a view: the sky, and the road as a perspective warp with exact depth."""

from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise

import cv2
import numpy as np
from jaxtyping import Float, Float32, UInt8
from numpy import ndarray as Array

from mot_sim.renderers.surroundings import Road, Sky
from mot_sim.renderers.view import Semantic
from tracker.types import Camera

# Rows near the horizon see many texels at once: they are warped so many times higher, and then
# averaged; that many times at most.
MOST = 4
SKY_RANGE = 0.35  # slope above the horizon from which on the sky has its top colour


@dataclass(frozen=True, eq=False)
class Horizon:
    """Where a camera sees the road plane, and how far it is; fixed for a camera.

    depth: metres along the optical axis, inf above the horizon. below: 255 where the road
    is, else 0. first: the first row with road. slope: of the rays, up from the horizon.
    """

    depth: Float32[Array, "h w"]
    below: UInt8[Array, "h w"]
    first: int
    slope: Float32[Array, "h w"]


@lru_cache(maxsize=8)
def horizon(camera: Camera) -> Horizon:
    """The horizon of a camera: its road is `road_normal . X = height`."""
    width, height = camera.image_size
    down_u, down_v, down = camera.A_road_pixel[1]  # how steeply a pixel's ray goes down
    u, v = np.arange(width), np.arange(height)[:, None]
    falling = down_u * u + down_v * v + down
    below = falling > 1e-9
    depth = np.where(below, camera.height / np.where(below, falling, 1.0), np.inf)
    rows = np.flatnonzero(below.any(axis=1))
    first = int(rows[0]) if len(rows) else height
    mask = np.where(below, 255, 0).astype(np.uint8)
    return Horizon(depth.astype(np.float32), mask, first, (-falling).astype(np.float32))


@lru_cache(maxsize=8)
def sky_image(camera: Camera, sky: Sky) -> UInt8[Array, "h w 3"]:
    """The sky alone, all over the image."""
    share = (horizon(camera).slope / SKY_RANGE).clip(0.0, 1.0)[..., None]
    low, top = np.array(sky.low, np.float32), np.array(sky.top, np.float32)
    return np.round(low + share * (top - low)).astype(np.uint8)


def road_warp(camera: Camera, road: Road) -> Float[Array, "3 3"]:
    """From the texture's homogeneous pixels to the image's."""
    A_image_road = camera.K @ camera.T_cam_road[:3][:, [0, 2, 3]]
    return A_image_road @ np.linalg.inv(road.A_texture_road)


def road_image(camera: Camera, road: Road) -> UInt8[Array, "r w 3"]:
    """The road from the horizon's first row down; what is above the horizon means nothing."""
    first, (width, height) = horizon(camera).first, camera.image_size
    A_image_texture = road_warp(camera, road)
    image = np.empty((height - first, width, 4), np.uint8)
    for top, bottom, finer in bands(camera, road):
        A_band_image = np.array([
            [1.0, 0.0, 0.0], [0.0, finer, 0.5 * (finer - 1.0) - finer * top], [0.0, 0.0, 1.0],
        ])  # fmt: skip
        band = cv2.warpPerspective(
            road.texture.rgba,
            A_band_image @ A_image_texture,
            (width, (bottom - top) * finer),
            flags=cv2.INTER_LINEAR,
            borderMode=cv2.BORDER_CONSTANT,
            borderValue=(*road.around, 255),
        )
        if finer > 1:
            band = cv2.resize(band, (width, bottom - top), interpolation=cv2.INTER_AREA)
        image[top - first : bottom - first] = band
    return cv2.cvtColor(image, cv2.COLOR_RGBA2RGB) if len(image) else image[..., :3]


def bands(camera: Camera, road: Road) -> tuple[tuple[int, int, int], ...]:
    """First row, last row plus one, and how many times higher the band is drawn."""
    first, (width, height) = horizon(camera).first, camera.image_size
    if first >= height:
        return ()
    A_texture_image = np.linalg.inv(road_warp(camera, road))
    rows = np.arange(first, height + 1, dtype=float)
    pixels = np.stack((np.full_like(rows, 0.5 * width), rows, np.ones_like(rows)))
    seen = A_texture_image @ pixels
    points = (seen[:2] / seen[2]).T
    texels = np.linalg.norm(np.diff(points, axis=0), axis=1)
    steps = np.ceil(np.log2(np.maximum(texels, 1e-9) / 2.0)).clip(0, np.log2(MOST))
    finer = (2 ** np.maximum.accumulate(steps[::-1])[::-1]).astype(int)
    edges = [0, *(np.flatnonzero(np.diff(finer)) + 1).tolist(), len(finer)]
    return tuple((first + top, first + bottom, int(finer[top])) for top, bottom in pairwise(edges))


def road_semantics(camera: Camera, road: Road) -> UInt8[Array, "h w"]:
    """Sky, road (inside the texture) or ground at each pixel, without any object."""
    seen, (width, height) = horizon(camera), camera.image_size
    kinds = np.full((height, width), Semantic.SKY, np.uint8)
    columns, rows = road.texture.size
    one_texel = np.full((1, 1), Semantic.ROAD, np.uint8)  # as large as the whole texture
    A_texture_texel = np.diag((float(columns), float(rows), 1.0))
    A_texture_texel[:2, 2] = 0.5 * columns - 0.5, 0.5 * rows - 0.5
    A_rows_image = np.eye(3)
    A_rows_image[1, 2] = -seen.first
    if seen.first < height:
        below = cv2.warpPerspective(
            one_texel,
            A_rows_image @ road_warp(camera, road) @ A_texture_texel,
            (width, height - seen.first),
            flags=cv2.INTER_NEAREST,
            borderMode=cv2.BORDER_CONSTANT,
            borderValue=(float(Semantic.GROUND),),
        )
        cv2.copyTo(below, seen.below[seen.first :], kinds[seen.first :])
    return kinds
