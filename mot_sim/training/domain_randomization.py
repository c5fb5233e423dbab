"""Other paint, other glass, another background: the network is to learn shapes, not colours."""

import cv2
import numpy as np
from jaxtyping import Float32, UInt8
from numpy import ndarray as Array

from mot_sim.simulation.renderers import Semantic
from mot_sim.training.crops import ANY_CAR_MARK, OWN_CAR_MARK, Crops

PART_CODES = 256
REPAINTED_SHARE = 0.45  # shares of crops
NEW_BACKGROUND_SHARE = 0.25  # shares of crops
REFLECTION_CELLS = (4, 16)  # cells of the noise that stands for reflections
# Standard deviation of the light that is added, in grey levels, by what it falls on.
SHEEN_STD = {
    Semantic.CAR: 14.0, Semantic.GLASS: 34.0, Semantic.TYRE: 9.0, Semantic.TRIM: 12.0,
    Semantic.LIGHT: 30.0, Semantic.PLATE: 25.0,
}  # fmt: skip
BACKGROUND_SHEEN_STD = 12.0
LOG_GAIN_STD = 0.25  # of the logarithm of brightness, of each kind of surface


def randomized(
    image: UInt8[Array, "s s 3"],
    parts: UInt8[Array, "s s"],
    other: UInt8[Array, "s s 3"],
    rng: np.random.Generator,
) -> UInt8[Array, "s s 3"]:
    """The crop with each kind of surface lit, tinted and perhaps painted differently."""
    gains = np.exp(
        rng.normal(0.0, LOG_GAIN_STD, (PART_CODES, 1)) + rng.normal(0.0, 0.06, (PART_CODES, 3))
    )
    lit = image * gains.astype(np.float32)[parts]
    for mark in (OWN_CAR_MARK | ANY_CAR_MARK, ANY_CAR_MARK):
        if rng.uniform() < REPAINTED_SHARE:
            _repaint(lit, parts == (mark | Semantic.CAR), rng)
        if rng.uniform() < REPAINTED_SHARE:
            _repaint(lit, parts == (mark | Semantic.GLASS), rng)
    lit += _sheen(parts, rng)
    if rng.uniform() < NEW_BACKGROUND_SHARE:
        keep = parts >= (ANY_CAR_MARK if rng.uniform() < 0.5 else OWN_CAR_MARK)
        soft = cv2.GaussianBlur(keep.astype(np.float32), (3, 3), 0.0)[:, :, None]
        lit = lit * soft + other * (1.0 - soft)
    return np.clip(lit, 0.0, 255.0).astype(np.uint8)


def _repaint(lit: Float32[Array, "s s 3"], where: Array, rng: np.random.Generator) -> None:
    """Another colour in a mask, in place; light and shade stay, stronger or weaker."""
    if not where.any():
        return
    grey = rng.uniform(8.0, 240.0)
    colour = np.clip(grey + rng.normal(0.0, 12.0 if rng.uniform() < 0.6 else 50.0, 3), 4.0, 250.0)
    pixels = lit[where]
    change = pixels - pixels.mean(axis=0)
    lit[where] = colour + rng.uniform(0.4, 1.4) * change


def _sheen(parts: UInt8[Array, "s s"], rng: np.random.Generator) -> Float32[Array, "s s 3"]:
    """Smooth light and shade, as what stands around is mirrored in paint and glass."""
    strength = np.full(PART_CODES, BACKGROUND_SHEEN_STD, np.float32)
    for kind, level in SHEEN_STD.items():
        strength[[kind, kind | ANY_CAR_MARK, kind | ANY_CAR_MARK | OWN_CAR_MARK]] = level
    strength *= np.float32(rng.uniform(0.0, 1.4))
    side = parts.shape[0]
    field = np.zeros((side, side), np.float32)
    for cells in REFLECTION_CELLS:
        # Mirror images on a car are wider than high.
        rough = rng.standard_normal((cells, max(cells // 2, 2)), dtype=np.float32)
        field += cv2.resize(rough, (side, side), interpolation=cv2.INTER_CUBIC)
    tint = (1.0 + rng.normal(0.0, 0.15, 3)).astype(np.float32)
    return (strength[parts] * field)[:, :, None] * tint


def background(
    crops: Crops, row: int, side: int, rng: np.random.Generator
) -> UInt8[Array, "s s 3"]:
    """A piece of another crop, turned over at random, or rough noise."""
    if rng.uniform() < 0.8:
        wide = crops.images.shape[1]
        extent = int(rng.integers(wide // 4, wide))
        left, top = rng.integers(0, wide - extent, 2).tolist()
        piece = crops.images[row, top : top + extent, left : left + extent]
        piece = piece[:, :: int(rng.choice((-1, 1)))]
        return cv2.resize(np.ascontiguousarray(piece), (side, side), interpolation=cv2.INTER_LINEAR)
    cells = int(rng.integers(2, 24))
    rough = rng.integers(0, 255, (cells, cells, 3), dtype=np.uint8)
    return cv2.resize(rough, (side, side), interpolation=cv2.INTER_LINEAR)
