"""Develops a drawn frame with a look: lens, exposure and white balance, tone, noise, JPEG.

The drawn grey level v is taken as light (v / 255)^contrast, times the exposure's gain. Every frame
is exposed from its own pixels, and its noise depends on seed and frame alone.
"""

from dataclasses import dataclass
from functools import lru_cache

import cv2
import numpy as np
from jaxtyping import Float, Float32, Int8, UInt8, UInt32
from numpy import ndarray as Array

from mot_sim.simulation.camera_looks.look import CameraLook, Tone
from mot_sim.simulation.random_numbers import named_stream, uniform
from tracker.kernels import Kernel
from tracker.types import Camera

DEVELOP = Kernel("mot_sim.simulation.kernels.developing", "develop_pixels")

Image = UInt8[Array, "h w 3"]
GREY_WEIGHTS = np.array([0.299, 0.587, 0.114])  # of R, G, B in the luma
CURVE_STEPS = 1024  # of drawn grey levels, 4 a level
METERING_STEP = 4  # every so many rows and columns of the frame are metered
GAIN_STEPS = 12  # a stop, of the automatic exposure's table
NOISE_SHIFT_PIXELS = 256  # by how much the seed's noise is larger than the image
NOISE_UNIT = 30.0  # of the stored noise, a standard deviation: 4.2 of them fit
LEVEL_STEPS, NOISE_STEPS = 256.0, 4096.0  # of a grey level and a factor, in the kernel's curves
MIN_BALANCE, MAX_BALANCE = 0.5, 2.0  # of the automatic white balance


def develop(
    image: Image, camera: Camera, look: CameraLook, seed: int, frame: int, light: float = 1.0
) -> Image:
    """What the camera makes of a drawn frame; the caller's own, and the same for seed and frame.

    light: share of the day's light that there is, above 0; the less, the more noise.
    """
    if look.is_neutral:
        return image.copy()
    if look.lens.blur > 0.0:
        image = cv2.GaussianBlur(image, (0, 0), look.lens.blur)
    if look.tone.saturation != 1.0:
        grey = np.tile(GREY_WEIGHTS, (3, 1))
        image = cv2.transform(image, grey + look.tone.saturation * (np.eye(3) - grey))
    curves = exposed(image, look).curves(look, light)
    noise = noise_of(seed, look.sensor.shared, look.sensor.grain, camera.image_size)
    lens = _lens_map(camera.image_size, look.lens.vignetting, look.tone.contrast)
    (height, width), seen = image.shape[:2], np.empty_like(image)
    drawn, noise = np.ascontiguousarray(image).reshape(height, -1), noise.reshape(len(noise), -1)
    room = np.empty((2, 3 * width), np.int32)
    place, result = noise_place(seed, frame), seen.reshape(height, 3 * width)
    DEVELOP(drawn, lens, curves.ravel(), noise, *place, room, result)
    return compressed(seen, look.file.jpeg)


@dataclass(frozen=True)
class FrameExposure:
    """How a frame is exposed."""

    gain: float
    """Gain on the light."""
    balance: tuple[float, float, float]
    """Gain on the drawn levels of R, G, B."""

    def curves(self, look: CameraLook, light: float = 1.0) -> UInt32[Array, "3 n"]:
        """The grey level and the noise for each drawn level and colour, as the kernel takes them.

        Upper half: grey level in steps of 1 / LEVEL_STEPS; lower half: factor on the stored noise
        in steps of 1 / NOISE_STEPS.
        """
        drawn = np.arange(CURVE_STEPS) * (256.0 / CURVE_STEPS)
        levels = tone_curve(np.outer(self.balance, drawn), self.gain, look)
        amplified = max(self.gain / look.exposure.gain, 1.0) / light
        variance = look.sensor.read_noise**2 + look.sensor.shot_noise**2 * levels
        factors = np.sqrt(amplified * variance) * (NOISE_STEPS / NOISE_UNIT)
        upper = np.round(LEVEL_STEPS * levels).astype(np.uint32)
        lower = np.minimum(np.round(factors), 65535.0).astype(np.uint32)
        return (upper << np.uint32(16)) | lower


