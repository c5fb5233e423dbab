"""The sky all around, and what stands at the horizon: clouds, hills, a line of trees."""

from functools import lru_cache

import cv2
import numpy as np
from jaxtyping import Float32
from numpy import ndarray as Array

from mot_sim.simulation.random_numbers import named_stream
from mot_sim.simulation.renderers.surroundings import Panorama

PANORAMA_COLUMNS = 6144
PANORAMA_ROWS = 512
TOP_RADIANS = 0.55
BOTTOM_RADIANS = -0.06
ZENITH_COLOUR = np.array([92, 138, 196.0])
HORIZON_COLOUR = np.array([212, 224, 234.0])
CLOUD_TOP_COLOUR = np.array([250, 250, 250.0])
CLOUD_BASE_COLOUR = np.array([198, 204, 212.0])
HILL_COLOUR = np.array([134, 150, 152.0])
WOOD_COLOUR = np.array([88, 104, 82.0])


@lru_cache(maxsize=4)
def panorama_of(seed: int, clouds: float) -> Panorama:
    """The surroundings of a seed; clouds: the share of the sky they cover, 0 to 1."""
    rng = named_stream(seed, "panorama")
    elevation = TOP_RADIANS - (TOP_RADIANS - BOTTOM_RADIANS) * np.arange(PANORAMA_ROWS) / (
        PANORAMA_ROWS - 1
    )
    up = np.clip(elevation / TOP_RADIANS, 0.0, 1.0)[:, None, None]
    sky = HORIZON_COLOUR + (ZENITH_COLOUR - HORIZON_COLOUR) * up**0.6
    sky = np.broadcast_to(sky, (PANORAMA_ROWS, PANORAMA_COLUMNS, 3)).copy()
    shape = _cloud_noise(rng, elevation)
    limit = np.quantile(shape, 1.0 - np.clip(clouds, 0.0, 1.0))
    cover = np.clip((shape - limit) * 1.6, 0.0, 1.0)[..., None] * (clouds > 0.0)
    cover = cover * np.clip(elevation / 0.06, 0.0, 1.0)[:, None, None]
    # Clouds are lit from above: dark where there is more cloud a little higher.
    thick = np.clip(shape - np.roll(shape, 9, axis=0) + 0.5, 0.0, 1.0)[..., None]
    sky += cover * (CLOUD_BASE_COLOUR + (CLOUD_TOP_COLOUR - CLOUD_BASE_COLOUR) * thick - sky)
    for base, colour, height, rough in (
        (0.022, HILL_COLOUR, 0.022, 1.5),
        (0.012, WOOD_COLOUR, 0.009, 0.7),
    ):
        outline = base + height * _outline(rng, rough)
        inside = np.clip(
            (outline[None] - elevation[:, None]) * PANORAMA_ROWS / (TOP_RADIANS - BOTTOM_RADIANS),
            0.0,
            1.0,
        )
        rough_grain = 1.0 + 0.06 * rng.standard_normal((PANORAMA_ROWS // 4, PANORAMA_COLUMNS // 4))
        grain = cv2.resize(
            rough_grain, (PANORAMA_COLUMNS, PANORAMA_ROWS), interpolation=cv2.INTER_LINEAR
        )
        sky += inside[..., None] * (colour * grain[..., None] - sky)
    rgba = np.full((PANORAMA_ROWS, PANORAMA_COLUMNS, 4), 255, np.uint8)
    rgba[..., :3] = np.clip(sky, 0.0, 255.0)
    return Panorama(rgba, TOP_RADIANS, BOTTOM_RADIANS)


def _cloud_noise(rng: np.random.Generator, elevation: Array) -> Float32[Array, "h w"]:
    """Noise in a layer overhead, seen from below: flatter and smaller towards the horizon."""
    size = 1024
    spectrum = np.fft.rfft2(rng.standard_normal((size, size)))
    v, u = np.fft.fftfreq(size)[:, None], np.fft.rfftfreq(size)[None]
    noise = np.fft.irfft2(spectrum * np.maximum(np.hypot(u, v), 1.0 / size) ** -1.7, (size, size))
    noise = (noise / noise.std()).astype(np.float32)
    azimuth = np.arange(PANORAMA_COLUMNS) * (2.0 * np.pi / PANORAMA_COLUMNS)
    away = 60.0 / np.tan(np.maximum(elevation, 0.02) + 0.06)[:, None]
    x, y = away * np.cos(azimuth), away * np.sin(azimuth)
    wrapped = ((x % size).astype(np.float32), (y % size).astype(np.float32))
    return cv2.remap(noise, *wrapped, cv2.INTER_LINEAR, borderMode=cv2.BORDER_WRAP)


def _outline(rng: np.random.Generator, slope: float) -> Float32[Array, " w"]:
    """A periodic line of unit variance."""
    spectrum = np.fft.rfft(rng.standard_normal(PANORAMA_COLUMNS))
    frequency = np.maximum(np.arange(len(spectrum)), 3.0)
    line = np.fft.irfft(spectrum * frequency**-slope, PANORAMA_COLUMNS)
    return (line / line.std()).astype(np.float32)
