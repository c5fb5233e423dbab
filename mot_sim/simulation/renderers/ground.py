"""The backdrop of a view: the sky, and the road as a perspective warp with exact depth."""

from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise

import cv2
import numpy as np
from jaxtyping import Float, Float32, Int32, UInt8
from numpy import ndarray as Array

from mot_sim.simulation.renderers.surroundings import Colour, Level, Panorama, Road, Sky
from mot_sim.simulation.renderers.view import Semantic, View
from tracker.kernels import Kernel
from tracker.types import Camera

# Rows near the horizon see many texels at once: they are drawn up to so many times higher, and
# then averaged.
MAX_SUPERSAMPLING = 4
MAX_TEXELS_PER_ROW = 3.0  # that a drawn row may skip
MIN_TEXELS_PER_PIXEL = 0.33  # where a finer picture is to be had
PIECE_ROWS = 16  # that are drawn at once, from the first column that is needed to the last
SKY_TOP_SLOPE = 0.35  # slope above the horizon from which on the sky has its top colour
CHOOSE_PICTURES = Kernel("mot_sim.simulation.kernels.backdrop", "choose_pictures")


@dataclass(frozen=True, eq=False)
class Horizon:
    """Where a camera sees the road plane, and how far it is; fixed for a camera."""

    depth: Float32[Array, "h w"]
    """Metres along the optical axis to the road plane; inf above the horizon."""
    below: UInt8[Array, "h w"]
    """255 where the road plane is, else 0."""
    first: int
    """First row with road; the image's height where there is none."""
    full: int
    """First row from which on all pixels are road."""
    deepest: Float[Array, " r"]
    """The largest depth in each row from `first` on, metres."""
    slope: Float32[Array, "h w"]
    """How steeply each pixel's ray rises, metres up per metre of depth; 0 at the horizon."""


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
    deepest, depth = depth[first:].max(axis=1), depth.astype(np.float32)
    holes = np.flatnonzero(~below.all(axis=1))
    full = int(holes[-1]) + 1 if len(holes) else 0
    return Horizon(depth, mask, first, full, deepest, (-falling).astype(np.float32))


def plane_depth(view: View) -> Float32[Array, "h w"]:
    """How far the road plane is at each pixel, metres; inf: it is not there, or there is none."""
    if view.road is None:
        return _nothing(view.camera.image_size)
    return horizon(view.camera).depth


@lru_cache(maxsize=8)
def _nothing(image_size: tuple[int, int]) -> Float32[Array, "h w"]:
    return np.full(image_size[::-1], np.inf, np.float32)


def sky_image(
    camera: Camera, sky: Sky, spans: Int32[Array, "h 2"] | None = None
) -> UInt8[Array, "h w 3"]:
    """The sky alone, all over the image; the caller's own.

    spans: the first column that is needed of each row, and the last one plus one; what lies beside
    them may be anything.
    """
    faded = _faded(camera, sky.top, sky.low)
    if sky.panorama is None:
        return faded.copy()
    image = np.empty_like(faded)
    count = _lay_panorama(camera, sky.panorama, sky.heading, spans, image)
    image[count:] = faded[count:]
    return image


@lru_cache(maxsize=8)
def _faded(camera: Camera, top: Colour, low: Colour) -> UInt8[Array, "h w 3"]:
    share = (horizon(camera).slope / SKY_TOP_SLOPE).clip(0.0, 1.0)[..., None]
    first, last = np.array(low, np.float32), np.array(top, np.float32)
    return np.round(first + share * (last - first)).astype(np.uint8)


def _lay_panorama(
    camera: Camera,
    panorama: Panorama,
    heading: float,
    spans: Int32[Array, "h 2"] | None,
    image: UInt8[Array, "h w 3"],
) -> int:
    """Write the rows of the image that see anything above the horizon; gives their number."""
    height, width = panorama.rgba.shape[:2]
    columns, rows, leftmost = _panorama_map(camera, (width, height), panorama.top, panorama.bottom)
    start = (leftmost + heading * width / (2.0 * np.pi)) % width
    whole = int(start)
    shift = start - whole - leftmost
    piece = panorama.twice[:, whole : whole + width]
    for top, bottom, left, right in pieces(0, len(rows), image.shape[1], spans):
        part = slice(top, bottom), slice(left, right)
        seen = cv2.remap(
            piece,
            columns[part] + np.float32(shift),  # (cv2.add takes 4 x 1 pixels for a colour)
            rows[part],
            cv2.INTER_LINEAR,
            borderMode=cv2.BORDER_REPLICATE,
        )
        image[part] = cv2.cvtColor(seen, cv2.COLOR_RGBA2RGB)
    return len(rows)


def pieces(
    first: int, end: int, width: int, spans: Int32[Array, "h 2"] | None
) -> list[tuple[int, int, int, int]]:
    """The part of rows from `first` to before `end` that is needed, in pieces.

    Of each: first row, last plus one, first column, last plus one.
    """
    if spans is None:
        return [(first, end, 0, width)] if first < end else []
    found = []
    for top in range(first, end, PIECE_ROWS):
        bottom = min(top + PIECE_ROWS, end)
        left, right = int(spans[top:bottom, 0].min()), int(spans[top:bottom, 1].max())
        if left < right:
            found.append((top, bottom, left, right))
    return found


