"""What comes between a render and what the network is shown."""

from dataclasses import replace

import numpy as np
import pytest

from mot_sim.simulation.truth import KeypointVisibility
from mot_sim.training.augmentation import (
    MIRRORED_ROWS,
    augmented_crops,
    background,
    camera_image,
    detected_crops,
    domain_randomized,
    exact_crops,
)
from tests.mot_sim.training.made_up import made_up
from tracker.shape import CROP_MARGIN, CROP_SIDE, KEYPOINTS_36


def test_the_mirror_image_of_a_keypoint_is_the_same_one_of_the_other_side() -> None:
    for row, name in enumerate(KEYPOINTS_36):
        side, _, rest = name.partition("_")
        other = {"left": "right", "right": "left"}[side]
        assert KEYPOINTS_36[MIRRORED_ROWS[row]] == f"{other}_{rest}"


def test_exact_crops_have_the_box_in_their_middle() -> None:
    crops = made_up(3)
    shown = exact_crops(crops)
    assert shown.images.shape == (3, CROP_SIDE, CROP_SIDE, 3)
    # Shares of the box are the same in both squares.
    corner, size = crops.boxes[:, None, :2], crops.boxes[:, None, 2:] - crops.boxes[:, None, :2]
    in_box = (crops.keypoints - corner) / size
    long = np.array([1.0, 0.5]) / CROP_MARGIN
    assert shown.keypoints == pytest.approx(0.5 - 0.5 * long + in_box * long, abs=0.01)
    assert (shown.states == crops.states).all()


def test_an_epoch_shows_the_same_again_and_another_epoch_does_not() -> None:
    crops, rows = made_up(6), np.array([4, 1, 1])
    first, again, later = (augmented_crops(crops, rows, 3, epoch) for epoch in (0, 0, 1))
    assert (first.images == again.images).all()
    assert (first.keypoints == again.keypoints).all()
    assert (first.images[0] != later.images[0]).any()


def test_a_row_is_shown_alike_whatever_stands_beside_it() -> None:
    crops = made_up(6)
    together = augmented_crops(crops, np.array([4, 1]), 3, 0)
    alone = augmented_crops(crops, np.array([1]), 3, 0)
    assert (together.images[1] == alone.images[0]).all()


def test_the_second_half_mirrors_the_first() -> None:
    shown = augmented_crops(made_up(5), np.arange(5), 1, 0)
    assert (shown.images[5:] == shown.images[:5, :, ::-1]).all()
    assert shown.keypoints[5:, MIRRORED_ROWS, 0] == pytest.approx(1.0 - shown.keypoints[:5, :, 0])
    assert (shown.states[5:][:, MIRRORED_ROWS] == shown.states[:5]).all()


def test_keypoints_stay_on_the_car_when_the_box_is_off() -> None:
    crops = made_up(40)
    shown = detected_crops(crops, 0)
    seen = shown.states == KeypointVisibility.VISIBLE
    at = np.round(shown.keypoints * CROP_SIDE - 0.5).astype(int)
    grey = shown.images.mean(axis=3)
    rows = np.nonzero(seen)[0]
    on_car = grey[rows, at[seen][:, 1], at[seen][:, 0]]
    around = grey[:, :4, :].mean()
    assert np.median(on_car) > around + 30.0


def test_what_is_covered_is_not_seen() -> None:
    crops = made_up(60)
    shown = augmented_crops(crops, np.arange(60), 0, 0)
    covered = (shown.states == KeypointVisibility.OCCLUDED).any(axis=1)
    assert 0.02 < covered.mean() < 0.4


def test_points_behind_the_camera_are_never_seen() -> None:
    crops = made_up(8)
    keypoints = crops.keypoints.copy()
    keypoints[:, 3] = np.nan
    states = crops.states.copy()
    states[:, 3] = KeypointVisibility.TRUNCATED
    shown = augmented_crops(replace(crops, keypoints=keypoints, states=states), np.arange(8), 0, 0)
    assert (shown.states[:8, 3] == KeypointVisibility.TRUNCATED).all()
    assert (shown.states[8:, 3 + 18] == KeypointVisibility.TRUNCATED).all()


def test_crops_are_not_changed_by_being_shown() -> None:
    crops = made_up(6)
    before = crops.images.copy(), crops.keypoints.copy(), crops.states.copy()
    augmented_crops(crops, np.arange(6), 0, 0)
    for was, now in zip(before, (crops.images, crops.keypoints, crops.states), strict=True):
        assert (was == now).all()


def test_a_disguise_changes_colours_and_no_shape() -> None:
    crops, rng = made_up(20), np.random.default_rng(0)
    shares = []
    for image, parts in zip(crops.images, crops.parts, strict=True):
        other = background(crops, 1, image.shape[0], rng)
        changed = domain_randomized(image, parts, other, rng)
        shares.append((changed != image).any(axis=2).mean())
        assert changed.shape == image.shape
    assert min(shares) > 0.5


def test_few_pixels_leave_few_details() -> None:
    image = np.random.default_rng(0).integers(0, 255, (64, 64, 3)).astype(np.uint8)
    sharp, soft = [], []
    for seed in range(12):
        for pixels, found in ((64.0, sharp), (12.0, soft)):
            seen = camera_image(image, pixels, np.random.default_rng(seed)).astype(float)
            found.append(np.abs(np.diff(seen, axis=1)).mean())
    assert np.mean(soft) < 0.6 * np.mean(sharp)
