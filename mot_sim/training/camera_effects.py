"""What a camera does to a crop: few pixels, blur, exposure, noise, compression."""

import cv2
import numpy as np
from jaxtyping import UInt8
from numpy import ndarray as Array

BLURRED_SHARE = 0.45  # shares of crops
SHARPENED_SHARE = 0.2  # shares of crops
MOTION_BLUR_SHARE = 0.08  # shares of crops
JPEG_SHARE = 0.35  # shares of crops
GREY_SHARE = 0.04  # shares of crops
MIN_COARSE_PIXELS = 10  # pixels across


def through_camera(
    image: UInt8[Array, "s s 3"], pixels: float, rng: np.random.Generator
) -> UInt8[Array, "s s 3"]:
    """The crop as a camera gives it that has so many pixels along its side."""
    image = _coarse(image, pixels, rng)
    if rng.uniform() < BLURRED_SHARE:
        image = cv2.GaussianBlur(image, (0, 0), float(rng.uniform(0.3, 1.3)))
    elif rng.uniform() < SHARPENED_SHARE:
        soft = cv2.GaussianBlur(image, (0, 0), 1.0)
        gain = float(rng.uniform(0.2, 0.9))
        image = cv2.addWeighted(image, 1.0 + gain, soft, -gain, 0.0)
    if rng.uniform() < MOTION_BLUR_SHARE:
        length = int(rng.integers(2, 6))
        image = cv2.blur(image, (length, 1))
    image = _exposed(image, rng)
    if rng.uniform() < JPEG_SHARE:
        quality = int(rng.integers(25, 92))
        _, packed = cv2.imencode(".jpg", image, [cv2.IMWRITE_JPEG_QUALITY, quality])
        image = np.asarray(cv2.imdecode(packed, cv2.IMREAD_COLOR), np.uint8)
    if rng.uniform() < GREY_SHARE:
        image = cv2.cvtColor(cv2.cvtColor(image, cv2.COLOR_BGR2GRAY), cv2.COLOR_GRAY2BGR)
    return image


def _coarse(
    image: UInt8[Array, "s s 3"], pixels: float, rng: np.random.Generator
) -> UInt8[Array, "s s 3"]:
    """Down to the pixels that the camera has, sometimes fewer, and up again."""
    side = image.shape[0]
    have = pixels * rng.uniform(0.75, 1.15)
    if rng.uniform() < 0.25:
        have = min(have, np.exp(rng.uniform(np.log(18.0), np.log(64.0))))
    count = max(int(have), MIN_COARSE_PIXELS)
    if count >= side:
        return image
    small = cv2.resize(image, (count, count), interpolation=cv2.INTER_AREA)
    return cv2.resize(small, (side, side), interpolation=cv2.INTER_LINEAR)


def _exposed(image: UInt8[Array, "s s 3"], rng: np.random.Generator) -> UInt8[Array, "s s 3"]:
    """Another gamma, contrast, brightness and white balance; the sensor's noise."""
    gamma = np.exp(rng.normal(0.0, 0.25))
    gain = np.exp(rng.normal(0.12, 0.28) + rng.normal(0.0, 0.04, 3))
    shift = rng.normal(4.0, 14.0)
    levels = 255.0 * (np.arange(256) / 255.0) ** gamma
    table = np.clip(128.0 + (levels[:, None] - 128.0) * gain + shift, 0.0, 255.0)
    seen = cv2.LUT(image, table.astype(np.uint8).reshape(1, 256, 3))
    level = float(rng.exponential(3.5))
    noise = rng.standard_normal(image.shape, dtype=np.float32) * np.float32(level)
    return np.clip(seen + noise, 0.0, 255.0).astype(np.uint8)
