"""Drives through a street: what the odometry sees, and what it makes of what it cannot see."""

import hashlib
import subprocess
import sys

import numpy as np
import pytest
from numpy import ndarray as Array

from tests.tracker.ego.corridor import (
    CAMERA,
    CURVE,
    NO_BOXES,
    STRAIGHT,
    filmed,
    misses,
)
from tracker.ego import VisualOdometry, prefetch
from tracker.ego.filter import Motion
from tracker.ego.odometry import without_boxes
from tracker.errors import BadConfig, BadDetections, TrackingError

BLACK = np.zeros((188, 620, 3), np.uint8)
NOISE = np.random.default_rng(8).integers(0, 256, (188, 620, 3), dtype=np.uint8)
BRAKING = ((0.9, 0.0), (0.9, 0.0), (0.87, 0.0), (0.84, 0.0), (0.81, 0.0))  # 3 m/s^2


def watched(images: list[Array | None], boxes: Array = NO_BOXES) -> list[Motion]:
    """The motions of a fresh odometry."""
    odometry = VisualOdometry(CAMERA)
    return [odometry.step(image, boxes) for image in images]


def digest(motions: list[Motion]) -> str:
    """One number for all bits of the motions."""
    parts = (part.tobytes() for motion in motions for part in motion if part is not None)
    return hashlib.sha256(b"".join(parts)).hexdigest()


@pytest.mark.parametrize("steps", [STRAIGHT, CURVE, BRAKING], ids=["straight", "curve", "braking"])
def test_a_drive_is_seen_as_it_was(steps: tuple[tuple[float, float], ...]) -> None:
    images, truth = filmed(steps)
    motions = watched(images)
    assert motions[0] == (None, None)
    errors = np.array([misses(T, true) for (T, _), true in zip(motions[1:], truth, strict=True)])
    rotation, direction, length = np.median(np.abs(errors), axis=0)
    assert rotation <= 0.05
    assert direction <= 1.0
    assert length <= 0.03
    assert np.abs(errors).max(axis=0) == pytest.approx(0.0, abs=1.5)
    assert np.abs(errors[:, 2]).max() <= 0.1


def test_the_covariance_covers_the_errors() -> None:
    images, truth = filmed(CURVE)
    for (T, cov), true in list(zip(watched(images)[1:], truth, strict=True)):
        assert T is not None
        assert cov is not None
        np.testing.assert_array_equal(cov, cov.T)
        assert np.linalg.eigvalsh(cov).min() > 0.0
        np.testing.assert_allclose(T[:3, :3] @ T[:3, :3].T, np.eye(3), atol=1e-12)
        missed = T @ np.linalg.inv(true)
        turned = [missed[2, 1], missed[0, 2], missed[1, 0]]
        twist = np.concatenate((missed[:3, 3], turned))
        assert twist @ np.linalg.solve(cov, twist) < 22.5  # chi squared of six, 99.9 %


def test_who_stands_does_not_move() -> None:
    images, _ = filmed(((0.0, 0.0),) * 3)
    for T, cov in watched(images)[1:]:
        assert T is not None
        assert np.linalg.norm(T[:3, 3]) < 0.005
        assert misses(T, np.eye(4))[0] < 0.01
        assert cov is not None
        assert np.sqrt(np.diag(cov)[:3]).max() < 0.03


def test_who_only_turns_does_not_move() -> None:
    images, truth = filmed(((0.0, 0.02),) * 4)
    for (T, _), true in zip(watched(images)[1:], truth, strict=True):
        assert T is not None
        assert np.linalg.norm(T[:3, 3]) < 0.01
        assert misses(T, true)[0] < 0.03


def test_a_car_that_stops_and_starts_is_followed() -> None:
    images, truth = filmed(((0.5, 0.0), (0.4, 0.0), (0.3, 0.0), (0.2, 0.0), (0.1, 0.0), (0.0, 0.0)))
    for (T, _), true in zip(watched(images)[1:], truth, strict=True):
        assert T is not None
        assert np.linalg.norm(T[:3, 3] - true[:3, 3]) < 0.06


@pytest.mark.parametrize("wild", [BLACK, NOISE, 255 - BLACK], ids=["black", "noise", "white"])
def test_wild_frames_never_give_a_wild_pose(wild: Array) -> None:
    images, truth = filmed(STRAIGHT)
    for place, count in ((4, 1), (3, 3)):
        shown = [*images[:place], *[wild] * count, *images[place + count :]]
        motions = watched(list(shown))
        for (T, _), true in zip(motions[1:], truth, strict=True):
            assert T is not None
            rotation, direction, length = misses(T, true)
            assert rotation < 0.3
            assert direction < 2.0
            assert abs(length) < 0.1
        before, during = motions[place - 1][1], motions[place][1]
        assert before is not None
        assert during is not None
        assert np.linalg.eigvalsh(during - before).min() > -1e-6  # it grows while it coasts
        assert np.trace(during) > np.trace(before)
        assert misses(motions[-1][0], truth[-1])[0] < 0.05  # and it comes back


def test_a_film_of_nothing_says_nothing() -> None:
    assert watched([BLACK] * 4) == [(None, None)] * 4
    rng = np.random.default_rng(9)
    noise = [rng.integers(0, 256, BLACK.shape, dtype=np.uint8) for _ in range(4)]
    assert watched(list(noise)) == [(None, None)] * 4


