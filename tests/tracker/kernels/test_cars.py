"""Kernels of the car filter equal plain NumPy."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.tracker.kernels.plain_boxes import plain_project_boxes
from tests.tracker.kernels.plain_cars import (
    plain_carried,
    plain_ego_motion_cov,
    plain_motion,
    plain_moved,
    plain_update,
)
from tests.tracker.kernels.plain_existence import plain_gap_features
from tests.tracker.samples import LEVEL, PITCHED
from tracker.beliefs import Beliefs
from tracker.car_filter import CarFilter, CarMotion, CarStates, carried_boxes, project_boxes
from tracker.car_filter.motion import RoadStep
from tracker.car_filter.projection import expected_boxes
from tracker.car_filter.states import MIN_LOG_WEIGHT
from tracker.gap_rows import gap_features
from tracker.geometry import homogeneous, rotation_y
from tracker.lifecycle import ActiveTracks
from tracker.types import CarEstimates, Cuboids

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


def twice(states: np.ndarray, covs: np.ndarray, rng: np.random.Generator) -> CarStates:
    """Two equal hypotheses of each car, parked and moving, some of which are not followed."""
    log_weights = rng.choice([-0.5, -8.0, MIN_LOG_WEIGHT, -20.0, -np.inf], (len(states), 2))
    return CarStates(states[:, None].repeat(2, 1), covs[:, None].repeat(2, 1), log_weights)


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
    root = rng.normal(0.0, 0.01, (6, 6))
    ego, moves = root @ root.T, [False, True]
    T_road = homogeneous(rotation_y(turn), np.array([0.1, 0.02, -1.0]))
    sizes = np.log([4.0, 1.5, 1.6]), SIZE_COV
    step = RoadStep(T_road, turn, dt, (0.01, 0.02), 0.7, *sizes)
    motion, before = CarMotion(), twice(states, covs, rng)
    later = motion(before, step, ego, camera)
    for which, is_moving in enumerate(moves):
        mask = np.full(len(states), is_moving)
        expected, expected_covs = plain_motion(motion, states, covs, mask, step)
        expected_covs[:, :3, :3] += plain_ego_motion_cov(expected[:, :3], ego, camera)
        expected_covs[:, 3, 3] += ego[4, 4]
        followed = before.log_weights[:, which] > MIN_LOG_WEIGHT
        equal(later.means[followed, which], expected[followed])
        equal(later.covs[followed, which], expected_covs[followed])
        np.testing.assert_array_equal(later.means[~followed, which], states[~followed])
        np.testing.assert_array_equal(later.covs[~followed, which], covs[~followed])
    equal(motion.moved(states, step), plain_moved(motion, states, step))


@pytest.mark.parametrize("is_first", [False, True])
@given(some=cars(), camera=cameras, noise=st.sampled_from([0.1, 5.0, 1e4]))
def test_updates(some, camera, noise, is_first) -> None:  # type: ignore[no-untyped-def]
    states, covs, rng = some
    boxes = plain_project_boxes(states, camera)[0] + rng.normal(0.0, noise, (len(states), 4))
    variances = rng.uniform(0.5, 100.0, (len(states), 4))
    linear = states + rng.normal(0.0, 0.01, states.shape) if is_first else None
    before = twice(states, covs, rng)
    at = None if linear is None else linear[:, None].repeat(2, 1)
    (after, fits, misfits) = CarFilter()._update(before, boxes, variances, camera, at)
    expected = plain_update(CarFilter(), states, covs, boxes, variances, camera, linear)
    for which in range(2):
        is_followed = before.log_weights[:, which] > MIN_LOG_WEIGHT
        found = (column[:, which] for column in (after.means, after.covs, fits, misfits))
        for one, other, unchanged in zip(found, expected, (states, covs, 0.0, np.inf), strict=True):
            scale, one_followed = 1.0 + np.abs(other).max(initial=0.0), one[is_followed]
            same = {"rtol": 1e-7, "atol": 1e-8}
            np.testing.assert_allclose(one_followed / scale, other[is_followed] / scale, **same)
            stay = np.broadcast_to(unchanged, one.shape)[~is_followed]
            np.testing.assert_array_equal(one[~is_followed], stay)


@given(cars(), st.sampled_from([0.1, 5.0]), cameras)
def test_boxes_that_cars_carry_along(some, step, camera) -> None:  # type: ignore[no-untyped-def]
    before, _, rng = some
    after = before + rng.normal(0.0, step, before.shape) * [1.0, 0.1, 1.0, 0.1, 0, 0, 0, 0, 0]
    boxes = plain_project_boxes(before, camera)[0] + rng.normal(0.0, 3.0, (len(before), 4))
    equal(carried_boxes(boxes, before, after, camera), plain_carried(boxes, before, after, camera))


@given(cars(), cameras)
def test_what_tells_of_rows_in_gaps(some, camera) -> None:  # type: ignore[no-untyped-def]
    states, covs, rng = some
    count = len(states)
    boxes = expected_boxes(states, camera) + rng.normal(0.0, 5.0, (count, 4))
    cuboids = Cuboids(states[:, :3], states[:, 3], np.ones((count, 3)))
    beliefs = Beliefs(cuboids, np.zeros((count, 2)), np.zeros((count, 4, 4)), boxes)
    likely = rng.choice([0.0, 1e-9, 0.5, 0.999], count)
    tracks = ActiveTracks.born(beliefs, np.ones(count), likely, 0)
    tracks = tracks.replaced(hits=rng.integers(1, 90, count))
    estimates = CarEstimates(states, covs, np.ones(count))
    equal(gap_features(tracks, estimates, camera), plain_gap_features(tracks, estimates, camera))
