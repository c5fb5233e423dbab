"""Fine texture of the ground: noise that repeats itself, in coarser and coarser copies."""

from dataclasses import dataclass
from functools import lru_cache

import cv2
import numpy as np
from jaxtyping import Float32
from numpy import ndarray as Array

from mot_sim.simulation.random_numbers import named_stream

TEXEL = 0.025  # metres, of the finest pictures
LEVELS = 5  # each one twice as coarse as the one before
PERIOD = 1024  # texels of the finest picture after which the grain repeats: 25.6 m
COARSE = 0.4  # metres a texel of the slow noise, which repeats after 409.6 m
TILE = 256  # texels along a tile's sides


@dataclass(frozen=True, eq=False)
class Grain:
    """Noise of unit variance for each level of detail: `stones` and `blades`; `slow` for all."""

    stones: tuple[Float32[Array, "_ _"], ...]
    blades: tuple[Float32[Array, "_ _"], ...]
    slow: Float32[Array, "s s"]

    def at(self, which: str, level: int, column: int, row: int) -> Float32[Array, "t t"]:
        """The noise under a tile."""
        layer: Float32[Array, "_ _"] = getattr(self, which)[level]
        period = max(PERIOD >> level, 1)
        u, v = column * TILE % period, row * TILE % period
        return layer[v : v + TILE, u : u + TILE]

    def slow_at(self, level: int, column: int, row: int) -> Float32[Array, "t t"]:
        """The slow noise under a tile, interpolated."""
        ratio = (TEXEL * 2**level) / COARSE
        x, y = column * TILE * ratio, row * TILE * ratio
        size = len(self.slow)
        A = np.array([[ratio, 0.0, x % size], [0.0, ratio, y % size]])
        return cv2.warpAffine(
            self.slow,
            A,
            (TILE, TILE),
            flags=cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP,
            borderMode=cv2.BORDER_WRAP,
        )


@lru_cache(maxsize=4)
def grain_of(seed: int) -> Grain:
    """The grain of a seed."""
    rng = named_stream(seed, "grain")
    stones = _rough(rng, PERIOD, 0.35)
    stones += 1.2 * (stones > 2.2) - 0.8 * (stones < -2.3)  # single bright and dark stones
    blades = _rough(rng, PERIOD, 0.75)
    slow = _rough(rng, PERIOD, 1.6)
    return Grain(_pyramid(stones), _pyramid(blades), slow)


def _rough(rng: np.random.Generator, size: int, slope: float) -> Float32[Array, "s s"]:
    """Periodic noise whose amplitude falls with the frequency to the power of -slope."""
    spectrum = np.fft.rfft2(rng.standard_normal((size, size)))
    v, u = np.fft.fftfreq(size)[:, None], np.fft.rfftfreq(size)[None]
    frequency = np.maximum(np.hypot(u, v), 2.0 / size)
    noise = np.fft.irfft2(spectrum * frequency**-slope, (size, size))
    noise -= noise.mean()
    return (noise / noise.std()).astype(np.float32)


def _pyramid(noise: Float32[Array, "s s"]) -> tuple[Float32[Array, "_ _"], ...]:
    """The mean of 1, 4, 16, ... texels, repeated until a tile fits at every place."""
    layers = []
    for level in range(LEVELS):
        size = PERIOD >> level
        layer = cv2.resize(noise, (size, size), interpolation=cv2.INTER_AREA) if level else noise
        times = -(-(size + TILE) // size)
        layers.append(np.tile(layer, (times, times))[: size + TILE, : size + TILE].copy())
    return tuple(layers)
