"""One post-effect on a rendered frame: light and weather, then the camera; for every renderer.

It takes image, depth and semantic ids. Normals are not needed: what depends on them, the sun's
light on faces, is done when a face is drawn; fog, rain, lamps and lens depend on depth alone.
"""

from dataclasses import dataclass, replace
from functools import lru_cache

import cv2
import numpy as np
from jaxtyping import Float32, UInt8, UInt16
from numpy import ndarray as Array

from mot_sim.simulation.camera_looks import PLAIN, CameraLook, compressed, develop
from mot_sim.simulation.random_numbers import named_stream, uniform
from mot_sim.simulation.renderers import Rendered, Semantic, View
from mot_sim.simulation.renderers.ground import horizon
from mot_sim.simulation.scenery.lamps import lit_at_night
from mot_sim.simulation.scenery.rain import rained_on
from mot_sim.simulation.scenery.weather import Weather
from mot_sim.simulation.scenery.weather_axes import KOSCHMIEDER
from tracker.kernels import Kernel
from tracker.types import Camera

DIM_AND_ADD = Kernel("mot_sim.simulation.kernels.air", "dim_and_add")

Image = UInt8[Array, "h w 3"]

# Tone: what a covered sky, and warm or cold light, make of colours.
OVERCAST_COLOUR = (196, 201, 206)  # of a sky that clouds cover
OVERCAST_SKY_SHARE = 0.8  # of that colour in the sky
OVERCAST_PALENESS = 0.3  # of grey in all colours
OVERCAST_LIGHT_LOSS = 0.1
GREY_WEIGHTS = (0.3, 0.59, 0.11)  # of R, G, B in the luminance
WARM_RED_GAIN = 0.16
WARM_BLUE_LOSS = 0.3
# Air: extinction by Koschmieder's law.
HAZE_LAYER_METRES = 70.0  # how high haze reaches above the road
MIN_HAZE_SLOPE = 1e-4
BELOW_HORIZON_METRES = 1e9  # of air, for rays that meet the road: their own depth counts
# Glare: a wide veil and a disc around the sun, as parts of the image's width.
MIN_SUN_COSINE = 0.15  # between the sun and the optical axis, for a halo to be drawn
SUN_WINDOW_PIXELS = 24  # to each side of the sun, where things may hide it
OUTSIDE_SKY_SHARE = 0.7  # of open sky around a sun outside the image
HIDDEN_GLARE_SHARE = 0.35  # that is left where the sun is hidden
GLARE_DOWNSAMPLING = 8
GLARE_LEVELS = 190.0  # grey levels of the whole halo
GLARE_COLOUR = (1.0, 0.86, 0.62)
VEIL_SHARE = 0.75
VEIL_FALLOFF = 9.0  # an image width
DISC_SHARE = 0.9
DISC_FALLOFF = 18.0
# Motion blur.
BLUR_STEPS = 4  # pictures whose mean it is
MIN_BLUR_DEPTH_METRES = 2.0
LIGHT_AT_NIGHT = 0.1  # of the day's, for which the sensor's gain makes up
# Sensor noise.
NOISE_SHIFT_PIXELS = 256  # by how much the seed's noise is larger than the image
SHARED_NOISE_SHARE = 0.85  # std of what the three colours have in common
OWN_NOISE_SHARE = 0.53  # std of each colour's own


@dataclass(frozen=True, eq=False)
class Shot:
    """A drawn frame and the weather in which the camera takes it; see `post_process`."""

    weather: Weather
    """What the light, the air and the camera do to the image."""
    view: View
    """What was drawn: camera, sun and objects."""
    rendered: Rendered
    """The drawn frame in clear weather."""
    seed: int
    """Random seed of the run, for noise and rain."""
    frame: int
    """Number of the frame, from 0; each has other noise and drops."""
    motion: tuple[float, float]
    """Metres ahead and radians to the right that the camera moves in a frame's time."""

    @property
    def camera(self) -> Camera:
        """Of the view."""
        return self.view.camera

    @property
    def lens_follows_air(self) -> bool:
        """Whether nothing happens between the air and the lens, which then are one step."""
        weather = self.weather
        return bool(np.isfinite(weather.visibility)) and not (weather.glare or weather.motion_blur)


