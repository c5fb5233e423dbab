"""What every cost of the register promises."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.tracker.samples import LEVEL, beliefs_at, locked, pairing_of
from tracker.beliefs import Beliefs
from tracker.costs import COSTS, Cost, GatedPairs

every_cost = pytest.mark.parametrize("cost", [make() for make in COSTS.values()], ids=list(COSTS))
ROUNDING = 1e-9


def scattered(seed: int, n: int) -> Beliefs:
    """n cars somewhere ahead, with their own doubts, seen with a little jitter."""
    rng = np.random.default_rng(seed)
    places = np.column_stack((rng.uniform(-8, 8, n), rng.uniform(10, 40, n)))
    beliefs = beliefs_at(*map(tuple, places.tolist()))
    beliefs.cuboids.yaw[:] = rng.uniform(-3, 3, n)
    beliefs.cov[:, [0, 1], [0, 1]] = rng.uniform(0.01, 4.0, (n, 2))
    beliefs.boxes[:] = beliefs.boxes + rng.normal(0.0, 3.0, (n, 4))
    return beliefs


def matrix_of(cost: Cost, pairing: GatedPairs) -> np.ndarray:
    """Rows expected, columns observed; inf where the pair is outside the search area."""
    matrix = np.full(pairing.shape, np.inf)
    matrix[pairing.pairs] = cost(pairing)
    return matrix


@every_cost
def test_it_satisfies_the_protocol(cost: Cost) -> None:
    assert isinstance(cost, Cost)


@every_cost
@given(st.integers(0, 10_000), st.integers(0, 7), st.integers(0, 7))
def test_there_is_one_number_from_0_to_1_or_nan_for_every_pair(cost, seed, n, m) -> None:
    pairing = pairing_of(scattered(seed, n), scattered(seed + 1, m))
    costs = cost(pairing)
    assert costs.shape == pairing.pairs[0].shape
    measured = costs[~np.isnan(costs)]
    assert (measured >= 0.0).all()
    assert (measured <= 1.0 + ROUNDING).all()


@every_cost
@given(st.integers(0, 10_000))
def test_it_is_pure_and_leaves_its_inputs_as_they_were(cost, seed) -> None:
    expected, observed = locked(scattered(seed, 4)), locked(scattered(seed + 1, 5))
    first = cost(pairing_of(expected, observed))
    pairing = pairing_of(expected, observed)
    np.testing.assert_array_equal(cost(pairing), first)
    np.testing.assert_array_equal(cost(pairing), first)


@every_cost
@given(st.integers(0, 10_000))
def test_the_order_of_rows_and_columns_does_not_matter(cost, seed) -> None:
    expected, observed = scattered(seed, 5), scattered(seed + 1, 6)
    rng = np.random.default_rng(seed)
    rows, columns = rng.permutation(5), rng.permutation(6)
    matrix = matrix_of(cost, pairing_of(expected, observed))
    permuted = matrix_of(cost, pairing_of(expected.select(rows), observed.select(columns)))
    np.testing.assert_allclose(permuted, matrix[np.ix_(rows, columns)], atol=ROUNDING)


@every_cost
@given(st.integers(0, 10_000))
def test_no_other_object_costs_less_than_the_same_one(cost, seed) -> None:
    """Equal doubts, exact boxes: what stands where it was expected is the cheapest."""
    rng = np.random.default_rng(seed)
    places = zip(rng.uniform(-8, 8, 6).tolist(), rng.uniform(10, 40, 6).tolist(), strict=True)
    same = beliefs_at(*places, std=0.3)
    visible = ((same.boxes[:, ::2] > 0) & (same.boxes[:, ::2] < LEVEL.image_size[0])).all(axis=1)
    same = same.select(visible)
    matrix = matrix_of(cost, pairing_of(same, same))
    own = np.diag(matrix)
    assert np.isfinite(own).all()
    assert (own[:, None] <= matrix + ROUNDING).all()
    assert (own[None] <= matrix + ROUNDING).all()


@every_cost
def test_an_object_where_it_was_expected_costs_nearly_nothing_and_a_far_one_more(cost) -> None:
    expected = beliefs_at((0.0, 20.0), std=0.3)
    observed = beliefs_at((0.0, 20.0), (0.8, 21.0), (1.6, 23.0), std=0.3)
    same, near, far = matrix_of(cost, pairing_of(expected, observed))[0]
    assert same == pytest.approx(0.0, abs=ROUNDING)
    assert same < near < far <= np.inf


@every_cost
@pytest.mark.parametrize(("n", "m"), [(0, 3), (3, 0), (0, 0)])
def test_no_pairs_cost_nothing_at_all(cost: Cost, n: int, m: int) -> None:
    assert cost(pairing_of(scattered(0, n), scattered(1, m))).shape == (0,)
