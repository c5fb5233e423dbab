"""Boxes go where the cars behind them go."""

import numpy as np

from tests.tracker.samples import LEVEL
from tracker.car_filter import carried_boxes, project_boxes
from tracker.car_filter.projection import expected_boxes

CAR = np.array([[1.0, 0.0, 20.0, -0.5 * np.pi, 5.0, *np.log([3.9, 1.5, 1.6]), 0.0]])


def test_a_box_that_is_the_cars_is_the_cars_later() -> None:
    later = CAR + np.array([0.5, 0.0, -6.0, 0.3, 0.0, 0.0, 0.0, 0.0, 0.0])
    now, then = (project_boxes(car, LEVEL)[0] for car in (CAR, later))
    np.testing.assert_allclose(carried_boxes(now, CAR, later, LEVEL), then)


def test_a_box_that_is_off_stays_off_in_proportion() -> None:
    """Twice as near is twice as large, and twice as far off the car."""
    now, _ = project_boxes(CAR, LEVEL)
    nearer = CAR.copy()
    nearer[:, 2] = 10.0
    grown = carried_boxes(now + 3.0, CAR, nearer, LEVEL)
    there, _ = project_boxes(nearer, LEVEL)
    growth = (there[:, 2:] - there[:, :2]) / (now[:, 2:] - now[:, :2])
    np.testing.assert_allclose(grown[:, 2:] - grown[:, :2], there[:, 2:] - there[:, :2])
    np.testing.assert_allclose(
        grown[:, :2] + grown[:, 2:], there[:, :2] + there[:, 2:] + 6.0 * growth
    )


def test_boxes_without_derivatives_are_those_with() -> None:
    cars = np.repeat(CAR, 3, 0)
    cars[:, 0], cars[:, 2] = [0.0, -15.0, 4.0], [20.0, 20.0, 3.0]  # the last two are cut
    np.testing.assert_array_equal(expected_boxes(cars, LEVEL), project_boxes(cars, LEVEL)[0])