def post_process(
    weather: Weather,
    view: View,
    rendered: Rendered,
    seed: int,
    frame: int,
    motion: tuple[float, float] = (0.0, 0.0),
    look: CameraLook = PLAIN,
) -> Image:
    """The frame's image as the weather lets the camera see it; the caller's own.

    motion: metres ahead and radians to the right that the camera moves in a frame's time, for
    the motion blur. look: of the camera; unless it is neutral, it replaces the weather's noise,
    vignetting and JPEG. The same seed and frame give the same bytes.
    """
    image = rendered.image
    if not look.is_neutral:
        weather = replace(weather, noise=0.0, vignetting=0.0, jpeg=100.0)
    if not weather.is_neutral:
        shot = Shot(weather, view, rendered, seed, frame, motion)
        for effect in (
            with_tone,
            with_rain,
            with_night,
            with_air,
            with_glare,
            with_motion_blur,
            with_vignetting,
            with_noise,
            with_jpeg,
        ):
            image = effect(image, shot)
    if look.is_neutral:
        return image.copy() if image is rendered.image else image
    light = 1.0 - (1.0 - LIGHT_AT_NIGHT) * weather.night
    return develop(image, view.camera, look, seed, frame, light)


def with_tone(image: Image, shot: Shot) -> Image:
    """Colours under another light: paler under clouds, redder or bluer, brighter or darker."""
    weather, depth = shot.weather, shot.rendered.depth
    if not (weather.overcast or weather.warmth or weather.exposure != 1.0):
        return image
    if weather.overcast:
        image = image.copy()
        rows_of_sky = np.flatnonzero(np.isinf(depth).any(axis=1))
        upper = image[: int(rows_of_sky.max(initial=-1)) + 1]
        sky = np.isinf(depth[: len(upper)]).view(np.uint8)
        if sky.any():
            share = OVERCAST_SKY_SHARE * weather.overcast
            clouds = cv2.merge([np.full(sky.shape, one, np.uint8) for one in OVERCAST_COLOUR])
            mixed = cv2.addWeighted(upper, 1.0 - share, clouds, share, 0.0)
            cv2.copyTo(mixed, sky, upper)
    pale = OVERCAST_PALENESS * weather.overcast
    A = (1.0 - pale) * np.eye(3) + pale * np.array(GREY_WEIGHTS)
    red, blue = 1.0 + WARM_RED_GAIN * weather.warmth, 1.0 - WARM_BLUE_LOSS * weather.warmth
    gain = weather.exposure * (1.0 - OVERCAST_LIGHT_LOSS * weather.overcast)
    return cv2.transform(image, gain * np.array([red, 1.0, blue])[:, None] * A)


def with_rain(image: Image, shot: Shot) -> Image:
    """A wet road and falling drops."""
    rain, semantics = shot.weather.rain, shot.rendered.semantics
    if not rain:
        return image
    return rained_on(image.copy(), shot.camera, semantics, rain, shot.seed, shot.frame)


def with_night(image: Image, shot: Shot) -> Image:
    """Little light from above, headlights, lamps."""
    weather = shot.weather
    if not weather.night:
        return image
    return lit_at_night(image, shot.camera, shot.rendered, weather.night, weather.headlights)


def with_air(image: Image, shot: Shot) -> Image:
    """What fog and haze leave of the light, and their own light.

    Where the lens follows, it dims both before they are rounded and added up.
    """
    weather = shot.weather
    if not np.isfinite(weather.visibility):
        return image
    loss = weather.vignetting if shot.lens_follows_air else 0.0
    height, width = image.shape[:2]
    flat, seen = np.ascontiguousarray(image).reshape(height, 3 * width), np.empty_like(image)
    extinction = KOSCHMIEDER / weather.visibility
    air, room = np.array(weather.air, float), np.empty(width, np.float32)
    DIM_AND_ADD(
        flat, shot.rendered.depth, _haze_depth(shot.camera), _vignette(shot.camera, loss),
        extinction, air, room, np.empty((2, 3 * width), np.int32),
        seen.reshape(height, 3 * width),
    )  # fmt: skip
    return seen


