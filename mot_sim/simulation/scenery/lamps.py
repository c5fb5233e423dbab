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
WINDOW_LEVELS = 90.0  # grey levels by day of a pane behind which all light is seen
LEAST_WINDOW_SHARE = 0.6  # of the light, behind a curtain
NEAR_GLOW = 0.4  # of a lamp's light, around it
WIDE_GLOW = 1.6  # of the light of cars and street lamps, far around
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
    glows = rendered.semantics == Semantic.LIGHT
    if rendered.unlit:
        glows[glows] = ~np.isin(rendered.instances[glows], rendered.unlit)
    glowing = glows.view(np.uint8)
    if not glows.any():
        return dark
    own = np.zeros_like(image)
    cv2.copyTo(cv2.convertScaleAbs(image, alpha=2.0), glowing, own)
    behind_panes = glows & (rendered.instances == NO_INSTANCE)
    if behind_panes.any():  # by how bright the pane is by day, a curtain or an open room
        bright = image[behind_panes].max(axis=1, keepdims=True)
        share = (bright * (1.0 / WINDOW_LEVELS)).clip(LEAST_WINDOW_SHARE, 1.0)
        own[behind_panes] = (share * LAMP_COLOUR).astype(np.uint8)
    own = cv2.convertScaleAbs(own, alpha=night)
    return cv2.add(cv2.max(dark, own), _glow(own, behind_panes.view(np.uint8), headlights))


def _glow(own: Image, panes: UInt8[Array, "h w"], strength: float) -> Image:
    """Light that lens and air scatter around lamps; a window is no lamp, and has little of it."""
    height, width = own.shape[:2]
    size = width // GLOW_DOWNSAMPLING, height // GLOW_DOWNSAMPLING
    small = cv2.resize(own, size, interpolation=cv2.INTER_AREA)
    lamps = cv2.copyTo(own, cv2.bitwise_not(cv2.convertScaleAbs(panes, alpha=255.0)))
    wide = cv2.resize(lamps, size, interpolation=cv2.INTER_AREA)
    near = cv2.blur(cv2.blur(small, (3, 3)), (3, 3))
    for _ in range(2):
        wide = cv2.blur(wide, (11, 11))
    both = cv2.addWeighted(near, NEAR_GLOW * strength, wide, WIDE_GLOW * strength, 0.0)
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
