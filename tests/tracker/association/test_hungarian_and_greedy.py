"""What the two assignments do differently, by hand; what they share is in the contracts."""

import numpy as np
import pytest

from tracker.association import Greedy, Hungarian
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
