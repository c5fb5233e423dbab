"""Crops that nobody has drawn: a bright block for a car, keypoints where its corners are."""

import numpy as np

from mot_sim.simulation.renderers import Semantic
from mot_sim.simulation.truth import KeypointVisibility
from mot_sim.training.keypoint_crops import (
    ANY_CAR_MARK,
    CROP_PIXELS,
    CROP_ROOM,
    OWN_CAR_MARK,
    Crops,
)
from tracker.shape import CROP_MARGIN

SHARE = 1.0 / (CROP_ROOM * CROP_MARGIN)  # of the stored square, that a box is long


def made_up(count: int, seed: int = 0) -> Crops:
    """Blocks half as high as long; left keypoints on the left half, right ones on the right."""
    rng = np.random.default_rng(seed)
    images = rng.integers(40, 90, (count, CROP_PIXELS, CROP_PIXELS, 3)).astype(np.uint8)
    parts = np.full((count, CROP_PIXELS, CROP_PIXELS), Semantic.GROUND, np.uint8)
    half = 0.5 * SHARE * np.array([1.0, 0.5])
    low, high = 0.5 - half, 0.5 + half
    left, top, right, bottom = (
        np.round(np.concatenate((low, high)) * CROP_PIXELS).astype(int).tolist()
    )
    images[:, top:bottom, left:right] = rng.integers(120, 240, (count, 1, 1, 3))
    parts[:, top:bottom, left:right] = Semantic.CAR | ANY_CAR_MARK | OWN_CAR_MARK
    places = np.random.default_rng(9).uniform(0.05, 0.45, (36, 2))  # the same on every block
    keypoints = np.tile(low + places * (high - low), (count, 1, 1))
    keypoints[:, 18:, 0] = 1.0 - keypoints[:, :18, 0]
    keypoints[:, 18:, 1] = keypoints[:, :18, 1]
    states = np.full((count, 36), KeypointVisibility.VISIBLE, np.uint8)
    states[:, ::5] = KeypointVisibility.SELF_OCCLUDED
    return Crops(
        images, parts, keypoints, states, np.tile(np.concatenate((low, high)), (count, 1)),
        rng.uniform(60.0, 300.0, count), rng.uniform(5.0, 40.0, count), np.ones(count),
        np.zeros(count), rng.uniform(-3.0, 3.0, count),
    )  # fmt: skip
