"""The filter over the camera's motion: what it believes, and how it coasts."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from tests.tracker.ego.corridor import CAMERA
from tracker.ego import Coasting, MotionMeasurement
from tracker.ego.filter import CameraVelocity
from tracker.errors import BadConfig

AHEAD = np.array([0.0, 0.0, -1.0, 0.0, 0.0, 0.0])
SURE = np.diag([1e-4, 1e-4, 4e-4, 1e-7, 1e-7, 1e-7])
COASTING = Coasting()


def after(*twists: np.ndarray | None) -> tuple[CameraVelocity | None, tuple]:
    """What is known after these measurements, a tenth of a second apart."""
    velocity, motion = None, (None, None)
    for twist in twists:
        measured = None if twist is None else MotionMeasurement(twist, SURE)
        velocity, motion = COASTING.step(velocity, measured, CAMERA, 0.1)
    return velocity, motion


def test_the_first_measurement_is_taken_nearly_as_it_is() -> None:
    velocity, (T, cov) = after(AHEAD)
    assert velocity is not None
    np.testing.assert_allclose(T[:3, 3], AHEAD[:3], atol=0.002)
    np.testing.assert_allclose(velocity.mean, AHEAD * 10.0, atol=0.02)
    assert np.sqrt(cov[2, 2]) == pytest.approx(np.hypot(0.02, 0.02), rel=0.01)  # and the scale


def test_nothing_seen_is_nothing_known() -> None:
    assert after(None, None) == (None, (None, None))


def test_without_measurements_it_goes_on_alike_and_knows_less_and_less() -> None:
    covs = []
    for count in range(1, 9):
        _, (T, cov) = after(AHEAD, *[None] * count)
        np.testing.assert_allclose(T[:3, 3], AHEAD[:3], atol=0.002)
        covs.append(cov)
    assert all(np.linalg.eigvalsh(b - a).min() > -1e-12 for a, b in pairwise(covs))
    velocity, motion = after(AHEAD, *[None] * 11)
    assert velocity is None
    assert motion == (None, None)


def test_a_jump_is_left_out_and_believed_when_it_stays() -> None:
    jump = AHEAD + (0.0, 0.0, -3.0, 0.0, 0.1, 0.0)
    _, (T, _) = after(AHEAD, AHEAD, jump)
    np.testing.assert_allclose(T[:3, 3], AHEAD[:3], atol=0.01)
    _, (T, _) = after(AHEAD, AHEAD, *[jump] * 8)
    np.testing.assert_allclose(T[:3, 3], jump[:3], atol=0.05)


@given(st.lists(arrays(float, 6, elements=st.floats(-50.0, 50.0)), max_size=6))
def test_no_motion_is_wilder_than_a_car(twists: list[np.ndarray]) -> None:
    velocity, motions = None, []
    for twist in [AHEAD, *twists]:
        velocity, motion = COASTING.step(velocity, MotionMeasurement(twist, SURE), CAMERA, 0.1)
        motions.append(motion)
    for T, cov in motions:
        if T is None:
            continue
        assert np.linalg.norm(T[:3, 3]) <= 6.0 + 1e-9
        assert (np.trace(T[:3, :3]) - 1.0) / 2.0 >= np.cos(0.15) - 1e-9
        assert np.linalg.eigvalsh(cov).min() > 0.0


@pytest.mark.parametrize("value", [np.nan, np.inf, 700.0])
def test_measurements_that_cannot_be_are_left_out(value: float) -> None:
    bad = AHEAD.copy()
    bad[0] = value
    assert after(bad) == (None, (None, None))


def test_parameters_that_cannot_be_are_refused() -> None:
    with pytest.raises(BadConfig, match="give more than 0"):
        Coasting(patience=0.0)
