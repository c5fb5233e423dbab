"""Augmentation: from a rendered crop to what the network is shown.

A detector's box errors, domain randomization (paint, light, background: the network is to learn
shapes, not colours), occluders, and the effects of a camera. Each crop is drawn anew in every
epoch, by the random numbers of its row in that epoch alone.
"""

from dataclasses import dataclass, replace

import cv2
import numpy as np
from jaxtyping import Float, Float32, Int, UInt8
from numpy import ndarray as Array

from mot_sim.simulation.random_numbers import named_stream
from mot_sim.simulation.renderers import Semantic
from mot_sim.simulation.truth import KeypointVisibility
from mot_sim.training.car_ends import repaint_ends
from mot_sim.training.keypoint_crops import ANY_CAR_MARK, CROP_PIXELS, OWN_CAR_MARK, Crops
from tracker.shape import CROP_SIDE, windows_of

KEYPOINTS_PER_SIDE = 18  # of a car; the mirror image of row i is row i + 18 of 36
MIRRORED_ROWS = np.roll(np.arange(2 * KEYPOINTS_PER_SIDE), KEYPOINTS_PER_SIDE)
# Errors of a detector's edges, as shares of the box's sides (the paper's detector on KITTI: 2.7 to
# 3.1 %); those of a worse detector, and how often that one is taken.
EDGE_STD = 0.03
POOR_EDGE_STD = 0.08
POOR_DETECTOR_SHARE = 0.15
ROLL_STD = 0.04  # radians: of the camera against the road
COVERED_SHARE = 0.18  # of crops, with something laid over the car
PART_CODES = 256
REPAINTED_SHARE = 0.45  # of crops
REPAINTED_ENDS_SHARE = 0.75  # of crops
VIVID_SHARE = 0.2  # of the other paints
SHADED_SHARE = 0.3  # of crops, partly in a shadow
NEW_BACKGROUND_SHARE = 0.25  # of crops
REFLECTION_CELLS = (4, 16)  # of the smooth noise that imitates reflections
# Standard deviation of the light that is added, in grey levels, by what it falls on.
SHEEN_STD = {
    Semantic.CAR: 14.0,
    Semantic.GLASS: 34.0,
    Semantic.TYRE: 9.0,
    Semantic.TRIM: 12.0,
    Semantic.LIGHT: 30.0,
    Semantic.PLATE: 25.0,
}
BACKGROUND_SHEEN_STD = 12.0
LOG_GAIN_STD = 0.25  # of the brightness of each kind of surface
# Camera effects, as shares of crops.
BLURRED_SHARE = 0.45
SHARPENED_SHARE = 0.2
MOTION_BLUR_SHARE = 0.08
JPEG_SHARE = 0.35
GREY_SHARE = 0.04
MIN_COARSE_PIXELS = 10


@dataclass(frozen=True, eq=False)
class AugmentedCrops:
    """The crops that the network is shown: one row per crop."""

    images: UInt8[Array, "n s s 3"]
    """BGR images at the network's size."""
    keypoints: Float[Array, "n 36 2"]
    """Keypoints (right, down) as shares of the image's sides; outside 0..1 where cut off, NaN
    behind the camera."""
    states: UInt8[Array, "n 36"]
    """A `KeypointVisibility` per keypoint."""


def exact_crops(crops: Crops) -> AugmentedCrops:
    """Crops as they were drawn, around the exact boxes."""
    return _stacked(
        [_warped(crops, row, crops.boxes[row] * CROP_PIXELS - 0.5) for row in range(len(crops))]
    )


def augmented_crops(crops: Crops, rows: Int[Array, " n"], seed: int, epoch: int) -> AugmentedCrops:
    """Some crops as they are shown in an epoch, and then the mirror image of each."""
    ones = [
        _augmented(crops, row, named_stream(seed, f"epoch {epoch} row {row}"))
        for row in rows.tolist()
    ]
    return _stacked([*ones, *map(mirrored, ones)])


def detected_crops(crops: Crops, seed: int) -> AugmentedCrops:
    """Crops as a camera and a detector give them, in their own colours: for scoring."""
    return _stacked(
        [_detected(crops, row, named_stream(seed, f"judged {row}")) for row in range(len(crops))]
    )


