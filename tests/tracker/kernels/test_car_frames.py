"""The car filter's steps of a frame equal their parts, bit by bit; cues equal plain NumPy."""

from collections.abc import Iterator

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from tests.tracker.kernels.plain_boxes import plain_project_boxes
from tests.tracker.kernels.plain_cues import plain_cues
from tests.tracker.kernels.plain_renewal import same_values
from tests.tracker.kernels.test_cars import cameras, cars, equal
from tracker.car_filter import (
    CarCues,
    CarFilter,
    CarStates,
    CueModel,
    RoadMemory,
    carried_boxes,
    expected_after,
)
from tracker.car_filter.edges import hidden_edges
from tracker.car_filter.estimates import estimate
from tracker.car_filter.modes import weighed
from tracker.car_filter.motion import RoadStep
from tracker.car_filter.road_memory import SeenBases, believed_heights
from tracker.car_filter.states import MIN_LOG_WEIGHT, normalised
from tracker.geometry import homogeneous, rotation_y
from tracker.types import Detections

HOW = CarFilter()


def sixteen(states: np.ndarray, covs: np.ndarray, rng: np.random.Generator) -> CarStates:
    """Hypotheses around each state, some of which are not followed."""
    means = states[:, None] + rng.normal(0.0, 0.05, (len(states), 16, 9))
    means[:, :8, 4] = 0.0
    weights = normalised(rng.choice([-0.5, -3.0, -12.0], (len(states), 16)))
    return CarStates(means, covs[:, None].repeat(16, 1), weights)


@given(cars(), cameras)
def test_what_is_seen_of_cars(some, camera) -> None:  # type: ignore[no-untyped-def]
    states, covs, rng = some
    before, n = sixteen(states, covs, rng), len(states)
    boxes = plain_project_boxes(states, camera)[0] + rng.normal(0.0, 3.0, (n, 4))
    boxes[:, 2:] = np.maximum(boxes[:, 2:], boxes[:, :2])
    found, memory = Detections(boxes, rng.uniform(0.0, 1.0, n)), RoadMemory(0.01, 1e-4)
    hidden, unbiased, variances, told = HOW._see(before, found, boxes, camera)
    np.testing.assert_array_equal(hidden, hidden_edges(boxes, boxes))
    edges = HOW.edges(boxes, found.scores, hidden)
    np.testing.assert_array_equal((unbiased, variances), edges)
    bases = SeenBases.of(unbiased, found.scores, hidden, camera)
    by_parts = HOW.road.update(memory, bases, believed_heights(before))
    by_parts = HOW.roughness.update(by_parts, bases, HOW.size[1])
    after = HOW.roughness.after(HOW.road.after(memory, *told[:2]), told[2])
    if n:
        np.testing.assert_array_equal(after[:2], by_parts[:2])
        assert after.flatness == by_parts.flatness


@given(cars(), cameras, st.sampled_from([0.5, 50.0]))
def test_what_is_believed_after_boxes(some, camera, noise) -> None:  # type: ignore[no-untyped-def]
    states, covs, rng = some
    before, n = sixteen(states, covs, rng), len(states)
    boxes = plain_project_boxes(states, camera)[0] + rng.normal(0.0, noise, (n, 4))
    variances, told = rng.uniform(0.5, 90.0, (n, 4)), rng.normal(size=(n, 16))
    after, parents, misfits = HOW._fit(before, boxes, variances, told, camera)
    fitted = HOW._update(before, boxes, variances, camera)
    weights = before.log_weights, fitted.fits, told, HOW.evidence, HOW.switch
    expected, expected_parents = weighed(fitted.states, *weights)
    same_values(after, expected)
    np.testing.assert_array_equal(parents, expected_parents)
    np.testing.assert_array_equal(misfits, fitted.misfits.min(axis=1, initial=np.inf))
    memory = RoadMemory(0.01, 1e-4, rng.uniform(0.0, 3.0, (5, 2)), 0.1 * np.eye(2))
    stated = HOW.stated(estimate(after, HOW.weights(after, memory)), memory)
    same_values(HOW.estimate(after, memory), stated)


@given(cars(), cameras)
def test_boxes_that_are_expected(some, camera) -> None:  # type: ignore[no-untyped-def]
    states, _, rng = some
    n = len(states)
    T_road = homogeneous(rotation_y(0.02), np.array([0.1, 0.0, -1.0]))
    step = RoadStep(T_road, 0.02, 0.1, (0.01, 0.02), 0.7, HOW._log_size, HOW._size_cov)
    boxes = plain_project_boxes(states, camera)[0] + rng.normal(0.0, 3.0, (n, 4))
    hits, predicted = rng.integers(1, 3, n), boxes + 1.0
    expected = carried_boxes(boxes, states, HOW.motion.moved(states, step), camera)
    expected = np.where((hits > 1)[:, None], expected, predicted)
    found = expected_after(boxes, predicted, hits, states, step, HOW.motion, camera)
    np.testing.assert_array_equal(found, expected)


def some_cues(rng: np.random.Generator, n: int) -> Iterator[CarCues]:
    """Yaws and sizes, with what is not known among them, and none at all."""
    for share in (0.0, 0.4, 1.0):
        unknown = rng.random((3, n)) < share
        yaw = np.where(unknown[0], np.nan, rng.uniform(-9.0, 9.0, n))
        var = np.where(unknown[1], np.nan, rng.uniform(0.0, 0.1, n))
        size = np.log([4.0, 1.5, 1.7]) + rng.normal(0.0, 0.2, (n, 3))
        yield CarCues(yaw, var, np.where(unknown[2][:, None], np.nan, size))


@given(cars(), st.booleans())
def test_what_is_believed_after_cues(some, is_first) -> None:  # type: ignore[no-untyped-def]
    states, covs, rng = some
    before, n = sixteen(states, covs + 1e-3 * np.eye(9), rng), len(states)
    followed, hidden = before.log_weights > MIN_LOG_WEIGHT, rng.random(n) < 0.5
    for cues in some_cues(rng, n):
        after, told = CueModel()(before, cues, hidden, is_first)
        rows, columns = followed.nonzero()
        given_cues = cues.take(rows), hidden[rows], is_first
        which = before.means[rows, columns], before.covs[rows, columns]
        expected = plain_cues(CueModel(), *which, *given_cues)
        equal(after.means[rows, columns], expected[0])
        equal(after.covs[rows, columns], expected[1])
        equal(told[rows, columns], expected[2])
        np.testing.assert_array_equal(after.means[~followed], before.means[~followed])
        np.testing.assert_array_equal(after.covs[~followed], before.covs[~followed])
        assert (told[~followed] == 0.0).all()