def exposed(image: Image, look: CameraLook) -> FrameExposure:
    """The exposure and white balance that a look takes from the frame itself."""
    told = look.exposure
    metered = np.ascontiguousarray(image[::METERING_STEP, ::METERING_STEP])
    means = np.array(cv2.mean(metered)[:3])
    grey = float(means @ GREY_WEIGHTS)
    toward = (grey / np.maximum(means, 1.0)) ** told.white_balance if grey >= 1.0 else np.ones(3)
    balance = np.clip(toward, MIN_BALANCE, MAX_BALANCE) * (told.red, 1.0, told.blue)
    gain = told.gain
    if told.mean > 0.0:
        luma = cv2.cvtColor(metered, cv2.COLOR_RGB2GRAY)
        counts = cv2.calcHist([luma], [0], None, [256], [0.0, 256.0]).ravel().astype(float)
        gains, table = metering_table(look)
        gain = float(np.exp2(np.interp(told.mean, table @ counts / luma.size, gains)))
    return FrameExposure(gain * 2.0**told.stops, tuple(balance.tolist()))


@lru_cache(maxsize=16)
def metering_table(look: CameraLook) -> tuple[Float[Array, " g"], Float[Array, "g 256"]]:
    """Gains that the automatic exposure may take, in stops, and the grey levels that they give.

    A table row for each gain, a column for each drawn level.
    """
    told = look.exposure
    count = 1 + 2 * max(round(GAIN_STEPS * told.max_stops), 1)
    stops = np.log2(told.gain) + np.linspace(-told.max_stops, told.max_stops, count)
    levels = np.arange(256.0)
    return stops, np.stack([tone_curve(levels, float(2.0**one), look) for one in stops])


def tone_curve(drawn: Float[Array, "*n"], gain: float, look: CameraLook) -> Float[Array, "*n"]:
    """The grey levels, 0 to 255, of drawn ones under a gain on their light."""
    full = look.sensor.full_well
    light = np.minimum((drawn / 255.0) ** look.tone.contrast * gain, full)
    level = rolled_off(light, look.tone) / float(rolled_off(np.array(full), look.tone))
    return look.tone.black + (255.0 - look.tone.black) * level


def rolled_off(light: Float[Array, "*n"], tone: Tone) -> Float[Array, "*n"]:
    """Light after the shoulder of the tone curve, which goes towards 1."""
    if tone.shoulder == 0.0:
        return light
    return light / (1.0 + light**tone.shoulder) ** (1.0 / tone.shoulder)


def compressed(image: Image, quality: float) -> Image:
    """The image compressed as JPEG and decompressed; of quality 100 the image itself."""
    if quality >= 100.0:
        return image
    setting = [cv2.IMWRITE_JPEG_QUALITY, int(quality)]
    _, packed = cv2.imencode(".jpg", cv2.cvtColor(image, cv2.COLOR_RGB2BGR), setting)
    decoded = np.asarray(cv2.imdecode(packed, cv2.IMREAD_COLOR))
    return cv2.cvtColor(decoded, cv2.COLOR_BGR2RGB)


def noise_place(seed: int, frame: int) -> tuple[int, int]:
    """The upper left corner of a frame's piece of its seed's noise."""
    where = uniform(seed, "sensor noise", np.zeros(1, np.int64), np.array([frame]), 2)[0]
    top, left = (NOISE_SHIFT_PIXELS * where).astype(int).tolist()
    return top, left


@lru_cache(maxsize=4)
def noise_of(
    seed: int, shared: float, grain: float, image_size: tuple[int, int]
) -> Int8[Array, "h w 3"]:
    """A seed's noise, larger than the image; its standard deviation is NOISE_UNIT."""
    width, height = (side + NOISE_SHIFT_PIXELS for side in image_size)
    rng = named_stream(seed, "sensor noise")
    common = rng.standard_normal((height, width, 1), dtype=np.float32)
    own = rng.standard_normal((height, width, 3), dtype=np.float32)
    mixed: Float32[Array, "h w 3"] = np.float32(shared) * common
    mixed = mixed + np.float32(np.sqrt(1.0 - shared**2)) * own
    unit = NOISE_UNIT
    if grain > 0.0:
        mixed = np.asarray(cv2.GaussianBlur(mixed, (0, 0), grain), np.float32)
        unit /= float(mixed.std())
    return np.clip(np.round(np.float32(unit) * mixed), -127, 127).astype(np.int8)


@lru_cache(maxsize=8)
def _lens_map(size: tuple[int, int], loss: float, contrast: float) -> UInt32[Array, "h w"]:
    """What the lens leaves of the drawn levels in each pixel, 65536 all.

    loss: of the light at the corners, a power of which the drawn levels are.
    """
    width, height = size
    v, u = np.mgrid[:height, :width]
    apart = ((u - 0.5 * width) ** 2 + (v - 0.5 * height) ** 2) / (0.25 * (width**2 + height**2))
    return np.round(65536.0 * (1.0 - loss * apart) ** (1.0 / contrast)).astype(np.uint32)