@dataclass(frozen=True, eq=False)
class AugmentedCrop:
    """One crop at the network's size; see `Crops`."""

    image: UInt8[Array, "s s 3"]
    """BGR image."""
    parts: UInt8[Array, "s s"]
    """What each pixel shows; see `Crops.parts`."""
    keypoints: Float[Array, "36 2"]
    """Keypoints (right, down) as shares of the image's sides."""
    states: UInt8[Array, "36"]
    """A `KeypointVisibility` per keypoint."""
    pixels: float
    """Pixels of KITTI's camera along the crop's side."""


def _stacked(ones: list[AugmentedCrop]) -> AugmentedCrops:
    return AugmentedCrops(
        np.array([one.image for one in ones]).reshape(-1, CROP_SIDE, CROP_SIDE, 3),
        np.array([one.keypoints for one in ones]).reshape(-1, 2 * KEYPOINTS_PER_SIDE, 2),
        np.array([one.states for one in ones], np.uint8).reshape(-1, 2 * KEYPOINTS_PER_SIDE),
    )


def _augmented(crops: Crops, row: int, rng: np.random.Generator) -> AugmentedCrop:
    box = crops.boxes[row] * CROP_PIXELS - 0.5
    size = np.tile(box[2:] - box[:2], 2)
    noise = POOR_EDGE_STD if rng.uniform() < POOR_DETECTOR_SHARE else EDGE_STD
    one = _warped(crops, row, box + rng.normal(0.0, noise, 4) * size, rng.normal(0.0, ROLL_STD))
    other = background(crops, int(rng.integers(len(crops))), CROP_SIDE, rng)
    if rng.uniform() < REPAINTED_ENDS_SHARE:
        image, parts = repaint_ends(one.image, one.parts, one.keypoints, other, rng)
        one = replace(one, image=image, parts=parts)
    image = domain_randomized(one.image, one.parts, other, rng)
    states = one.states
    if rng.uniform() < COVERED_SHARE:
        image, states = _covered(image, one, other, rng)
    return AugmentedCrop(
        camera_image(image, one.pixels, rng), one.parts, one.keypoints, states, one.pixels
    )


def _detected(crops: Crops, row: int, rng: np.random.Generator) -> AugmentedCrop:
    box = crops.boxes[row] * CROP_PIXELS - 0.5
    size = np.tile(box[2:] - box[:2], 2)
    one = _warped(crops, row, box + rng.normal(0.0, EDGE_STD, 4) * size)
    return replace(one, image=camera_image(one.image, one.pixels, rng))


def _warped(crops: Crops, row: int, box: Float[Array, "4"], turn: float = 0.0) -> AugmentedCrop:
    """A crop as the network sees it for a box in pixels of the stored square."""
    u, v, side = windows_of(box[None])[0].tolist()
    scale = CROP_SIDE / max(side, 1.0)
    c, s = scale * np.cos(turn), scale * np.sin(turn)
    middle = 0.5 * (CROP_SIDE - 1.0)
    A = np.array([[c, -s, middle - c * u + s * v], [s, c, middle - s * u - c * v]])
    size = (CROP_SIDE, CROP_SIDE)
    finer = cv2.INTER_AREA if scale < 0.75 else cv2.INTER_LINEAR
    points = (crops.keypoints[row] * CROP_PIXELS - 0.5) @ A[:, :2].T + A[:, 2]
    shares = (points + 0.5) / CROP_SIDE
    states = crops.states[row].copy()
    states[~((shares > 0.0) & (shares < 1.0)).all(axis=1)] = KeypointVisibility.TRUNCATED
    return AugmentedCrop(
        cv2.warpAffine(crops.images[row], A, size, flags=finer, borderMode=cv2.BORDER_REPLICATE),
        cv2.warpAffine(crops.parts[row], A, size, flags=cv2.INTER_NEAREST),
        shares,
        states,
        float(crops.pixels[row]) * side / CROP_PIXELS,
    )


