"""What an image's pixels are like, apart from what it shows: tone, colours, sharpness, noise."""

from collections.abc import Iterable
from dataclasses import astuple, dataclass, fields

import cv2
import numpy as np
from jaxtyping import Float, Float32, Int, UInt8
from numpy import ndarray as Array

from tracker.errors import BadConfig

DARK_LEVEL, CLIPPED_LEVEL = 25.0, 250.0  # grey levels of luma
LUMA_WEIGHTS = np.array([0.299, 0.587, 0.114], np.float32)  # of R, G, B
SLOPE_FREQUENCIES = (0.01, 0.4)  # cycles a pixel, between which the spectrum's slope is taken
FINE_FREQUENCY = 0.25  # cycles a pixel
MIN_IMAGE_SIDE = 64  # pixels
# Noise is measured where the image is flattest, in three ranges of luma.
NOISE_LEVELS = ((25.0, 50.0), (50.0, 100.0), (100.0, 150.0))
FLAT_SHARE = 0.1  # of a range's pixels
MIN_FLAT_PIXELS = 500
NOISE_KERNEL = np.array([[1, -2, 1], [-2, 4, -2], [1, -2, 1]], np.float32) / 6.0  # Immerkaer 1996
STD_OF_MAD = 1.4826  # std of a normal distribution over its median absolute deviation


@dataclass(frozen=True)
class ImageStatistics:
    """Statistics of an image, or the means of several's; NaN where there is nothing to measure."""

    luma_std: float
    """Standard deviation of the luma, grey levels: contrast."""
    dark: float
    """Share of the pixels with a luma below 25, percent."""
    clipped: float
    """Share of the pixels with a luma of 250 and more, percent."""
    saturation: float
    """Mean saturation (HSV), 0 to 255."""
    red_minus_blue: float
    """Mean of red less blue, grey levels; below 0: bluish."""
    gradient: float
    """Median length of the gradient (Sobel), grey levels a pixel: texture."""
    spectrum_slope: float
    """Slope of the power over the frequency, both as logarithms, .01 to .4 cycles a pixel."""
    fine_power: float
    """Share of the power above a quarter of the sampling frequency, 1e-4: hard edges and noise."""
    noise_dark: float
    """Standard deviation of the noise at a luma of 25 to 50, grey levels."""
    noise_mid: float
    """The same at 50 to 100."""
    noise_bright: float
    """The same at 100 to 150."""


STATISTICS = tuple(each.name for each in fields(ImageStatistics))


def image_statistics(image: UInt8[Array, "h w 3"]) -> ImageStatistics:
    """The statistics of an RGB image. Raises BadConfig for one below 64 pixels a side."""
    if min(image.shape[:2]) < MIN_IMAGE_SIDE:
        raise BadConfig(
            f"an image of {image.shape[1]} x {image.shape[0]} pixels: give {MIN_IMAGE_SIDE} or "
            "more a side"
        )
    luma: Float32[Array, "h w"] = image.astype(np.float32) @ LUMA_WEIGHTS
    slope, fine = _spectrum(luma)
    red, _, blue = image.reshape(-1, 3).mean(axis=0).tolist()
    return ImageStatistics(
        float(luma.std()),
        100.0 * float((luma < DARK_LEVEL).mean()),
        100.0 * float((luma >= CLIPPED_LEVEL).mean()),
        float(cv2.cvtColor(image, cv2.COLOR_RGB2HSV)[..., 1].mean()),
        red - blue,
        float(np.median(_gradient(luma))),
        slope,
        fine,
        *_noise(luma),
    )


def mean_statistics(images: Iterable[UInt8[Array, "h w 3"]]) -> ImageStatistics:
    """The means over images of what each has. Raises BadConfig for none."""
    rows = np.array([astuple(image_statistics(image)) for image in images])
    if not len(rows):
        raise BadConfig("no image to measure: give one or more")
    counts = np.isfinite(rows).sum(axis=0)
    means = np.where(counts > 0, np.nansum(rows, axis=0) / np.maximum(counts, 1), np.nan)
    return ImageStatistics(*means.tolist())


def _gradient(luma: Float32[Array, "h w"]) -> Float32[Array, "h w"]:
    across, down = (cv2.Sobel(luma, cv2.CV_32F, *way) for way in ((1, 0), (0, 1)))
    return np.asarray(cv2.magnitude(across, down), np.float32) / np.float32(8.0)


def _spectrum(luma: Float32[Array, "h w"]) -> tuple[float, float]:
    """Slope of the power over the frequency, and the share of high frequencies, 1e-4.

    Of the largest squares side by side, each under a Hann window.
    """
    side = min(luma.shape)
    window = np.outer(np.hanning(side), np.hanning(side)).astype(np.float32)
    power = np.zeros((side, side // 2 + 1))
    for row in range(0, luma.shape[0] - side + 1, side):
        for column in range(0, luma.shape[1] - side + 1, side):
            square = luma[row : row + side, column : column + side]
            power += np.abs(np.fft.rfft2((square - square.mean()) * window)) ** 2
    frequency, ring, twice = _frequencies(side)
    weighed = power * twice
    rings = np.bincount(ring.ravel(), weighed.ravel()) / np.bincount(ring.ravel(), twice.ravel())
    at = np.arange(len(rings)) / side
    inside = (at >= SLOPE_FREQUENCIES[0]) & (at <= SLOPE_FREQUENCIES[1]) & (rings > 0.0)
    total = weighed.sum() - weighed[0, 0]
    if inside.sum() < 2 or total <= 0.0:
        return np.nan, np.nan
    slope = float(np.polyfit(np.log(at[inside]), np.log(rings[inside]), 1)[0])
    return slope, 1e4 * float(weighed[frequency > FINE_FREQUENCY].sum() / total)


def _frequencies(
    side: int,
) -> tuple[Float[Array, "s k"], Int[Array, "s k"], Float[Array, "s k"]]:
    """Frequency, ring and weight of each term of a real transform; most stand for two."""
    across = np.fft.rfftfreq(side)
    frequency = np.hypot(np.fft.fftfreq(side)[:, None], across[None, :])
    is_single = (across == 0.0) | (across == 0.5)
    twice = np.where(is_single, 1.0, 2.0) * np.ones_like(frequency)
    return frequency, np.round(frequency * side).astype(np.int64), twice


def _noise(luma: Float32[Array, "h w"]) -> tuple[float, ...]:
    """Standard deviation of the noise in each range of luma, in the flattest pixels."""
    rough = np.abs(cv2.filter2D(luma, cv2.CV_32F, NOISE_KERNEL))
    smooth = np.asarray(cv2.GaussianBlur(luma, (0, 0), 2.0), np.float32)
    steep, found = _gradient(smooth), []
    for least, most in NOISE_LEVELS:
        inside = (smooth >= least) & (smooth < most)
        if inside.sum() < MIN_FLAT_PIXELS:
            found.append(np.nan)
            continue
        slopes = steep[inside]
        flat = slopes <= np.quantile(slopes, FLAT_SHARE)
        found.append(STD_OF_MAD * float(np.median(rough[inside][flat])))
    return tuple(found)
