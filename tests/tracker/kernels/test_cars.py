"""Kernels of the car filter equal plain NumPy."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.tracker.kernels.plain_boxes import plain_project_boxes
from tests.tracker.kernels.plain_cars import (
    plain_ego_motion_cov,
    plain_motion,
    plain_moved,
    plain_update,
)
from tests.tracker.samples import LEVEL, PITCHED
from tracker.car_filter import CarFilter, CarMotion, project_boxes
from tracker.car_filter.motion import RoadStep, add_ego_motion_cov
from tracker.car_filter.projection import expected_boxes
from tracker.geometry import homogeneous, rotation_y

cameras = st.sampled_from([LEVEL, PITCHED])
SIZE_COV = np.diag([0.01, 0.02, 0.03])


@st.composite
def cars(draw: st.DrawFn) -> tuple[np.ndarray, np.ndarray, np.random.Generator]:
    """States anywhere: far, beside and behind the camera, huge and tiny ones; covariances."""
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    count, reach = draw(st.integers(0, 12)), draw(st.sampled_from([1e-3, 5.0, 50.0, 1e4]))
    states = np.zeros((count, 9))
    states[:, :3] = rng.uniform(-reach, reach, (count, 3)) * [1.0, 0.05, 1.0]
    states[:, 2] += draw(st.sampled_from([0.0, 8.0, 40.0]))
    states[:, 3] = rng.choice([0.0, np.pi / 2, -np.pi, 0.3, 7.0], count)
    states[:, 4] = np.abs(rng.normal(0.0, 10.0, count)) * rng.integers(0, 2, count)
    states[:, 5:8] = np.log([4.0, 1.5, 1.6]) + rng.normal(0.0, 0.2, (count, 3))
    states[:, 8] = rng.normal(0.0, 0.1, count)
    roots = rng.normal(0.0, 0.1, (count, 9, 9)) * rng.uniform(0.0, 3.0, (count, 1, 1))
    return states, roots @ roots.transpose(0, 2, 1), rng


def equal(found: np.ndarray, expected: np.ndarray) -> None:
    """But for rounding, at the scale of each row."""
    scale = 1.0 + np.abs(expected).max(initial=0.0, axis=-1, keepdims=True)
    np.testing.assert_allclose(found / scale, expected / scale, rtol=1e-9, atol=1e-11)


@given(cars(), cameras)
def test_boxes_and_their_derivatives(some, camera) -> None:  # type: ignore[no-untyped-def]
    boxes, jacobian = project_boxes(some[0], camera)
    expected, derivatives = plain_project_boxes(some[0], camera)
    equal(boxes, expected)
    equal(jacobian, derivatives)
    np.testing.assert_array_equal(expected_boxes(some[0], camera), boxes)


@given(cars(), st.sampled_from([0.0, 0.1, 2.0]), st.floats(-0.1, 0.1), cameras)
def test_motion(some, dt, turn, camera) -> None:  # type: ignore[no-untyped-def]
    states, covs, rng = some
    T_road = homogeneous(rotation_y(turn), np.array([0.1, 0.02, -1.0]))
    sizes = np.log([4.0, 1.5, 1.6]), SIZE_COV
    step = RoadStep(T_road, turn, dt, (0.01, 0.02), 0.7, *sizes)
    motion, moving = CarMotion(), rng.random(len(states)) < 0.5
    later, later_covs = motion(states, covs, moving, step)
    expected, expected_covs = plain_motion(motion, states, covs, moving, step)
    equal(later, expected)
    equal(later_covs, expected_covs)
    equal(motion.moved(states, step), plain_moved(motion, states, step))
    root = rng.normal(0.0, 0.01, (6, 6))
    cov = root @ root.T
    expected_covs[:, :3, :3] += plain_ego_motion_cov(later[:, :3], cov, camera)
    expected_covs[:, 3, 3] += cov[4, 4]
    add_ego_motion_cov(later, later_covs, cov, camera)
    equal(later_covs, expected_covs)


@pytest.mark.parametrize("is_first", [False, True])
@given(some=cars(), camera=cameras, noise=st.sampled_from([0.1, 5.0, 1e4]))
def test_updates(some, camera, noise, is_first) -> None:  # type: ignore[no-untyped-def]
    states, covs, rng = some
    boxes = plain_project_boxes(states, camera)[0] + rng.normal(0.0, noise, (len(states), 4))
    variances = rng.uniform(0.5, 100.0, (len(states), 4))
    linear = states + rng.normal(0.0, 0.01, states.shape) if is_first else None
    found = CarFilter()._update(states, covs, boxes, variances, camera, linear)
    expected = plain_update(CarFilter(), states, covs, boxes, variances, camera, linear)
    for one, other in zip(found, expected, strict=True):
        scale = 1.0 + np.abs(other).max(initial=0.0)
        np.testing.assert_allclose(one / scale, other / scale, rtol=1e-7, atol=1e-8)
