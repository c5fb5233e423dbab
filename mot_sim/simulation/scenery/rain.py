"""Rain: drops that fall past the camera, and a wet road that mirrors what stands behind it."""

from functools import lru_cache

import cv2
import numpy as np
from jaxtyping import Float32, UInt8
from numpy import ndarray as Array

from mot_sim.simulation.random_numbers import named_stream, uniform
from mot_sim.simulation.renderers import Semantic
from mot_sim.simulation.renderers.ground import horizon
from tracker.types import Camera

Image = UInt8[Array, "h w 3"]
SPARE_PIXELS = 384  # pixels: by how much the layer of drops is larger than the image
DROPS_PER_PIXEL = 0.0011  # a pixel, in the heaviest rain
WET_DARKENING = 0.3  # of its brightness, that wet asphalt loses


def rained_on(
    image: Image,
    camera: Camera,
    semantics: UInt8[Array, "h w"],
    amount: float,
    seed: int,
    frame: int,
) -> Image:
    """The image in the rain; amount 0 to 1."""
    first = horizon(camera).first
    height = len(image)
    if 0 < first < height:
        image = image.copy()
        lower = image[first:]
        road = (semantics[first:] == Semantic.ROAD).view(np.uint8) * np.uint8(255)
        mirrored = _mirrored(image, first)
        share = _sheen(camera, amount)
        dull = np.float32(1.0 - WET_DARKENING * amount) * (np.float32(1.0) - share)
        wet = cv2.blendLinear(lower, mirrored, dull, share)
        weight = np.asarray(cv2.blur(road, (3, 3)), np.float32) * np.float32(1.0 / 255.0)
        # blendLinear divides by the sum of its weights: take the wet share of light back.
        wet = cv2.multiply(wet, cv2.merge([dull + share] * 3), dtype=cv2.CV_8U)
        image[first:] = cv2.blendLinear(wet, lower, weight, np.float32(1.0) - weight)
    return cv2.add(image, _drops(camera, amount, seed, frame))


def _mirrored(image: Image, first: int) -> UInt8[Array, "_ _ 3"]:
    """What stands above the horizon, upside down below it, smeared by the rough road."""
    rows = len(image) - first
    source = np.clip(first - 1 - np.arange(rows) * first // max(rows, first), 0, first - 1)
    small = cv2.resize(image[source], (image.shape[1] // 4, max(rows // 4, 1)))
    return cv2.resize(cv2.blur(small, (3, 13)), (image.shape[1], rows))


@lru_cache(maxsize=8)
def _sheen(camera: Camera, amount: float) -> Float32[Array, "r w"]:
    """How much of the light comes from the mirror: the more, the flatter one looks at it."""
    seen = horizon(camera)
    slope = np.maximum(-seen.slope[seen.first :], 0.0)
    return (amount * (0.1 + 0.5 * np.exp(-slope / 0.09))).astype(np.float32)


def _drops(camera: Camera, amount: float, seed: int, frame: int) -> Image:
    """A piece of the layer of drops; every frame has another."""
    width, height = camera.image_size
    where = uniform(seed, "rain", np.zeros(1, np.int64), np.array([frame]), 2)[0]
    top, left = (SPARE_PIXELS * where).astype(int)
    layer = _layer(seed, amount, (height + SPARE_PIXELS, width + SPARE_PIXELS))
    return layer[top : top + height, left : left + width]


@lru_cache(maxsize=4)
def _layer(seed: int, amount: float, size: tuple[int, int]) -> Image:
    """Streaks, long ones of near drops and short ones of far drops."""
    rng = named_stream(seed, "rain")
    count = int(DROPS_PER_PIXEL * amount * size[0] * size[1])
    layer = np.zeros(size, np.uint8)
    start = rng.uniform(0.0, 1.0, (count, 2)) * (size[1], size[0])
    length, light = rng.uniform(5.0, 26.0, count), rng.uniform(10.0, 46.0, count)
    slant = rng.normal(0.06, 0.03, count)
    for (u, v), long, bright, lean in zip(start, length, light, slant, strict=True):
        ends = np.round(np.array([(u, v), (u + lean * long, v + long)]) * 16).astype(int)
        cv2.line(
            layer,
            tuple(ends[0].tolist()),
            tuple(ends[1].tolist()),
            (float(bright),),
            1,
            cv2.LINE_AA,
            4,
        )
    return cv2.merge((layer, layer, layer))
