"""One post-effect on a rendered frame: light and weather, then the camera; for every renderer.

It takes image, depth and semantic ids. Normals are not needed: what depends on them, the sun's
light on faces, is done when a face is drawn; fog, rain, lamps and lens depend on depth alone.
"""

from functools import lru_cache

import cv2
import numpy as np
from jaxtyping import Float32, UInt8, UInt16
from numpy import ndarray as Array

from mot_sim.simulation.random_numbers import named_stream, uniform
from mot_sim.simulation.renderers import Rendered, Semantic, View
from mot_sim.simulation.renderers.ground import horizon
from mot_sim.simulation.scenery.lamps import lit_at_night
from mot_sim.simulation.scenery.rain import rained_on
from mot_sim.simulation.scenery.weather import Weather
from tracker.types import Camera

Image = UInt8[Array, "h w 3"]
CONTRAST = 3.0  # of -ln(0.05), at the visibility
LAYER = 70.0  # metres: how high haze reaches above the road
GREY_SKY = (196, 201, 206)
STEPS = 4  # pictures whose mean a motion blur is


def post_process(
    weather: Weather,
    view: View,
    rendered: Rendered,
    seed: int,
    frame: int,
    motion: tuple[float, float] = (0.0, 0.0),
) -> Image:
    """The frame's image as the weather lets the camera see it; the caller's own.

    motion: metres ahead and radians to the right that the camera moves in a frame's time, for
    the motion blur. The same seed and frame give the same bytes.
    """
    image = rendered.image.copy()
    if weather.is_neutral:
        return image
    camera = view.camera
    if weather.overcast or weather.warmth or weather.exposure != 1.0:
        image = _toned(image, weather, rendered)
    if weather.rain:
        image = rained_on(image, camera, rendered.semantics, weather.rain, seed, frame)
    if weather.night:
        image = lit_at_night(image, camera, rendered, weather.night, weather.headlights)
    lens = _vignette(camera, weather.vignetting)
    is_last = not (weather.glare or weather.motion_blur)  # then air and lens are one sum
    if np.isfinite(weather.visibility):
        bright = lens if weather.vignetting and is_last else None
        image = _through_air(image, camera, rendered.depth, weather, bright)
    if weather.glare:
        image = cv2.add(image, _glare(view, rendered, weather.glare))
    if weather.motion_blur:
        image = _moved(image, camera, rendered.depth, weather.motion_blur, motion)
    if weather.vignetting and not (is_last and np.isfinite(weather.visibility)):
        dim = cv2.convertScaleAbs(lens, alpha=255.0)
        image = cv2.multiply(image, cv2.merge((dim, dim, dim)), scale=1.0 / 255.0)
    if weather.noise:
        more, less = _noise(camera, weather.noise, seed, frame)
        image = cv2.subtract(cv2.add(image, more), less)
    if weather.jpeg < 100.0:
        setting = [cv2.IMWRITE_JPEG_QUALITY, int(weather.jpeg)]
        _, packed = cv2.imencode(".jpg", cv2.cvtColor(image, cv2.COLOR_RGB2BGR), setting)
        image = cv2.cvtColor(np.asarray(cv2.imdecode(packed, cv2.IMREAD_COLOR)), cv2.COLOR_BGR2RGB)
    return image


def _toned(image: Image, weather: Weather, rendered: Rendered) -> Image:
    """Colours under another light: paler under clouds, redder or bluer, brighter or darker."""
    if weather.overcast:
        rows = slice(
            0, int(np.flatnonzero(np.isinf(rendered.depth).any(axis=1)).max(initial=-1)) + 1
        )
        sky = np.isinf(rendered.depth[rows]).view(np.uint8)
        mixed = (
            cv2.addWeighted(
                image[rows],
                1.0 - 0.8 * weather.overcast,
                cv2.merge([np.full(sky.shape, one, np.uint8) for one in GREY_SKY]),
                0.8 * weather.overcast,
                0.0,
            )
            if sky.any()
            else image[rows]
        )
        cv2.copyTo(mixed, sky, image[rows])
    pale = 0.3 * weather.overcast
    A = (1.0 - pale) * np.eye(3) + pale * np.array([0.3, 0.59, 0.11])
    warm = np.array([1.0 + 0.16 * weather.warmth, 1.0, 1.0 - 0.3 * weather.warmth])
    gain = weather.exposure * (1.0 - 0.1 * weather.overcast)
    return cv2.transform(image, gain * warm[:, None] * A)


def _through_air(
    image: Image,
    camera: Camera,
    depth: Float32[Array, "h w"],
    weather: Weather,
    lens: Float32[Array, "h w"] | None,
) -> Image:
    """What fog and haze leave of the light, and their own light; lens: what it leaves of both."""
    left = np.minimum(depth, _sky_depth(camera))
    left *= np.float32(-CONTRAST / weather.visibility)
    np.exp(left, out=left)
    if lens is None:
        own = np.float32(1.0) - left
    else:
        left *= lens
        own = lens - left
    share = cv2.convertScaleAbs(left, alpha=255.0)
    seen = cv2.multiply(image, cv2.merge((share, share, share)), scale=1.0 / 255.0)
    return cv2.add(seen, cv2.merge([cv2.convertScaleAbs(own, alpha=one) for one in weather.air]))


