"""3D-2D (eq. 3): the share of a box outside the search area."""

import numpy as np
import pytest

from tests.tracker.samples import AWAY, CAR, beliefs_at, pairing_of
from tracker.beliefs import Beliefs
from tracker.costs import Reprojection

# A car at z = 20 m without doubt: its near face at 18.05 m, its far face at 21.95 m.
NEAR_FACE, FAR_FACE = 20.0 - 0.5 * 3.9, 20.0 + 0.5 * 3.9
AREA = np.array([
    620 - 700 * 0.815 / NEAR_FACE, 187 + 710 * 0.15 / FAR_FACE,
    620 + 700 * 0.815 / NEAR_FACE, 187 + 710 * 1.65 / NEAR_FACE,
])  # fmt: skip
WIDTH = AREA[2] - AREA[0]


def seen_as(box: np.ndarray) -> Beliefs:
    observed = beliefs_at((0.0, 20.0))
    observed.boxes[0] = box
    return observed


def cost_of(box: np.ndarray, std: float = 0.0) -> np.ndarray:
    return Reprojection()(pairing_of(beliefs_at((0.0, 20.0), std=std), seen_as(box)))


def test_the_search_area_is_the_projection_of_the_region() -> None:
    pairing = pairing_of(beliefs_at((0.0, 20.0), std=0.0), seen_as(AREA))
    np.testing.assert_allclose(pairing.search_areas, [AREA], atol=1e-9)
    np.testing.assert_array_equal(pairing.expected.cuboids.size, [CAR])
    assert pairing.expected.cuboids.yaw[0] == AWAY


@pytest.mark.parametrize(("share", "cost"), [(0.0, 0.0), (0.25, 0.25), (0.5, 0.5), (0.9, 0.9)])
def test_a_box_that_sticks_out_of_the_area_by_a_share_costs_that_share(share, cost) -> None:
    shifted = AREA + np.array([1.0, 0.0, 1.0, 0.0]) * share * WIDTH
    assert cost_of(shifted) == pytest.approx([cost], abs=1e-9)


def test_a_box_inside_the_area_costs_nothing_wherever_it_is() -> None:
    for shift in (-5.0, 0.0, 5.0):
        inner = AREA + np.array([10.0, 10.0, -10.0, -10.0]) + shift
        assert cost_of(inner).tolist() == [0.0]


def test_a_box_around_the_area_costs_the_share_that_is_not_covered() -> None:
    middle, half = 0.5 * (AREA[:2] + AREA[2:]), 0.5 * (AREA[2:] - AREA[:2])
    twice = np.concatenate((middle - 2 * half, middle + 2 * half))
    assert cost_of(twice) == pytest.approx([0.75])


def test_doubt_widens_the_area_and_lowers_the_cost() -> None:
    shifted = AREA + np.array([30.0, 0.0, 30.0, 0.0])
    assert cost_of(shifted, std=0.5)[0] < cost_of(shifted)[0]


def test_the_part_of_a_box_outside_the_image_does_not_count() -> None:
    expected = beliefs_at((-16.5, 20.0), std=0.0)  # reaches the left border
    observed = beliefs_at((-16.5, 20.0))
    pairing = pairing_of(expected, observed)
    area = pairing.search_areas[0]
    assert area[0] == 0.0
    observed.boxes[0] = [-500.0, area[1], area[2], area[3]]
    assert Reprojection()(pairing_of(expected, observed)) == pytest.approx([0.0])
