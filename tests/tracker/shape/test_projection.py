"""Pixels of a car's points and their derivatives."""

import numpy as np
import pytest

from tests.tracker.samples import AWAY, LEVEL, PITCHED
from tracker.shape.projection import SCALE, SHAPE, YAW, ObservedPoints, X, Z, residuals

P = LEVEL.K @ LEVEL.T_cam_road[:3]
EVERYTHING = np.arange(SHAPE + 2)


def random_sightings(n: int = 4, k: int = 5, camera=LEVEL) -> ObservedPoints:
    rng = np.random.default_rng(0)
    return ObservedPoints(
        rng.uniform(0, 600, (n, 2, k)),
        np.ones((n, 2, k)),
        rng.uniform(-2, 2, (n, 3, k)),
        rng.normal(0, 1, (n, 3, 2, k)),
        camera.K @ camera.T_cam_road[:3],
    )


def random_cars(n: int = 4) -> np.ndarray:
    rng = np.random.default_rng(1)
    cars = rng.normal(0.0, 0.3, (n, SHAPE + 2))
    cars[:, Z] = rng.uniform(10, 20, n)
    cars[:, YAW] = rng.uniform(-3, 3, n)
    return cars


def test_a_wheel_on_the_road_straight_ahead_appears_where_a_hand_puts_it() -> None:
    """1.3 m ahead of the middle of a car that drives away 18.7 m from us: 20 m, on the road."""
    mean = np.array([[[1.3], [0.0], [0.8]]])
    car = np.zeros((1, SHAPE))
    car[0, Z], car[0, YAW] = 18.7, AWAY
    given = ObservedPoints(np.zeros((1, 2, 1)), np.ones((1, 2, 1)), mean, np.zeros((1, 3, 0, 1)), P)
    off, _, depth = residuals(given, car, np.arange(SHAPE))
    assert depth[0, 0] == pytest.approx(20.0)
    # Its left is our left: x = -0.8 m.
    np.testing.assert_allclose(off[0, :, 0], [620 - 700 * 0.8 / 20, 187 + 710 * 1.65 / 20])


@pytest.mark.parametrize("camera", [LEVEL, PITCHED])
def test_the_derivatives_are_those_of_small_steps(camera) -> None:
    given, cars, step = random_sightings(camera=camera), random_cars(), 1e-6
    _, jacobian, _ = residuals(given, cars, EVERYTHING)
    for column in EVERYTHING.tolist():
        more, less = cars.copy(), cars.copy()
        more[:, column] += step
        less[:, column] -= step
        rise = residuals(given, more, EVERYTHING)[0] - residuals(given, less, EVERYTHING)[0]
        np.testing.assert_allclose(jacobian[:, column], rise / (2 * step), rtol=1e-4, atol=1e-4)


def test_unknowns_that_are_not_free_are_left_out() -> None:
    given, cars = random_sightings(), random_cars()
    _, everything, _ = residuals(given, cars, EVERYTHING)
    for free in (EVERYTHING[:SCALE], EVERYTHING[:SHAPE], EVERYTHING[EVERYTHING != SCALE]):
        np.testing.assert_array_equal(residuals(given, cars, free)[1], everything[:, free])


def test_a_point_behind_the_camera_gives_finite_numbers_and_a_negative_depth() -> None:
    cars = random_cars()
    cars[:, Z] = -10.0
    off, jacobian, depth = residuals(random_sightings(), cars, EVERYTHING)
    assert np.isfinite(off).all()
    assert np.isfinite(jacobian).all()
    assert (depth < 0.0).all()


def test_no_cars_have_no_residuals() -> None:
    given = random_sightings().rows(np.zeros(0, np.int64))
    off, jacobian, depth = residuals(given, np.zeros((0, SHAPE + 2)), EVERYTHING)
    assert (off.shape, jacobian.shape, depth.shape) == ((0, 2, 5), (0, 7, 2, 5), (0, 5))
    assert X == 0