@lru_cache(maxsize=8)
def _sky_depth(camera: Camera) -> Float32[Array, "h w"]:
    """How much air rays above the horizon pass before they leave its lower layer, metres."""
    slope = np.maximum(horizon(camera).slope, 1e-4)
    return np.where(horizon(camera).below > 0, 1e9, LAYER / slope).astype(np.float32)


def _glare(view: View, rendered: Rendered, strength: float) -> Image:
    """The halo of the sun where it stands before the camera, less where something hides it."""
    width, height = view.camera.image_size
    towards = view.camera.T_cam_road[:3, :3] @ view.sun.direction
    if towards[2] < 0.15:
        return np.zeros((height, width, 3), np.uint8)
    u, v = (view.camera.K @ towards)[:2] / towards[2]
    rows, columns = (slice(max(int(one) - 24, 0), max(int(one) + 24, 1)) for one in (v, u))
    around = rendered.semantics[rows, columns]
    open_sky = float((around == Semantic.SKY).mean()) if around.size else 0.7
    strength *= 0.35 + 0.65 * open_sky
    y, x = np.ogrid[: height // 8 + 1, : width // 8 + 1]
    apart = np.hypot((8.0 * x - u) / width, (8.0 * y - v) / width).astype(np.float32)
    halo = (
        190.0
        * strength
        * (0.75 * np.exp(-9.0 * apart) + 0.9 * open_sky * np.exp(-((18.0 * apart) ** 2)))
    )
    small = np.clip(halo[..., None] * (1.0, 0.86, 0.62), 0.0, 255.0).astype(np.uint8)
    return cv2.resize(small, (width, height), interpolation=cv2.INTER_LINEAR)


def _moved(
    image: Image,
    camera: Camera,
    depth: Float32[Array, "h w"],
    shutter: float,
    motion: tuple[float, float],
) -> Image:
    """The mean of what the sensor sees while the camera drives on and turns."""
    ahead, turn = (shutter * one for one in motion)
    if ahead == 0.0 and turn == 0.0:
        return image
    u, v = _pixels(camera)
    # Towards the image's middle a point was earlier, by the share of its depth driven since.
    share = np.float32(ahead) / np.maximum(depth, 2.0)
    flow_u = (u - np.float32(camera.K[0, 2])) * share - np.float32(camera.K[0, 0] * turn)
    flow_v = (v - np.float32(camera.K[1, 2])) * share
    total: UInt16[Array, "h w 3"] = image.astype(np.uint16)
    for step in range(1, STEPS):
        back = np.float32(step / STEPS)
        seen = cv2.remap(
            image,
            u - back * flow_u,
            v - back * flow_v,
            cv2.INTER_LINEAR,
            borderMode=cv2.BORDER_REPLICATE,
        )
        total += np.asarray(seen, np.uint8)
    return cv2.convertScaleAbs(total, alpha=1.0 / STEPS)


@lru_cache(maxsize=8)
def _pixels(camera: Camera) -> tuple[Float32[Array, "h w"], Float32[Array, "h w"]]:
    width, height = camera.image_size
    v, u = np.mgrid[:height, :width].astype(np.float32)
    return u, v


@lru_cache(maxsize=8)
def _vignette(camera: Camera, loss: float) -> Float32[Array, "h w"]:
    """How bright the lens leaves each pixel, 0 to 1."""
    width, height = camera.image_size
    u, v = _pixels(camera)
    apart = ((u - 0.5 * width) ** 2 + (v - 0.5 * height) ** 2) / (0.25 * (width**2 + height**2))
    return (1.0 - loss * apart).astype(np.float32)


def _noise(camera: Camera, level: float, seed: int, frame: int) -> tuple[Image, Image]:
    """A piece of the seed's noise, what it adds and what it takes; every frame has another."""
    width, height = camera.image_size
    banks = _banks(seed, level, (height + 256, width + 256))
    where = uniform(seed, "sensor noise", np.zeros(1, np.int64), np.array([frame]), 2)[0]
    top, left = (256.0 * where).astype(int)
    more, less = (bank[top : top + height, left : left + width] for bank in banks)
    return more, less


@lru_cache(maxsize=4)
def _banks(seed: int, level: float, size: tuple[int, int]) -> tuple[Image, Image]:
    rng = named_stream(seed, "sensor noise")
    shared = rng.standard_normal((*size, 1), dtype=np.float32)
    own = rng.standard_normal((*size, 3), dtype=np.float32)
    mixed: Float32[Array, "h w 3"] = np.round(np.float32(level) * (0.85 * shared + 0.53 * own))
    more, less = (np.clip(sign * mixed, 0, 255).astype(np.uint8) for sign in (1.0, -1.0))
    return more, less
