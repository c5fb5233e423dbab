"""How unseen cars move; the batched Kalman filter equals filterpy's."""

import numpy as np
import pytest
from filterpy.common import Q_discrete_white_noise
from filterpy.kalman import KalmanFilter

from tests.tracker.samples import beliefs_at
from tracker.beliefs import Beliefs
from tracker.dynamics import ConstantPosition, ConstantVelocity
from tracker.types import Cuboids

PLACES = ((-4.0, 12.0), (0.0, 25.0), (6.0, 40.0))


def moved(beliefs: Beliefs, way: np.ndarray) -> Beliefs:
    """The beliefs after going that way, seen by a camera that stands still."""
    base = beliefs.cuboids.base.copy()
    base[:, ::2] += way
    cuboids = Cuboids(base, beliefs.cuboids.yaw, beliefs.cuboids.size)
    return Beliefs(cuboids, beliefs.velocity, beliefs.cov, beliefs.boxes)


def random_covariances(n: int, rng: np.random.Generator) -> np.ndarray:
    A = rng.normal(size=(n, 2, 2))
    return A @ A.transpose(0, 2, 1) + 0.2 * np.eye(2)


def sighting(like: Beliefs, rng: np.random.Generator) -> Beliefs:
    """Somewhere near, with a random covariance."""
    seen = moved(like, rng.normal(size=(len(like), 2)))
    cov = np.zeros_like(like.cov)
    cov[:, :2, :2] = random_covariances(len(like), rng)
    return Beliefs(seen.cuboids, np.zeros((len(like), 2)), cov, like.boxes)


def filters_of(beliefs: Beliefs) -> list[KalmanFilter]:
    """filterpy's filters with the same states."""
    filters = []
    for base, velocity, cov in zip(
        beliefs.cuboids.base, beliefs.velocity, beliefs.cov, strict=True
    ):
        kalman = KalmanFilter(dim_x=4, dim_z=2)
        kalman.x = np.concatenate((base[::2], velocity))[:, None]
        kalman.P, kalman.H = cov.copy(), np.eye(2, 4)
        filters.append(kalman)
    return filters


def test_many_objects_over_fifty_steps_equal_filterpys_filters() -> None:
    rng, ours = np.random.default_rng(5), beliefs_at(*PLACES)
    ours.velocity[:] = rng.normal(0.0, 5.0, (3, 2))
    theirs, dynamics = filters_of(ours), ConstantVelocity(acceleration_std=3.0)
    for _ in range(50):
        dt = float(rng.choice([0.1, 0.05, 0.3]))
        later, way = dynamics.predict(ours, dt)
        expected = moved(later, way)
        seen = sighting(expected, rng)
        ours = dynamics.update(expected, seen)
        for row, kalman in enumerate(theirs):
            kalman.F = np.eye(4) + dt * np.eye(4, k=2)
            kalman.Q = Q_discrete_white_noise(2, dt, 9.0, block_size=2, order_by_dim=False)
            kalman.predict()
            kalman.update(seen.cuboids.base[row, ::2], R=seen.cov[row, :2, :2])
            state = np.concatenate((ours.cuboids.base[row, ::2], ours.velocity[row]))
            np.testing.assert_allclose(state, kalman.x[:, 0], rtol=1e-9, atol=1e-9)
            np.testing.assert_allclose(ours.cov[row], kalman.P, rtol=1e-9, atol=1e-9)


def test_one_prediction_by_hand() -> None:
    belief = beliefs_at((0.0, 20.0))
    belief.velocity[0] = [1.0, -10.0]
    belief.cov[0] = np.diag([1.0, 1.0, 4.0, 4.0])
    later, way = ConstantVelocity(acceleration_std=2.0).predict(belief, 0.5)
    np.testing.assert_allclose(way, [[0.5, -5.0]])
    position = 1.0 + 4.0 * 0.5**2 + 4.0 * 0.5**4 / 4
    velocity = 4.0 + 4.0 * 0.5**2
    both = 4.0 * 0.5 + 4.0 * 0.5**3 / 2
    np.testing.assert_allclose(np.diag(later.cov[0]), [position, position, velocity, velocity])
    assert later.cov[0, 0, 2] == pytest.approx(both)
    assert later.cov[0, 1, 3] == pytest.approx(both)
    assert later.cov[0, 0, 1] == later.cov[0, 0, 3] == 0.0


def test_an_update_takes_yaw_size_box_and_height_from_what_is_seen() -> None:
    expected, seen = beliefs_at((0.0, 20.0)), beliefs_at((1.0, 21.0), yaw=0.3)
    seen.cuboids.base[0, 1] = -0.2
    seen.cuboids.size[0] = [5.0, 2.0, 1.8]
    now = ConstantVelocity().update(expected, seen)
    assert now.cuboids.yaw[0] == 0.3
    assert now.cuboids.base[0, 1] == -0.2
    np.testing.assert_array_equal(now.cuboids.size, seen.cuboids.size)
    np.testing.assert_array_equal(now.boxes, seen.boxes)
    np.testing.assert_allclose(now.cuboids.base[0, ::2], [0.5, 20.5])  # equal doubts: the middle


def test_covariances_stay_symmetric_and_positive_over_five_hundred_steps() -> None:
    rng, ours, dynamics = np.random.default_rng(1), beliefs_at(*PLACES), ConstantVelocity()
    for step in range(500):
        later, _ = dynamics.predict(ours, 0.1 if step % 7 else 0.0)
        ours = dynamics.update(later, sighting(later, rng))
    np.testing.assert_allclose(ours.cov, ours.cov.transpose(0, 2, 1), rtol=1e-9, atol=1e-12)
    assert np.linalg.eigvalsh(ours.cov).min() > 0.0


def test_still_cars_stay_where_they_were_last_seen_with_growing_doubt() -> None:
    before, still = beliefs_at(*PLACES), ConstantPosition(speed_std=(1.0, 5.0))
    later, way = still.predict(before, 0.2)
    assert way is None
    np.testing.assert_array_equal(later.cuboids.base, before.cuboids.base)
    added = (later.cov - before.cov)[0]
    np.testing.assert_allclose(added, np.diag([0.04, 1.0, 0.0, 0.0]), atol=1e-12)


def test_still_believes_exactly_what_it_sees() -> None:
    seen = beliefs_at((1.0, 21.0))
    assert ConstantPosition().update(beliefs_at((0.0, 20.0)), seen) is seen
