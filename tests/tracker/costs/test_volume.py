"""3D-3D (eq. 4): the share of the new region that the expected one does not cover."""

import numpy as np
import pytest

from tests.tracker.samples import beliefs_at, pairing_of
from tracker.beliefs import Beliefs
from tracker.costs import Volume


def cost_of(expected: Beliefs, observed: Beliefs, sigmas: float = 1.0) -> float:
    costs = Volume()(pairing_of(expected, observed, sigmas))
    assert costs.shape == (1,)
    return float(costs[0])


def test_half_a_length_apart_costs_a_half() -> None:
    expected, observed = beliefs_at((0.0, 20.0), std=0.0), beliefs_at((0.0, 21.95), std=0.0)
    assert cost_of(expected, observed) == pytest.approx(0.5)


def test_half_a_width_apart_costs_a_half() -> None:
    expected, observed = beliefs_at((0.0, 20.0), std=0.0), beliefs_at((0.815, 20.0), std=0.0)
    assert cost_of(expected, observed) == pytest.approx(0.5)


def test_side_by_side_in_the_image_but_apart_on_the_road_costs_everything() -> None:
    near, far = beliefs_at((0.0, 15.0), std=0.0), beliefs_at((0.0, 30.0), std=0.0)
    assert cost_of(near, far) == pytest.approx(1.0)


def test_crossed_cars_share_a_square_of_their_width() -> None:
    along, across = beliefs_at((0.0, 20.0), std=0.0), beliefs_at((0.0, 20.0), std=0.0, yaw=0.0)
    assert cost_of(along, across) == pytest.approx(1.0 - 1.63 / 3.9)


def test_a_region_inside_the_expected_one_costs_nothing_but_not_the_other_way_round() -> None:
    sure, unsure = beliefs_at((0.0, 20.0), std=0.0), beliefs_at((0.0, 20.0), std=1.0)
    assert cost_of(unsure, sure) == pytest.approx(0.0)
    assert cost_of(sure, unsure) == pytest.approx(1.0 - 3.9 * 1.63 / ((3.9 + 2) * (1.63 + 2)))


def test_without_sigmas_only_the_cars_themselves_count() -> None:
    unsure = beliefs_at((0.0, 20.0), std=5.0)
    assert cost_of(unsure, beliefs_at((0.0, 21.95), std=5.0), sigmas=0.0) == pytest.approx(0.5)


def test_height_above_the_road_does_not_count() -> None:
    expected, observed = beliefs_at((0.0, 20.0), std=0.0), beliefs_at((0.0, 20.0), std=0.0)
    observed.cuboids.base[0, 1] = -0.5
    assert cost_of(expected, observed) == pytest.approx(0.0)
    assert np.isfinite(observed.boxes).all()
