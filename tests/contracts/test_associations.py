"""What every association of the register promises."""

from itertools import permutations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.tracker.samples import locked
from tracker.association import ASSOCIATIONS, Associate, Greedy, Hungarian, Match

LIMIT = 0.8
every_association = pytest.mark.parametrize("name", list(ASSOCIATIONS))
# Few different values, so that ties are common; 0.8 is the limit itself.
values = st.sampled_from([0.0, 0.1, 0.1, 0.3, 0.5, 0.7, LIMIT, 0.9, np.inf])


@st.composite
def cost_matrices(draw, most: int = 6) -> np.ndarray:
    n, m = draw(st.integers(0, most)), draw(st.integers(0, most))
    cells = draw(st.lists(values, min_size=n * m, max_size=n * m))
    return np.array(cells, dtype=float).reshape(n, m)


def gain(costs: np.ndarray, match: Match) -> float:
    """The sum of (cost - limit) over the pairs that were made."""
    return float((costs[match.pairs[:, 0], match.pairs[:, 1]] - LIMIT).sum())


def best_gain(costs: np.ndarray) -> float:
    """The smallest such sum of all possible matches, by trying every one."""
    n, m = costs.shape
    if n > m:
        return best_gain(costs.T)
    gains = np.minimum(costs - LIMIT, 0.0)
    return min(float(gains[np.arange(n), list(order)].sum()) for order in permutations(range(m), n))


@every_association
def test_it_satisfies_the_protocol(name: str) -> None:
    assert isinstance(ASSOCIATIONS[name](LIMIT), Associate)


@every_association
@given(cost_matrices())
def test_rows_and_columns_are_used_at_most_once_and_the_rest_is_lost_or_new(name, costs) -> None:
    match = ASSOCIATIONS[name](LIMIT)(locked(costs))
    rows, columns = match.pairs[:, 0].tolist(), match.pairs[:, 1].tolist()
    assert sorted([*rows, *match.unmatched_tracks.tolist()]) == list(range(costs.shape[0]))
    assert sorted([*columns, *match.unmatched_detections.tolist()]) == list(range(costs.shape[1]))
    assert (
        match.pairs.dtype
        == match.unmatched_tracks.dtype
        == match.unmatched_detections.dtype
        == np.int64
    )


@every_association
@given(cost_matrices())
def test_no_pair_at_or_above_the_limit_is_made(name, costs) -> None:
    match = ASSOCIATIONS[name](LIMIT)(costs)
    assert (costs[match.pairs[:, 0], match.pairs[:, 1]] < LIMIT).all()


@every_association
@given(cost_matrices())
def test_no_pair_that_could_be_made_is_left(name, costs) -> None:
    """What is lost and what is new never cost less than the limit together."""
    match = ASSOCIATIONS[name](LIMIT)(costs)
    assert (costs[np.ix_(match.unmatched_tracks, match.unmatched_detections)] >= LIMIT).all()


@every_association
@given(cost_matrices())
def test_the_same_costs_give_the_same_match(name, costs) -> None:
    once, twice = ASSOCIATIONS[name](LIMIT)(costs), ASSOCIATIONS[name](LIMIT)(costs.copy())
    np.testing.assert_array_equal(once.pairs, twice.pairs)


@every_association
@pytest.mark.parametrize("shape", [(0, 3), (3, 0), (0, 0)])
def test_with_nothing_on_one_side_everything_is_lost_or_new(name, shape) -> None:
    match = ASSOCIATIONS[name](LIMIT)(np.zeros(shape))
    assert match.pairs.shape == (0, 2)
    assert match.unmatched_tracks.tolist() == list(range(shape[0]))
    assert match.unmatched_detections.tolist() == list(range(shape[1]))


@every_association
def test_impossible_pairs_are_never_made(name: str) -> None:
    match = ASSOCIATIONS[name](LIMIT)(np.full((3, 3), np.inf))
    assert match.pairs.shape == (0, 2)
    assert ASSOCIATIONS[name](LIMIT)(np.diag([0.1] * 3) + np.diag([np.inf] * 2, 1)).pairs.shape


@every_association
def test_an_identity_is_found(name: str) -> None:
    costs = np.full((4, 4), 0.7)
    np.fill_diagonal(costs, 0.1)
    assert ASSOCIATIONS[name](LIMIT)(costs).pairs.tolist() == [[i, i] for i in range(4)]


@given(cost_matrices())
def test_hungarian_is_never_worse_than_greedy(costs) -> None:
    assert gain(costs, Hungarian(LIMIT)(costs)) <= gain(costs, Greedy(LIMIT)(costs)) + 1e-12


@given(cost_matrices(most=5))
def test_hungarian_is_as_good_as_the_best_of_all_matches(costs) -> None:
    assert gain(costs, Hungarian(LIMIT)(costs)) == pytest.approx(best_gain(costs), abs=1e-12)
