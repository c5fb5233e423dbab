"""What both ways of moving promise."""

from itertools import pairwise

import numpy as np
import pytest

from tests.tracker.samples import beliefs_at, locked
from tracker.beliefs import Beliefs
from tracker.dynamics import ConstantPosition, ConstantVelocity, Dynamics

every_dynamics = pytest.mark.parametrize(
    "dynamics", [ConstantPosition(), ConstantVelocity()], ids=repr
)


def three_cars() -> Beliefs:
    cars = beliefs_at((-4.0, 12.0), (0.0, 25.0), (6.0, 40.0))
    cars.velocity[:] = [[1.0, 2.0], [0.0, -5.0], [3.0, 0.0]]
    return cars


@every_dynamics
def test_it_satisfies_the_protocol(dynamics: Dynamics) -> None:
    assert isinstance(dynamics, Dynamics)


@every_dynamics
def test_no_time_changes_nothing(dynamics: Dynamics) -> None:
    before = three_cars()
    later, way = dynamics.predict(before, 0.0)
    np.testing.assert_array_equal(later.cov, before.cov)
    np.testing.assert_array_equal(later.cuboids.base, before.cuboids.base)
    assert way is None or not way.any()


@every_dynamics
def test_doubt_grows_with_time(dynamics: Dynamics) -> None:
    before = three_cars()
    growth = [dynamics.predict(before, dt)[0].cov - before.cov for dt in (0.1, 0.5, 2.0)]
    for less, more in pairwise(growth):
        assert np.linalg.eigvalsh(less[:, :2, :2]).min() > 0.0
        assert np.linalg.eigvalsh((more - less)[:, :2, :2]).min() > 0.0


@every_dynamics
def test_an_update_leaves_no_larger_covariance_than_the_detections(dynamics: Dynamics) -> None:
    seen = beliefs_at((-4.0, 12.5), (0.5, 25.0), (6.0, 41.0), std=0.2)
    now = dynamics.update(three_cars(), seen)
    left = np.linalg.eigvalsh((seen.cov - now.cov)[:, :2, :2])
    assert left.min() > -1e-12
    np.testing.assert_array_equal(now.boxes, seen.boxes)


@every_dynamics
def test_the_doubt_stays_symmetric_and_positive(dynamics: Dynamics) -> None:
    now = three_cars()
    for _ in range(100):
        now, _ = dynamics.predict(now, 0.1)
        now = dynamics.update(now, beliefs_at((-4.0, 12.0), (0.0, 25.0), (6.0, 40.0), std=0.3))
    np.testing.assert_allclose(now.cov, now.cov.transpose(0, 2, 1), atol=1e-12)
    assert np.linalg.eigvalsh(now.cov).min() > 0.0


@every_dynamics
def test_every_row_is_on_its_own(dynamics: Dynamics) -> None:
    order = np.array([2, 0])
    cars, seen = three_cars(), beliefs_at((-4.0, 12.5), (0.5, 25.0), (6.0, 41.0))
    for all_of, some_of in (
        (dynamics.predict(cars, 0.3)[0], dynamics.predict(cars.select(order), 0.3)[0]),
        (dynamics.update(cars, seen), dynamics.update(cars.select(order), seen.select(order))),
    ):
        np.testing.assert_allclose(some_of.cov, all_of.cov[order])
        np.testing.assert_allclose(some_of.cuboids.base, all_of.cuboids.base[order])


@every_dynamics
def test_inputs_are_left_as_they_were_and_nobody_moves_nowhere(dynamics: Dynamics) -> None:
    cars = locked(three_cars())
    dynamics.predict(cars, 0.1)
    dynamics.update(cars, locked(three_cars()))
    nobody, way = dynamics.predict(Beliefs.empty(), 0.1)
    assert len(nobody) == 0
    assert way is None or way.shape == (0, 2)
    assert len(dynamics.update(Beliefs.empty(), Beliefs.empty())) == 0
