"""The classical descriptor: colours and gradients over a grid, without any learned weight."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Float32, Shaped, UInt8
from numpy import ndarray as Array

from tracker.descriptors.patches import can_be_cut, patches, require_rgb

PATCH_SIDE = 32  # pixels of a patch
GRID_CELLS = 4  # cells along each side
COLOUR_BINS = (8, 6, 6)  # of brightness, and of the two colour axes
ORIENTATIONS = 8
# Brightness: in stops from the picture's own; colours: differences of stops.
BRIGHTNESS_RANGE = (-4.0, 3.0)
COLOUR_RANGE = (-0.9, 0.9)
SAMPLING_STRIDE = 4  # every fourth pixel tells how bright the picture is


@dataclass(frozen=True)
class Classical:
    """Histograms of colour and of gradient directions, in 4 x 4 cells of the box.

    Colours are measured in stops against the mean of the whole picture, so that neither
    exposure nor the colour of the light matters; black and white cars stay apart. Histograms
    are compared by their square roots (Hellinger).
    """

    gradients: float = 0.35
    """Share of the gradients in the squared length, 0 to 1; more: colours count less."""
    unit: float = 0.45
    """Distance at which two cars are as likely one as two, on synthetic cars
    (`benchmarks.appearance --unit`), > 0; more: all distances become smaller."""

    @property
    def needs_activations(self) -> bool:
        """It looks at pixels alone."""
        return False

    @property
    def length(self) -> int:
        """How many numbers a descriptor has."""
        return GRID_CELLS**2 * (sum(COLOUR_BINS) + ORIENTATIONS)

    def __call__(
        self,
        image: Shaped[Array, "..."],
        boxes: Float[Array, "n 4"],
        activations: Float32[Array, "n c s s"] | None = None,
    ) -> Float[Array, "n d"]:
        """Vectors of length 1 / unit; NaN where a box has less than two pixels in the image."""
        require_rgb(image)
        found = np.full((len(boxes), self.length), np.nan)
        rows = np.flatnonzero(can_be_cut(image, boxes))
        if len(rows):
            light = image[::SAMPLING_STRIDE, ::SAMPLING_STRIDE].reshape(-1, 3).mean(axis=0)
            pixels = patches(image, boxes[rows], PATCH_SIDE)
            colours = _colours(pixels, light) * np.sqrt((1.0 - self.gradients) / 3.0)
            directions = _directions(pixels) * np.sqrt(self.gradients)
            found[rows] = np.concatenate((colours, directions), axis=1) / self.unit
        return found


def _colours(pixels: UInt8[Array, "n s s 3"], light: Float[Array, "3"]) -> Float[Array, "n d"]:
    """Square roots of the shares of brightness and of two colour differences, cell by cell."""
    stops = np.log2((pixels + 2.0) / (light + 2.0))
    red, green, blue = np.moveaxis(stops, 3, 0)
    axes = ((red + green + blue) / 3.0, red - green, blue - 0.5 * (red + green))
    ranges = (BRIGHTNESS_RANGE, COLOUR_RANGE, COLOUR_RANGE)
    parts = [
        _histograms((axis - low) / (high - low) * (count - 1), np.ones_like(axis), count)
        for axis, (low, high), count in zip(axes, ranges, COLOUR_BINS, strict=True)
    ]
    return np.concatenate(parts, axis=1)


def _directions(pixels: UInt8[Array, "n s s 3"]) -> Float[Array, "n d"]:
    """Square roots of the shares of gradient directions (without sign), by strength."""
    grey = pixels @ np.array([0.299, 0.587, 0.114])
    along = np.zeros((2, *grey.shape))
    along[0, :, :, 1:-1] = grey[:, :, 2:] - grey[:, :, :-2]
    along[1, :, 1:-1] = grey[:, 2:] - grey[:, :-2]
    strength = np.hypot(along[0], along[1])
    angle = np.arctan2(along[1], along[0]) / np.pi * ORIENTATIONS
    return _histograms(angle, strength + 1e-3, ORIENTATIONS, turning=True)


def _histograms(
    places: Float[Array, "n s s"], weights: Float[Array, "n s s"], count: int, turning: bool = False
) -> Float[Array, "n d"]:
    """Square roots of weighted shares, of length 1: pixels count for the two bins around them.

    turning: the last bin's neighbour is the first.
    """
    n = len(places)
    if not turning:
        places = places.clip(0.0, count - 1.0)
    low = np.floor(places).astype(np.int64)
    rest = places - low
    cell = (np.arange(PATCH_SIDE) * GRID_CELLS // PATCH_SIDE)[:, None] * GRID_CELLS + np.arange(
        PATCH_SIDE
    ) * GRID_CELLS // PATCH_SIDE
    rows = np.arange(n)[:, None, None] * GRID_CELLS**2 + cell
    total = np.zeros(n * GRID_CELLS**2 * count)
    for bins, share in ((low, 1.0 - rest), (low + 1, rest)):
        bounded = bins % count if turning else np.minimum(bins, count - 1)
        index = (rows * count + bounded).ravel()
        total += np.bincount(index, (share * weights).ravel(), len(total))
    shares = total.reshape(n, GRID_CELLS**2, count)
    shares /= np.maximum(shares.sum(axis=2, keepdims=True), 1e-12)
    roots: Float[Array, "n d"] = np.sqrt(shares).reshape(n, -1) / GRID_CELLS
    return roots