def with_glare(image: Image, shot: Shot) -> Image:
    """The halo of the sun where it stands before the camera, less where something hides it."""
    camera, strength = shot.camera, shot.weather.glare
    width, height = camera.image_size
    towards = camera.T_cam_road[:3, :3] @ shot.view.sun.direction
    if not strength or towards[2] < MIN_SUN_COSINE:
        return image
    u, v = (camera.K @ towards)[:2] / towards[2]
    reach = SUN_WINDOW_PIXELS
    rows, columns = (slice(max(int(x) - reach, 0), max(int(x) + reach, 1)) for x in (v, u))
    around = shot.rendered.semantics[rows, columns]
    open_sky = float((around == Semantic.SKY).mean()) if around.size else OUTSIDE_SKY_SHARE
    strength *= HIDDEN_GLARE_SHARE + (1.0 - HIDDEN_GLARE_SHARE) * open_sky
    step = GLARE_DOWNSAMPLING
    y, x = np.ogrid[: height // step + 1, : width // step + 1]
    apart = np.hypot((float(step) * x - u) / width, (float(step) * y - v) / width)
    apart = apart.astype(np.float32)
    veil = VEIL_SHARE * np.exp(-VEIL_FALLOFF * apart)
    disc = DISC_SHARE * open_sky * np.exp(-((DISC_FALLOFF * apart) ** 2))
    halo = GLARE_LEVELS * strength * (veil + disc)
    small = np.clip(halo[..., None] * GLARE_COLOUR, 0.0, 255.0).astype(np.uint8)
    return cv2.add(image, cv2.resize(small, (width, height), interpolation=cv2.INTER_LINEAR))


def with_motion_blur(image: Image, shot: Shot) -> Image:
    """The mean of what the sensor sees while the camera drives on and turns."""
    ahead, turn = (shot.weather.motion_blur * moved for moved in shot.motion)
    if ahead == 0.0 and turn == 0.0:
        return image
    K, (u, v) = shot.camera.K, _pixels(shot.camera)
    # Towards the image's middle a point was earlier, by the share of its depth driven since.
    share = np.float32(ahead) / np.maximum(shot.rendered.depth, MIN_BLUR_DEPTH_METRES)
    flow_u = (u - np.float32(K[0, 2])) * share - np.float32(K[0, 0] * turn)
    flow_v = (v - np.float32(K[1, 2])) * share
    total: UInt16[Array, "h w 3"] = image.astype(np.uint16)
    for step in range(1, BLUR_STEPS):
        back = np.float32(step / BLUR_STEPS)
        places = u - back * flow_u, v - back * flow_v
        seen = cv2.remap(image, *places, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
        total += np.asarray(seen, np.uint8)
    return cv2.convertScaleAbs(total, alpha=1.0 / BLUR_STEPS)


def with_vignetting(image: Image, shot: Shot) -> Image:
    """Darker corners, unless the air has taken the lens in already."""
    loss = shot.weather.vignetting
    if not loss or shot.lens_follows_air:
        return image
    return _dimmed(image, _vignette(shot.camera, loss))


def with_noise(image: Image, shot: Shot) -> Image:
    """A piece of the seed's noise; every frame has another."""
    level, seed = shot.weather.noise, shot.seed
    if not level:
        return image
    width, height = shot.camera.image_size
    banks = _noise_banks(seed, level, (height + NOISE_SHIFT_PIXELS, width + NOISE_SHIFT_PIXELS))
    where = uniform(seed, "sensor noise", np.zeros(1, np.int64), np.array([shot.frame]), 2)[0]
    top, left = (float(NOISE_SHIFT_PIXELS) * where).astype(int)
    more, less = (bank[top : top + height, left : left + width] for bank in banks)
    return cv2.subtract(cv2.add(image, more), less)


def with_jpeg(image: Image, shot: Shot) -> Image:
    """The image compressed and decompressed."""
    return compressed(image, shot.weather.jpeg)


def _dimmed(image: Image, share: Float32[Array, "h w"]) -> Image:
    """The share of each pixel's light, 0 to 1."""
    left = cv2.convertScaleAbs(share, alpha=255.0)
    return cv2.multiply(image, cv2.merge((left, left, left)), scale=1.0 / 255.0)


@lru_cache(maxsize=8)
def _haze_depth(camera: Camera) -> Float32[Array, "h w"]:
    """How much air rays above the horizon pass before they leave its lower layer, metres."""
    slope = np.maximum(horizon(camera).slope, MIN_HAZE_SLOPE)
    up = HAZE_LAYER_METRES / slope
    return np.where(horizon(camera).below > 0, BELOW_HORIZON_METRES, up).astype(np.float32)


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


@lru_cache(maxsize=4)
def _noise_banks(seed: int, level: float, size: tuple[int, int]) -> tuple[Image, Image]:
    """What a seed's noise adds to a larger image, and what it takes from it."""
    rng = named_stream(seed, "sensor noise")
    shared = rng.standard_normal((*size, 1), dtype=np.float32)
    own = rng.standard_normal((*size, 3), dtype=np.float32)
    mixed: Float32[Array, "h w 3"] = np.round(
        np.float32(level) * (SHARED_NOISE_SHARE * shared + OWN_NOISE_SHARE * own)
    )
    more, less = (np.clip(sign * mixed, 0, 255).astype(np.uint8) for sign in (1.0, -1.0))
    return more, less
