"""The smoother: straight paths come back, gaps lie between their ends, doubt shrinks."""

import numpy as np
import pytest

from tracker.beliefs import Beliefs
from tracker.dynamics import ConstantVelocity
from tracker.smoothing import SPEED_STD, smoothed
from tracker.types import Cuboids

TIMES = np.arange(20) / 10.0
COV = np.diag([0.04, 0.25])


def test_a_straight_path_comes_back_also_where_nothing_was_seen() -> None:
    path = np.stack((1.0 + 2.0 * TIMES, 30.0 - 5.0 * TIMES), axis=1)
    seen = np.array([0, 1, 2, 3, 12, 13, 19])
    result = smoothed(TIMES, seen, path[seen], np.tile(COV * 1e-6, (7, 1, 1)), 2.0)
    np.testing.assert_allclose(result.states[:, :2], path, atol=1e-3)
    np.testing.assert_allclose(result.states[:, 2:], [[2.0, -5.0]] * 20, atol=1e-2)


def test_all_sightings_tell_more_than_those_before() -> None:
    """The last state is the filter's; at all others the smoother is surer than the measurement."""
    rng = np.random.default_rng(1)
    places = np.stack((TIMES * 3.0, 20.0 + TIMES), axis=1)
    noisy = places + rng.normal(size=places.shape) * np.sqrt(np.diag(COV))
    result = smoothed(TIMES, np.arange(20), noisy, np.tile(COV, (20, 1, 1)), 0.5)
    assert np.square(result.states[:, :2] - places).mean() < 0.5 * np.square(noisy - places).mean()
    assert (np.linalg.eigvalsh(COV - result.covs[:, :2, :2]) > 0.0).all()


def test_its_last_state_is_that_of_the_trackers_own_filter() -> None:
    dynamics, rng = ConstantVelocity(2.0), np.random.default_rng(2)
    places = np.cumsum(rng.normal(size=(20, 2)), axis=0)

    def belief(place: np.ndarray) -> Beliefs:
        cov = np.zeros((1, 4, 4))
        cov[0, :2, :2], cov[0, 2:, 2:] = COV, np.eye(2) * SPEED_STD**2
        base = np.array([[place[0], 0.0, place[1]]])
        cuboids = Cuboids(base, np.zeros(1), np.ones((1, 3)))
        return Beliefs(cuboids, np.zeros((1, 2)), cov, np.zeros((1, 4)))

    state = belief(places[0])
    for place in places[1:]:
        later, moved = dynamics.predict(state, 0.1)
        base = later.cuboids.base.copy()
        base[:, ::2] += moved
        moved_cuboids = Cuboids(base, later.cuboids.yaw, later.cuboids.size)
        expected = Beliefs(moved_cuboids, later.velocity, later.cov, later.boxes)
        state = dynamics.update(expected, belief(place))
    result = smoothed(TIMES, np.arange(20), places, np.tile(COV, (20, 1, 1)), 2.0)
    np.testing.assert_allclose(result.states[-1, :2], state.cuboids.base[0, ::2], atol=1e-9)
    np.testing.assert_allclose(result.states[-1, 2:], state.velocity[0], atol=1e-9)
    np.testing.assert_allclose(result.covs[-1], state.cov[0], atol=1e-9)


@pytest.mark.parametrize("count", [1, 2])
def test_few_sightings_are_enough(count: int) -> None:
    path = smoothed(
        TIMES[:count], np.arange(count), np.ones((count, 2)), np.tile(COV, (count, 1, 1)), 2.0
    )
    np.testing.assert_allclose(path.states[:, :2], 1.0)
