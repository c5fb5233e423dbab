"""Drivers' errors: as wide and as slow as people's, bounded, the same for the same seed."""

import numpy as np
import pytest

from mot_sim.simulation.traffic.highway import ROADS, HighwayTraffic
from mot_sim.simulation.traffic.highway.car import Car
from mot_sim.simulation.traffic.highway.driver import MAX_ASIDE_METRES, Driver
from mot_sim.simulation.traffic.highway.road import CarRoad


def errors(number: int, level: float = 1.0, seed: int = 4) -> np.ndarray:
    driver = Driver(seed, number, level)
    return np.array([driver.at(0.2 * step) for step in range(600)])


def test_drivers_drift_and_vary_their_speed_as_people_do() -> None:
    found = np.array([errors(number) for number in range(40)])
    assert 0.16 < found[:, :, 0].std() < 0.24  # O'Hanlon: .18 to .22 m
    assert 0.04 < np.log(found[:, :, 1]).std() < 0.08
    assert np.abs(found[:, :, 0]).max() <= MAX_ASIDE_METRES
    moved = np.abs(np.diff(found[:, :, 0], axis=1)) / 0.2
    assert moved.max() < 0.6  # m/s sideways


def test_some_drivers_are_calm_and_pull_away_and_slow_down_more_gently() -> None:
    brisk = np.array([Driver(4, number).briskness for number in range(60)])
    assert 0.55 <= brisk.min() < 0.62
    assert 0.93 < brisk.max() <= 1.0
    assert Driver(4, 3, level=0.0).briskness == 1.0
    calm = 3 + int(np.argmin(brisk[3:]))
    roads = CarRoad(ROADS["street"](), np.random.default_rng(0))
    gains = []
    for driver in (None, Driver(4, calm)):
        car = Car(roads, calm, (4.4, 1.45, 1.8), (0, 0), (0, 50.0), 2.0, 1.0, driver)
        gains.append(car.acceleration(car))
    assert gains[1] == pytest.approx(brisk[calm] * gains[0], rel=0.02)


def test_the_same_driver_errs_alike_another_one_differently_and_level_0_not() -> None:
    np.testing.assert_array_equal(errors(5), errors(5))
    assert not np.allclose(errors(5), errors(6))
    assert not np.allclose(errors(5), errors(5, seed=5))
    np.testing.assert_array_equal(errors(5, level=0.0), [[0.0, 1.0]] * 600)


def test_cars_follow_their_drivers_in_the_lane_and_our_body_moves() -> None:
    aside, tilts = {}, {}
    for level in (0.0, 1.0):
        traffic = HighwayTraffic(
            "street", cars=6, arrivals=0.0, wander=level, bumps=level, crashes="label"
        )
        traffic.reset_live(np.random.default_rng(3))
        states = [traffic.step() for _ in range(60)]
        tilts[level] = states[-1].tilt
        assert traffic._simulation is not None
        cars = traffic._simulation.road.vehicles
        aside[level] = np.array([car.aside for car in cars])
        wanted = np.array([car.drift for car in cars])
        np.testing.assert_allclose(aside[level], wanted, atol=0.25)
    assert np.abs(aside[0.0]).max() < 0.01
    assert np.abs(aside[1.0]).max() > 0.1
    assert tilts[0.0] is None
    assert np.abs(tilts[1.0]).max() > 0.0
