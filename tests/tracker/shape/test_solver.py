"""Levenberg-Marquardt over many cars."""

import numpy as np
from scipy.optimize import least_squares

from tests.tracker.samples import LEVEL
from tests.tracker.shape.drawn import MODEL, draw, keypoints_of
from tracker.shape.projection import SCALE, SHAPE, YAW, ObservedPoints, X, Z
from tracker.shape.solver import inverses, solve

FREE = np.array([i for i in range(SHAPE + 5) if i != SCALE])
PRECISION = np.concatenate(([0.0, 400.0, 0.0, 0.0, 0.0], MODEL.std**-2))


def problem(n: int = 6, sigma: float = 2.0) -> tuple[ObservedPoints, np.ndarray]:
    """Noisy cars with all points seen, and starts nearby."""
    cars = draw(n, sigma=sigma, hide=False)
    given = ObservedPoints(
        cars.keypoints[:, :, :2].transpose(0, 2, 1),
        np.full((n, 2, 36), 0.25),
        np.tile(MODEL.basis.mean.T, (n, 1, 1)),
        np.tile(MODEL.basis.vectors.transpose(2, 0, 1), (n, 1, 1, 1)),
        LEVEL.K @ LEVEL.T_cam_road[:3],
    )
    start = np.zeros((n, SHAPE + 5))
    start[:, [X, Z]] = cars.base[:, ::2] * 1.05
    start[:, YAW] = cars.yaw + 0.1
    return given, start


def test_scipy_finds_no_lower_cost_from_where_it_ends() -> None:
    given, start = problem()
    found = solve(given, start, FREE, PRECISION, np.full((6, 36), 3.0), 50, 1e-12)
    for row in range(2):

        def off(free: np.ndarray, row: int = row) -> np.ndarray:
            base, yaw, shape = free[None, :3], free[None, 3], free[None, 4:]
            seen = keypoints_of(MODEL, shape, base, yaw)[0, :, :2].T - given.pixels[row]
            e = (0.25 * seen**2).sum(axis=0)
            robust = np.sqrt(9.0 * np.log1p(e / 9.0))
            return np.concatenate((robust, free * np.sqrt(PRECISION[FREE])))

        theirs = least_squares(off, found.cars[row, FREE], max_nfev=20)
        np.testing.assert_allclose(found.cost[row], 0.5 * (off(found.cars[row, FREE]) ** 2).sum())
        np.testing.assert_allclose(found.cost[row], theirs.cost, rtol=1e-6)


def test_more_steps_never_cost_more_and_what_is_not_free_stays() -> None:
    given, start = problem()
    kernel, before = np.full((6, 36), 4.0), np.full(6, np.inf)
    for steps in (0, 1, 2, 4, 8, 30):
        found = solve(given, start, FREE, PRECISION, kernel, steps)
        assert (found.cost <= before).all()
        before = found.cost
    pose = solve(given, start, FREE[:4], PRECISION, kernel, 20)
    np.testing.assert_array_equal(pose.cars[:, SHAPE:], 0.0)
    assert (before < pose.cost).all()


def test_inputs_stay_as_they_were() -> None:
    given, start = problem()
    copies = [part.copy() for part in (given.pixels, given.weights, given.mean, start)]
    solve(given, start, FREE, PRECISION, np.full((6, 36), 4.0), 5)
    for part, copy in zip((given.pixels, given.weights, given.mean, start), copies, strict=True):
        np.testing.assert_array_equal(part, copy)


def test_a_car_behind_the_camera_costs_infinity() -> None:
    given, start = problem()
    start[:, Z] = -20.0
    found = solve(given, start, FREE, PRECISION, np.full((6, 36), 4.0), 0)
    assert (found.cost == np.inf).all()


def test_no_cars_are_solved_at_once() -> None:
    given, start = problem()
    nobody = np.zeros(0, np.int64)
    found = solve(given.rows(nobody), start[:0], FREE, PRECISION, np.zeros((0, 36)), 5)
    assert found.cars.shape == (0, SHAPE + 5)


def test_inverses_are_inverses_and_huge_where_nothing_is_known() -> None:
    rng = np.random.default_rng(0)
    A = rng.normal(size=(5, 4, 4))
    normal = A @ A.transpose(0, 2, 1) + np.eye(4)
    np.testing.assert_allclose(inverses(normal) @ normal, np.tile(np.eye(4), (5, 1, 1)), atol=1e-8)
    assert (np.diagonal(inverses(np.zeros((1, 4, 4)))[0]) > 1e6).all()
