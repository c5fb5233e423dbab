"""Night: little light from above, headlights on what lies before us, and what glows itself."""

from functools import lru_cache

import cv2
import numpy as np
from jaxtyping import Float32, UInt8
from numpy import ndarray as Array

from mot_sim.simulation.renderers import NO_INSTANCE, Rendered, Semantic
from tracker.types import Camera

Image = UInt8[Array, "h w 3"]
NIGHT_LIGHT = np.array([0.085, 0.095, 0.125])  # what is left of the day's light at full night, RGB
NIGHT_SKY_LIGHT = 0.45  # of that, in the sky
BEAM_COLOUR = np.array([1.0, 0.95, 0.84])
BEAM_METRES = 24.0  # metres at which a headlight has half its strength
LAMP_COLOUR = (255, 206, 132)  # windows and street lamps
GLOW_DOWNSAMPLING = 4  # the glow is blurred in a smaller picture


def lit_at_night(
    image: Image, camera: Camera, rendered: Rendered, night: float, headlights: float
) -> Image:
    """The image at night; what is made of light keeps its own, and glows."""
    ambient = 1.0 - night * (1.0 - NIGHT_LIGHT)
    share = rendered.depth * np.float32(1.0 / BEAM_METRES)
    share *= share
    share += np.float32(1.0)
    beam = cv2.divide(_beam(camera), share, scale=255.0 * 0.85 * headlights * night)
    light = [
        cv2.convertScaleAbs(beam, alpha=float(b), beta=255.0 * float(a))
        for a, b in zip(ambient, BEAM_COLOUR, strict=True)
    ]
    dark = cv2.multiply(image, cv2.merge(light), scale=1.0 / 255.0)
    sky = (rendered.semantics == Semantic.SKY).view(np.uint8)
    cv2.copyTo(cv2.convertScaleAbs(dark, alpha=1.0 - night * (1.0 - NIGHT_SKY_LIGHT)), sky, dark)
    glowing = (rendered.semantics == Semantic.LIGHT).view(np.uint8)
    if not glowing.any():
        return dark
    no_car = (rendered.instances == NO_INSTANCE).view(np.uint8)
    own = np.zeros_like(image)
    cv2.copyTo(cv2.convertScaleAbs(image, alpha=2.0), glowing, own)
    cv2.copyTo(_warm(camera), cv2.bitwise_and(glowing, glowing, mask=no_car), own)
    own = cv2.convertScaleAbs(own, alpha=night)
    return cv2.add(cv2.max(dark, own), _glow(own, headlights))


@lru_cache(maxsize=8)
def _warm(camera: Camera) -> Image:
    width, height = camera.image_size
    return np.full((height, width, 3), LAMP_COLOUR, np.uint8)


def _glow(own: Image, strength: float) -> Image:
    """Light that lens and air scatter around lamps."""
    height, width = own.shape[:2]
    small = cv2.resize(
        own, (width // GLOW_DOWNSAMPLING, height // GLOW_DOWNSAMPLING), interpolation=cv2.INTER_AREA
    )
    near, wide = cv2.blur(cv2.blur(small, (3, 3)), (3, 3)), small
    for _ in range(2):
        wide = cv2.blur(wide, (11, 11))
    both = cv2.addWeighted(near, 0.7 * strength, wide, 2.2 * strength, 0.0)
    return cv2.resize(both, (width, height), interpolation=cv2.INTER_LINEAR)


@lru_cache(maxsize=8)
def _beam(camera: Camera) -> Float32[Array, "h w"]:
    """How strongly the headlights shine into each pixel's direction: low and wide, dipped."""
    width, height = camera.image_size
    v, u = np.mgrid[:height, :width].astype(float)
    rays = camera.rays_road(np.stack((u, v), axis=-1).reshape(-1, 2)).reshape(height, width, 3)
    aside = rays[..., 0] / rays[..., 2]
    up = -rays[..., 1] / rays[..., 2]
    wide = np.exp(-((aside / 0.42) ** 2))
    cut_off = 0.12 + 0.88 / (1.0 + np.exp((up - 0.005 - 0.05 * np.clip(aside, 0.0, 0.5)) / 0.012))
    return (wide * cut_off).astype(np.float32)
