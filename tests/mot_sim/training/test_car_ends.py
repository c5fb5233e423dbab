"""Fronts and rears that are painted anew."""

import numpy as np
import pytest

from mot_sim.simulation.renderers import Semantic
from mot_sim.training.car_ends import OWN, repaint_ends
from tracker.shape import CROP_SIDE, KEYPOINTS_36

GREY = 90
ENDS = (
    ("rear_bumper", "taillight", "rear_window_foot", "roof_rear"),
    ("front_bumper", "headlight", "windscreen_foot", "roof_front"),
)
LEVELS = (50.0, 36.0, 33.0, 16.0)  # pixels from the top


def one_end(is_front: bool) -> tuple[np.ndarray, ...]:
    """A grey car of which one end is seen: its image, its parts, its keypoints as shares."""
    image = np.full((CROP_SIDE, CROP_SIDE, 3), 200, np.uint8)
    parts = np.full((CROP_SIDE, CROP_SIDE), int(Semantic.ROAD), np.uint8)
    image[16:51, 14:51], parts[16:51, 14:51] = GREY, Semantic.CAR | OWN
    image[18:33, 18:47], parts[18:33, 18:47] = 20, Semantic.GLASS | OWN
    pixels = np.full((36, 2), 32.0)
    left, right = (50.0, 14.0) if is_front else (14.0, 50.0)
    for names in ENDS:
        for name, level in zip(names, LEVELS, strict=True):
            pixels[KEYPOINTS_36.index(f"left_{name}")] = left, level
            pixels[KEYPOINTS_36.index(f"right_{name}")] = right, level
    return image, parts, (pixels + 0.5) / CROP_SIDE


def painted(is_front: bool, count: int = 60) -> tuple[np.ndarray, np.ndarray]:
    """Many cars seen from that end: images and parts."""
    other = np.full((CROP_SIDE, CROP_SIDE, 3), 120, np.uint8)
    rows = [
        repaint_ends(*one_end(is_front), other, np.random.default_rng(seed))
        for seed in range(count)
    ]
    return np.array([row[0] for row in rows]).astype(int), np.array([row[1] for row in rows])


def lamps(images: np.ndarray, parts: np.ndarray) -> np.ndarray:
    """The mean colour, BGR, of each car's lamps; of those that have any."""
    found = [
        image[mark == (Semantic.LIGHT | OWN)].mean(axis=0)
        for image, mark in zip(images, parts, strict=True)
        if (mark == (Semantic.LIGHT | OWN)).sum() > 3
    ]
    return np.array(found)


def test_lamps_are_red_behind_and_clear_ahead() -> None:
    rear, front = lamps(*painted(False)), lamps(*painted(True))
    assert min(len(rear), len(front)) > 25
    red = [one[:, 2] - one[:, :2].max(axis=1) for one in (rear, front)]  # amber is none
    assert np.median(red[0]) > 30
    assert (red[0] > 15).mean() > 0.7
    assert (red[1] < 15).mean() > 0.7


def test_the_road_and_other_cars_stay_as_they_are() -> None:
    image, parts, _ = one_end(False)
    images, marked = painted(False)
    beside = parts < OWN
    assert (images[:, beside] == image[beside]).all()
    assert (marked[:, beside] == parts[beside]).all()


def test_rears_differ() -> None:
    images, _ = painted(False)
    apart = np.abs(images[:, None] - images[None]).mean(axis=(2, 3, 4))
    assert np.median(apart[~np.eye(len(images), dtype=bool)]) > 3.0


@pytest.mark.parametrize("is_front", [False, True])
def test_an_end_that_looks_away_is_not_painted(is_front: bool) -> None:
    image, parts, keypoints = one_end(is_front)
    other = np.zeros_like(image)
    side = keypoints.copy()
    side[:, 0] = 0.5  # from the side, both ends are lines
    for seed in range(10):
        again, marked = repaint_ends(image, parts, side, other, np.random.default_rng(seed))
        assert (again == image).all()
        assert (marked == parts).all()


def test_what_is_given_is_not_changed() -> None:
    image, parts, keypoints = one_end(False)
    was = image.copy(), parts.copy(), keypoints.copy()
    repaint_ends(image, parts, keypoints, np.zeros_like(image), np.random.default_rng(3))
    for before, now in zip(was, (image, parts, keypoints), strict=True):
        assert (before == now).all()


def test_a_car_behind_the_camera_is_left_alone() -> None:
    image, parts, keypoints = one_end(False)
    keypoints = np.full_like(keypoints, np.nan)
    again, _ = repaint_ends(image, parts, keypoints, image, np.random.default_rng(0))
    assert (again == image).all()
