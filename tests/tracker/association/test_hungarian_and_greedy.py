"""What the two assignments do differently, by hand; what they share is in the contracts."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import linear_sum_assignment

from tracker.association import Greedy, Hungarian, Match
from tracker.errors import BadConfig

# Greedy takes the 0.1 and must leave the second row with 0.9; together 0.2 + 0.3 are cheaper.
COSTS = np.array([[0.1, 0.2], [0.3, 0.9]])


def test_greedy_takes_the_cheapest_pair_first() -> None:
    assert Greedy(max_cost=0.8)(COSTS).pairs.tolist() == [[0, 0]]
    assert Greedy(max_cost=1.0)(COSTS).pairs.tolist() == [[0, 0], [1, 1]]


def test_hungarian_takes_the_pairs_that_are_cheapest_together() -> None:
    assert Hungarian(max_cost=0.8)(COSTS).pairs.tolist() == [[0, 1], [1, 0]]


def test_hungarian_makes_a_pair_only_if_it_gains() -> None:
    """Two pairs at 0.6 gain 0.4 in all under a limit of 0.8; the pair at 0.1 alone gains 0.7."""
    costs = np.array([[0.1, 0.6], [0.6, np.inf]])
    assert Hungarian(max_cost=0.8)(costs).pairs.tolist() == [[0, 0]]
    assert Hungarian(max_cost=2.0)(costs).pairs.tolist() == [[0, 1], [1, 0]]


@given(st.integers(0, 2**32 - 1), st.integers(0, 6), st.integers(0, 6))
def test_hungarian_is_the_optimum_also_where_nobody_competes(seed, rows, columns) -> None:  # type: ignore[no-untyped-def]
    """Few pairs within the limit, so that most matrices are clear; ties among them."""
    rng = np.random.default_rng(seed)
    costs = rng.choice([0.2, 0.3, 0.9, np.inf], (rows, columns), p=[0.1, 0.1, 0.1, 0.7])
    costs += rng.choice([0.0, 0.1], costs.shape) * rng.random(costs.shape)
    match = Hungarian(max_cost=0.8)(costs)
    gain = np.minimum(costs - 0.8, 0.0)
    best = linear_sum_assignment(gain)
    expected = np.array(best).T[gain[best] < 0.0]
    np.testing.assert_allclose(gain[tuple(match.pairs.T)].sum(), gain[best].sum(), atol=1e-12)
    assert len(match.pairs) == len(expected)
    left = Match.of(match.pairs, rows, columns)
    np.testing.assert_array_equal(match.unmatched_tracks, left.unmatched_tracks)
    np.testing.assert_array_equal(match.unmatched_detections, left.unmatched_detections)
    if len(np.unique(gain)) == 1 + (gain < 0.0).sum():  # no ties
        np.testing.assert_array_equal(match.pairs, expected)


def test_greedy_decides_ties_by_row_then_column() -> None:
    assert Greedy()(np.full((2, 2), 0.5)).pairs.tolist() == [[0, 0], [1, 1]]


def test_who_is_left_over_is_lost_or_new() -> None:
    match = Hungarian()(np.array([[np.inf, 0.2, np.inf], [np.inf, np.inf, np.inf]]))
    assert match.pairs.tolist() == [[0, 1]]
    assert match.unmatched_tracks.tolist() == [1]
    assert match.unmatched_detections.tolist() == [0, 2]


@pytest.mark.parametrize("max_cost", [np.inf, np.nan])
def test_hungarian_needs_a_finite_limit(max_cost: float) -> None:
    with pytest.raises(BadConfig, match=r"max_cost (inf|nan)"):
        Hungarian(max_cost)