def test_the_grey_rest_of_a_broken_image_gives_no_wild_pose() -> None:
    images, truth = filmed(STRAIGHT)
    torn = images[4].copy()
    torn[90:] = 128
    motions = watched([*images[:4], torn, *images[5:]])
    for (T, _), true in zip(motions[1:], truth, strict=True):
        assert T is not None
        rotation, direction, length = misses(T, true)
        assert rotation < 0.3
        assert direction < 8.0  # 7.3 with OpenCV 4.11, which finds other corners than 5
        assert abs(length) < 0.15


def test_images_that_stop_coast_for_a_second_and_then_nobody_knows() -> None:
    images, truth = filmed(STRAIGHT)
    motions = watched([*images[:5], *[None] * 14])
    coasting = motions[5:14]
    spread = [np.trace(cov) for _, cov in motions[4:14] if cov is not None]
    assert len(spread) == 10
    assert (np.diff(spread) > 0.0).all()
    for T, _ in coasting:
        assert T is not None
        assert abs(misses(T, truth[3])[2]) < 0.1
    assert motions[16:] == [(None, None)] * 3


def test_images_that_come_back_are_seen_from_the_second_on() -> None:
    images, truth = filmed(STRAIGHT)
    odometry = VisualOdometry(CAMERA)
    for image in [*images[:3], None, *images[4:6]]:
        T, _ = odometry.step(image, NO_BOXES)
        if image is images[4]:
            assert odometry.measured is None  # nothing to compare it with
    assert odometry.measured is not None
    assert T is not None
    assert misses(T, truth[4])[0] < 0.05


def test_a_car_in_its_box_does_not_count() -> None:
    images, truth = filmed(STRAIGHT)
    box = np.array([[200.0, 60.0, 430.0, 160.0]])
    moving = []
    for number, image in enumerate(images):
        hidden = image.copy()
        hidden[60:161, 200:431] = np.roll(NOISE, 9 * number, axis=1)[60:161, 200:431] // 2 + 60
        moving.append(hidden)
    for (T, _), true in zip(watched(list(moving), box)[1:], truth, strict=True):
        assert T is not None
        assert misses(T, true)[0] < 0.1
        assert abs(misses(T, true)[2]) < 0.15


def test_boxes_outside_the_image_or_without_area_hide_nothing() -> None:
    images, _ = filmed(STRAIGHT)
    useless = np.array([[-90.0, -50.0, -20.0, -9.0], [700, 20, 900, 90], [300, 90, 300, 120]])
    assert digest(watched(list(images[:3]), useless)) == digest(watched(list(images[:3])))


def test_an_image_full_of_cars_coasts() -> None:
    images, _ = filmed(STRAIGHT)
    everything = np.array([[0.0, 0.0, 619.0, 187.0]])
    assert watched(list(images[:3]), everything) == [(None, None)] * 3


def test_the_same_images_give_the_same_bits_in_another_process() -> None:
    code = (
        "from tests.tracker.ego.corridor import STRAIGHT, filmed\n"
        "from tests.tracker.ego.test_odometry import digest, watched\n"
        "import cv2; cv2.setRNGSeed(77)\n"
        "print(digest(watched(list(filmed(STRAIGHT[:3])[0]))))"
    )
    other = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True
    ).stdout
    assert digest(watched(list(filmed(STRAIGHT)[0])[:4])) == other.strip()


def test_one_frame_ahead_on_a_thread_gives_the_same_bits() -> None:
    images, _ = filmed(CURVE)
    odometry = VisualOdometry(CAMERA)
    threaded = list(prefetch(odometry.step(image, NO_BOXES) for image in images))
    assert digest(threaded) == digest(watched(list(images)))


@pytest.mark.parametrize(
    ("image", "told"),
    [
        (BLACK[:, :, 0], r"shape \(188, 620\): give RGB"),
        (np.zeros((188, 620, 1), np.uint8), r"shape \(188, 620, 1\): give RGB"),
        (BLACK.astype(np.uint16), "an image of uint16: give 8 bits"),
        (BLACK.astype(float), "an image of float64: give 8 bits"),
        (BLACK[:, :600], "600x188 pixels, the camera's calibration is for 620x188"),
        (np.zeros((0, 0, 3), np.uint8), "0x0 pixels"),
    ],
)
def test_another_kind_of_image_is_refused(image: Array, told: str) -> None:
    with pytest.raises(TrackingError, match=told):
        VisualOdometry(CAMERA).step(image, NO_BOXES)


def test_bad_boxes_and_bad_times_are_refused() -> None:
    odometry = VisualOdometry(CAMERA)
    with pytest.raises(BadDetections, match=r"box 1 is not finite: \[1.0, nan, 3.0, 4.0\]"):
        odometry.step(BLACK, np.array([[1.0, 2, 3, 4], [1.0, np.nan, 3, 4]]))
    with pytest.raises(BadConfig, match="0 s between two images"):
        odometry.step(BLACK, NO_BOXES, 0.0)


def test_a_box_hides_its_pixels_and_three_around() -> None:
    free = without_boxes(np.array([[10.0, 20.0, 12.0, 21.0]]), (40, 30))
    assert free.shape == (30, 40)
    v, u = np.nonzero(~free)
    assert (u.min(), v.min(), u.max(), v.max()) == (7, 17, 15, 24)


def test_no_boxes_hide_nothing_and_a_box_beyond_the_edge_is_clipped() -> None:
    assert without_boxes(np.zeros((0, 4)), (40, 30)).all()
    assert not without_boxes(np.array([[-50.0, -50.0, 900.0, 900.0]]), (40, 30)).any()


def test_boxes_without_area_or_the_wrong_way_round_hide_nothing() -> None:
    boxes = np.array([[5.0, 5.0, 5.0, 20.0], [30.0, 20.0, 10.0, 5.0]])
    assert without_boxes(boxes, (40, 30)).all()