@lru_cache(maxsize=8)
def _panorama_map(
    camera: Camera, size: tuple[int, int], top: float, bottom: float
) -> tuple[Float32[Array, "r w"], Float32[Array, "r w"], float]:
    """Columns (from straight ahead) and rows of a panorama at the image's pixels.

    And the leftmost of these columns.
    """
    width, _height = camera.image_size
    count = int((horizon(camera).below == 0).any(axis=1).sum())
    v, u = np.mgrid[:count, :width].astype(float)
    rays = camera.rays_road(np.stack((u, v), axis=-1).reshape(-1, 2)).reshape(count, width, 3)
    azimuth = np.arctan2(rays[..., 0], rays[..., 2])
    elevation = np.arctan2(-rays[..., 1], np.hypot(rays[..., 0], rays[..., 2]))
    columns = azimuth * (size[0] / (2.0 * np.pi))
    rows = (top - elevation) / (top - bottom) * (size[1] - 1.0)
    columns = columns.astype(np.float32)
    return columns, rows.astype(np.float32), float(columns.min(initial=np.inf))


def road_warp(camera: Camera, road: Road | Level) -> Float[Array, "3 3"]:
    """From the texture's homogeneous pixels to the image's."""
    A_image_road = camera.K @ camera.T_cam_road[:3][:, [0, 2, 3]]
    return A_image_road @ np.linalg.inv(road.A_texture_road)


def road_image(camera: Camera, road: Road) -> UInt8[Array, "r w 3"]:
    """The road from the horizon's first row down; what is above the horizon means nothing."""
    rgba = road_rgba(camera, road)
    return cv2.cvtColor(rgba, cv2.COLOR_RGBA2RGB) if len(rgba) else rgba[..., :3]


def road_rgba(
    camera: Camera, road: Road, spans: Int32[Array, "h 2"] | None = None
) -> UInt8[Array, "r w 4"]:
    """The road from the horizon's first row down; alpha is 255 on the road, 0 beside it.

    spans: see `sky_image`. Of a plain road it is made once for a camera: nobody writes to it.
    """
    return _plain_rgba(camera) if road.is_plain else _warped(camera, road, spans)


@lru_cache(maxsize=8)
def _plain_rgba(camera: Camera) -> UInt8[Array, "r w 4"]:
    return _warped(camera, Road())


def _warped(
    camera: Camera, road: Road, spans: Int32[Array, "h 2"] | None = None
) -> UInt8[Array, "r w 4"]:
    first, (width, height) = horizon(camera).first, camera.image_size
    warps = [road_warp(camera, level) for level in road.levels]
    image = np.empty((height - first, width, 4), np.uint8)
    for begun, end, finer, number in cuts(camera, road):
        for top, bottom, left, right in pieces(begun, end, width, spans):
            A_band_image = np.array([
                [1.0, 0.0, -float(left)],
                [0.0, finer, 0.5 * (finer - 1.0) - finer * top],
                [0.0, 0.0, 1.0],
            ])  # fmt: skip
            target = image[top - first : bottom - first, left:right]
            band = cv2.warpPerspective(
                road.levels[number].texture.rgba,
                A_band_image @ warps[number],
                (right - left, (bottom - top) * finer),
                target if finer == 1 else None,
                cv2.INTER_LINEAR,
                cv2.BORDER_CONSTANT,
                (*road.around, 0),
            )
            while len(band) > bottom - top:  # (OpenCV's own INTER_AREA is several times slower)
                into = target if len(band) == 2 * (bottom - top) else None
                band = cv2.addWeighted(band[::2], 0.5, band[1::2], 0.5, 0.0, into)
    return image


def bands(camera: Camera, road: Road) -> tuple[tuple[int, int, int], ...]:
    """First row, last row plus one, and how many times higher the band is drawn."""
    return tuple(cut[:3] for cut in cuts(camera, road))


def cuts(camera: Camera, road: Road) -> tuple[tuple[int, int, int, int], ...]:
    """The bands, and which of the road's levels each one shows."""
    first, (width, height) = horizon(camera).first, camera.image_size
    if first >= height:
        return ()
    A_image_road = camera.K @ camera.T_cam_road[:3][:, [0, 2, 3]]
    rows = np.arange(first, height)
    chosen, finer = np.empty(len(rows), np.int64), np.empty(len(rows), np.int64)
    CHOOSE_PICTURES(
        np.stack([level.A_texture_road for level in road.levels]) @ np.linalg.inv(A_image_road),
        np.array([level.texture.size for level in road.levels], float),
        np.array([level.reach for level in road.levels], float),
        horizon(camera).deepest,
        first,
        width,
        MAX_TEXELS_PER_ROW,
        MAX_SUPERSAMPLING,
        MIN_TEXELS_PER_PIXEL,
        chosen,
        finer,
    )
    changes = (np.diff(finer) != 0) | (np.diff(chosen) != 0)
    edges = [0, *(np.flatnonzero(changes) + 1).tolist(), len(rows)]
    return tuple(
        (first + top, first + bottom, int(finer[top]), int(chosen[top]))
        for top, bottom in pairwise(edges)
    )


def road_semantics(camera: Camera, road: Road) -> UInt8[Array, "h w"]:
    """Sky, road or ground at each pixel, without any object; the caller's own.

    Road inside the texture, exactly; ground around it. Only of a road without finer levels.
    """
    return _plain_kinds(camera).copy() if road.is_plain else _semantics(camera, road)


@lru_cache(maxsize=8)
def _plain_kinds(camera: Camera) -> UInt8[Array, "h w"]:
    return _semantics(camera, Road())


def _semantics(camera: Camera, road: Road) -> UInt8[Array, "h w"]:
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