def mirrored(one: AugmentedCrop) -> AugmentedCrop:
    """Left and right swapped, in the image and of the car."""
    keypoints = one.keypoints[MIRRORED_ROWS].copy()
    keypoints[:, 0] = 1.0 - keypoints[:, 0]
    return AugmentedCrop(
        np.ascontiguousarray(one.image[:, ::-1]),
        np.ascontiguousarray(one.parts[:, ::-1]),
        keypoints,
        one.states[MIRRORED_ROWS],
        one.pixels,
    )


def _covered(
    image: UInt8[Array, "s s 3"],
    one: AugmentedCrop,
    other: UInt8[Array, "s s 3"],
    rng: np.random.Generator,
) -> tuple[UInt8[Array, "s s 3"], UInt8[Array, "36"]]:
    """Something before the car: a block or an ellipse, in another crop's pixels or one colour."""
    own = np.argwhere(one.parts >= OWN_CAR_MARK)
    if not len(own):
        return image, one.states
    v, u = own[int(rng.integers(len(own)))].tolist()
    half = np.exp(rng.uniform(np.log(1.5), np.log(14.0), 2))
    half[1] = max(half[1], 8.0) if half[0] < 5.0 else half[1]
    across, down = (max(round(each), 1) for each in half.tolist())
    mask = np.zeros(one.parts.shape, np.uint8)
    if rng.uniform() < 0.5:
        mask[max(v - down, 0) : v + down + 1, max(u - across, 0) : u + across + 1] = 255
    else:
        turn = float(rng.uniform(0.0, 180.0))
        cv2.ellipse(mask, (u, v), (across, down), turn, 0.0, 360.0, 255, -1)
    image = image.copy()
    cover = other if rng.uniform() < 0.6 else np.full_like(image, rng.integers(0, 255, 3))
    cv2.copyTo(cover, mask, image)
    at = np.clip(np.nan_to_num(one.keypoints) * CROP_SIDE, 0, CROP_SIDE - 1).astype(np.int64)
    covered = mask[at[:, 1], at[:, 0]] > 0
    states = np.where(
        covered & (one.states == KeypointVisibility.VISIBLE),
        KeypointVisibility.OCCLUDED,
        one.states,
    )
    return image, states.astype(np.uint8)


def domain_randomized(
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
    if rng.uniform() < SHADED_SHARE:
        lit *= _cast_shadow(parts.shape[0], rng)
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
    if rng.uniform() < VIVID_SHARE:  # red paint is no sign of a rear
        hue = np.array([[[rng.integers(0, 180), rng.integers(140, 256), rng.integers(60, 250)]]])
        colour = cv2.cvtColor(hue.astype(np.uint8), cv2.COLOR_HSV2BGR)[0, 0].astype(float)
    pixels = lit[where]
    change = pixels - pixels.mean(axis=0)
    lit[where] = colour + rng.uniform(0.4, 1.4) * change


def _cast_shadow(side: int, rng: np.random.Generator) -> Float32[Array, "s s 1"]:
    """What a shadow that covers one side of the crop leaves of the light, often the lower one."""
    turn, soft = rng.uniform(0.0, 2.0 * np.pi), np.exp(rng.uniform(np.log(0.5), np.log(8.0)))
    if rng.uniform() < 0.5:
        turn = rng.normal(-0.5 * np.pi, 0.2)
    v, u = np.mgrid[:side, :side] - 0.5 * side
    across = np.cos(turn) * u + np.sin(turn) * v - rng.uniform(-0.3, 0.3) * side
    share = 1.0 / (1.0 + np.exp(np.clip(across / soft, -30.0, 30.0)))
    return (1.0 - rng.uniform(0.3, 0.9) * share)[:, :, None].astype(np.float32)


def _sheen(parts: UInt8[Array, "s s"], rng: np.random.Generator) -> Float32[Array, "s s 3"]:
    """Smooth light and shade, like reflections of the surroundings in paint and glass."""
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


def camera_image(
    image: UInt8[Array, "s s 3"], pixels: float, rng: np.random.Generator
) -> UInt8[Array, "s s 3"]:
    """The crop as a camera sees it that has `pixels` pixels along its side."""
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
    """Down to the camera's resolution, sometimes lower, and up again."""
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
