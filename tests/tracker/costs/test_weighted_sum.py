"""The overall cost: a weighted mean of what could be measured."""

import numpy as np
import pytest

from tests.tracker.samples import beliefs_at, pairing_of
from tracker.costs import GatedPairs, weighted_sum

PAIRING = pairing_of(beliefs_at((0.0, 20.0)), beliefs_at((0.0, 20.0)))
NAN = float("nan")


def fixed(*values: float):
    """A cost that always says this."""

    def cost(pairing: GatedPairs) -> np.ndarray:
        return np.array(values)

    return cost


def test_weights_are_divided_by_their_sum() -> None:
    total = weighted_sum(PAIRING, ((3.0, fixed(0.2, 1.0)), (1.0, fixed(0.6, 0.0)))).total
    np.testing.assert_allclose(total, [0.3, 0.75])


def test_a_cost_that_was_not_measured_leaves_its_weight_to_the_others() -> None:
    costs = ((3.0, fixed(0.2, NAN, 0.2)), (1.0, fixed(0.6, 0.6, NAN)))
    total, parts, unmeasured = weighted_sum(PAIRING, costs)
    np.testing.assert_allclose(total, [0.3, 0.6, 0.2])
    np.testing.assert_array_equal(parts[0], [0.2, NAN, 0.2])
    assert unmeasured == 2


def test_a_pair_without_any_cost_is_impossible() -> None:
    total, _, unmeasured = weighted_sum(PAIRING, ((1.0, fixed(NAN, 0.5)), (1.0, fixed(NAN, 0.5))))
    np.testing.assert_array_equal(total, [np.inf, 0.5])
    assert unmeasured == 2


def test_where_a_cost_is_the_only_one_its_pair_is_impossible_too() -> None:
    total, _, unmeasured = weighted_sum(PAIRING, ((0.5, fixed(0.3, NAN)),))
    np.testing.assert_array_equal(total, [0.3, np.inf])
    assert unmeasured == 1


def test_a_pair_whose_only_measured_cost_has_no_weight_is_impossible() -> None:
    total = weighted_sum(PAIRING, ((0.0, fixed(0.3, 0.3)), (1.0, fixed(NAN, 0.5)))).total
    np.testing.assert_array_equal(total, [np.inf, 0.5])


def test_no_pairs_sum_to_nothing() -> None:
    total, parts, unmeasured = weighted_sum(PAIRING, ((1.0, fixed()), (2.0, fixed())))
    assert total.shape == (0,)
    assert [part.shape for part in parts] == [(0,), (0,)]
    assert unmeasured == 0


@pytest.mark.parametrize("scale", [0.001, 1.0, 1000.0])
def test_only_the_ratio_of_weights_matters(scale: float) -> None:
    costs = ((0.6 * scale, fixed(0.1)), (0.4 * scale, fixed(0.9)))
    assert weighted_sum(PAIRING, costs).total == pytest.approx([0.42])
