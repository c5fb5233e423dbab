"""What comes between a render and what the network is shown: the detector, the camera, chance.

Every crop is drawn anew in every epoch, by the random numbers of its row in that epoch alone.
"""

from dataclasses import dataclass, replace

import cv2
import numpy as np
from jaxtyping import Float, Int, UInt8
from numpy import ndarray as Array

from mot_sim.simulation.random_numbers import named_stream
from mot_sim.simulation.truth import KeypointVisibility
from mot_sim.training.camera_effects import through_camera
from mot_sim.training.crops import CROP_PIXELS, OWN_CAR_MARK, Crops
from mot_sim.training.domain_randomization import background, randomized
from tracker.shape import CROP_SIDE, windows_of

KEYPOINTS_PER_SIDE = 18  # keypoints of a side; the mirror image of row i is row i + 18 of 36
MIRRORED_ROWS = np.roll(np.arange(2 * KEYPOINTS_PER_SIDE), KEYPOINTS_PER_SIDE)
# A detector's edges, as shares of the box's sides (the paper's detector on KITTI: 2.7 to 3.1 %),
# and those of a worse one, and how often that one is taken.
EDGE_STD = 0.03
POOR_EDGE_STD = 0.08
POOR_DETECTOR_SHARE = 0.15
ROLL_STD = 0.04  # radians: of the camera, of the road
COVERED_SHARE = 0.18  # share of crops with something laid over the car


@dataclass(frozen=True, eq=False)
class AugmentedCrops:
    """What the network is shown: images (BGR), keypoints as shares of them, a `KeypointVisibility` each."""

    images: UInt8[Array, "n s s 3"]
    keypoints: Float[Array, "n 36 2"]
    states: UInt8[Array, "n 36"]


def exact_crops(crops: Crops) -> AugmentedCrops:
    """Crops as they were drawn, around the exact boxes."""
    return _stacked(
        [_warped(crops, row, crops.boxes[row] * CROP_PIXELS - 0.5) for row in range(len(crops))]
    )


def augmented_crops(crops: Crops, rows: Int[Array, " n"], seed: int, epoch: int) -> AugmentedCrops:
    """Some crops as they are shown in an epoch, and then the mirror image of each."""
    ones = [
        _varied(crops, row, named_stream(seed, f"epoch {epoch} row {row}")) for row in rows.tolist()
    ]
    return _stacked([*ones, *map(mirrored, ones)])


def detected_crops(crops: Crops, seed: int) -> AugmentedCrops:
    """Crops as a camera and a detector give them, in their own colours: what is judged on."""
    return _stacked(
        [_as_detected(crops, row, named_stream(seed, f"judged {row}")) for row in range(len(crops))]
    )


@dataclass(frozen=True, eq=False)
class AugmentedCrop:
    """One crop at the network's size. pixels: of KITTI's camera along its side."""

    image: UInt8[Array, "s s 3"]
    parts: UInt8[Array, "s s"]
    keypoints: Float[Array, "36 2"]
    states: UInt8[Array, "36"]
    pixels: float


def _stacked(ones: list[AugmentedCrop]) -> AugmentedCrops:
    return AugmentedCrops(
        np.array([one.image for one in ones]).reshape(-1, CROP_SIDE, CROP_SIDE, 3),
        np.array([one.keypoints for one in ones]).reshape(-1, 2 * KEYPOINTS_PER_SIDE, 2),
        np.array([one.states for one in ones], np.uint8).reshape(-1, 2 * KEYPOINTS_PER_SIDE),
    )


def _varied(crops: Crops, row: int, rng: np.random.Generator) -> AugmentedCrop:
    box = crops.boxes[row] * CROP_PIXELS - 0.5
    size = np.tile(box[2:] - box[:2], 2)
    noise = POOR_EDGE_STD if rng.uniform() < POOR_DETECTOR_SHARE else EDGE_STD
    one = _warped(crops, row, box + rng.normal(0.0, noise, 4) * size, rng.normal(0.0, ROLL_STD))
    other = background(crops, int(rng.integers(len(crops))), CROP_SIDE, rng)
    image = randomized(one.image, one.parts, other, rng)
    states = one.states
    if rng.uniform() < COVERED_SHARE:
        image, states = _hidden(image, one, other, rng)
    return AugmentedCrop(
        through_camera(image, one.pixels, rng), one.parts, one.keypoints, states, one.pixels
    )


def _as_detected(crops: Crops, row: int, rng: np.random.Generator) -> AugmentedCrop:
    box = crops.boxes[row] * CROP_PIXELS - 0.5
    size = np.tile(box[2:] - box[:2], 2)
    one = _warped(crops, row, box + rng.normal(0.0, EDGE_STD, 4) * size)
    return replace(one, image=through_camera(one.image, one.pixels, rng))


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
        shares, states, float(crops.pixels[row]) * side / CROP_PIXELS,
    )  # fmt: skip


def mirrored(one: AugmentedCrop) -> AugmentedCrop:
    """Left and right swapped, in the image and of the car."""
    keypoints = one.keypoints[MIRRORED_ROWS].copy()
    keypoints[:, 0] = 1.0 - keypoints[:, 0]
    return AugmentedCrop(
        np.ascontiguousarray(one.image[:, ::-1]), np.ascontiguousarray(one.parts[:, ::-1]),
        keypoints, one.states[MIRRORED_ROWS], one.pixels,
    )  # fmt: skip


def _hidden(
    image: UInt8[Array, "s s 3"],
    one: AugmentedCrop,
    other: UInt8[Array, "s s 3"],
    rng: np.random.Generator,
) -> tuple[UInt8[Array, "s s 3"], UInt8[Array, "36"]]:
    """Something before the car: a post, a block or a person's shape, of another crop's pixels."""
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
