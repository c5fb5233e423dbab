"""Point clouds seen twice: rotation and direction, with and without points of their own will."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy import ndarray as Array

from tracker.ego.relative import relative_motion, turn_alone
from tracker.ego.rotations import motion_transform
from tracker.geometry import transform

NOISE = 0.3 / 720.0


def seen(twist: Array, count: int = 200, seed: int = 0) -> tuple[Array, Array]:
    """Rays of a cloud in front of the camera, before and after a motion."""
    rng = np.random.default_rng(seed)
    depth = rng.uniform(5.0, 50.0, count)
    flat = rng.uniform(-0.6, 0.6, (count, 2)) * (1.0, 0.4)
    before = np.column_stack((flat, np.ones(count)))
    now = transform(motion_transform(twist), before * depth[:, None])
    return before, now / now[:, 2:]


def angle(a: Array, b: Array) -> float:
    """Degrees between two vectors."""
    cosine = a @ b / np.linalg.norm(a) / np.linalg.norm(b)
    return float(np.degrees(np.arccos(np.clip(cosine, -1.0, 1.0))))


TWISTS = st.tuples(
    *[st.floats(-0.3, 0.3), st.floats(-0.1, 0.1), st.floats(-1.5, -0.5)],
    *[st.floats(-0.05, 0.05)] * 3,
).map(np.array)


@given(TWISTS)
def test_a_motion_is_found_up_to_its_length(twist: Array) -> None:
    found = relative_motion(*seen(twist), NOISE)
    assert found is not None
    np.testing.assert_allclose(found.R, motion_transform(twist)[:3, :3], atol=1e-6)
    assert angle(found.direction, twist[:3]) < 0.01
    assert found.agreeing.all()
    np.testing.assert_allclose(found.tangents.T @ found.direction, 0.0, atol=1e-12)


def test_backwards_is_told_from_forwards() -> None:
    for ahead in (-1.0, 1.0):
        found = relative_motion(*seen(np.array([0.0, 0.0, ahead, 0.0, 0.0, 0.0])), NOISE)
        assert found is not None
        np.testing.assert_allclose(found.direction, [0.0, 0.0, ahead], atol=1e-5)


def test_points_that_go_their_own_way_do_not_count() -> None:
    twist = np.array([0.02, 0.0, -1.0, 0.0, 0.02, 0.0])
    before, now = seen(twist, 300)
    rng = np.random.default_rng(3)
    noisy = now + np.column_stack((rng.normal(0.0, NOISE, (300, 2)), np.zeros(300)))
    noisy[:100, :2] += rng.uniform(-0.1, 0.1, (100, 2))
    found = relative_motion(before, noisy, NOISE)
    assert found is not None
    assert found.agreeing[:100].mean() < 0.2
    assert found.agreeing[100:].mean() > 0.95
    assert angle(found.direction, twist[:3]) < 0.5
    # the covariance says how far off it is: one part in 10,000 of draws lies beyond 25.7
    missed = found.tangents.T @ (twist[:3] / np.linalg.norm(twist[:3]))
    assert missed @ np.linalg.solve(found.cov[:2, :2], missed) < 25.7


def test_a_turn_alone_leaves_nothing_over() -> None:
    twist = np.array([0.0, 0.0, 0.0, 0.01, -0.04, 0.005])
    R, missed = turn_alone(*seen(twist), NOISE)
    np.testing.assert_allclose(R, motion_transform(twist)[:3, :3], atol=1e-9)
    assert missed < 1e-9
    _, missed = turn_alone(*seen(twist + (0.0, 0.0, -1.0, 0.0, 0.0, 0.0)), NOISE)
    assert missed > 10.0 * NOISE


@pytest.mark.parametrize("count", [0, 1, 7])
def test_too_few_points_give_no_motion(count: int) -> None:
    assert relative_motion(*seen(np.array([0.0, 0, -1, 0, 0, 0]), count), NOISE) is None


def test_the_seed_of_opencv_changes_nothing() -> None:
    import cv2

    rays = seen(np.array([0.1, 0.0, -1.0, 0.0, 0.01, 0.0]))
    found = []
    for seed in (1, 2):
        cv2.setRNGSeed(seed)
        found.append(relative_motion(*rays, NOISE))
    assert found[0] is not None
    assert found[1] is not None
    assert found[0].R.tobytes() == found[1].R.tobytes()
    assert found[0].direction.tobytes() == found[1].direction.tobytes()
