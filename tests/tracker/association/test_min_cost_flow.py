"""Minimum-cost network flow: against every possible set of tracks, and by hand."""

from itertools import product

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.tracker.samples import locked
from tracker.association.min_cost_flow import Arcs, Flow, cheapest_flow
from tracker.errors import BadConfig


def arcs(*links: tuple[int, int, float]) -> Arcs:
    tails, heads, costs = zip(*links, strict=True) if links else ((), (), ())
    return Arcs(np.array(tails, np.int64), np.array(heads, np.int64), np.array(costs, float))


def brute_force(nodes: np.ndarray, births: np.ndarray, links: Arcs) -> float:
    """The smallest cost, by trying every forerunner (or birth, or leaving out) of everybody."""
    n, best = len(nodes), np.inf
    into = [np.flatnonzero(links.heads == node).tolist() for node in range(n)]
    for choice in product(*[["out", "born", *arriving] for arriving in into]):
        chosen = [arc for arc in choice if isinstance(arc, int)]
        tails = links.tails[chosen].tolist()
        if len(set(tails)) < len(tails) or any(choice[tail] == "out" for tail in tails):
            continue
        used = np.array([what != "out" for what in choice], bool)
        born = np.array([what == "born" for what in choice], bool)
        cost = nodes[used].sum() + births[born].sum() + links.costs[chosen].sum()
        best = min(best, float(cost))
    return best


def cost_of(flow: Flow, nodes: np.ndarray, births: np.ndarray, links: Arcs) -> float:
    """What the tracks of a flow cost, counted one by one."""
    price = dict(zip(zip(links.tails, links.heads, strict=True), links.costs, strict=True))
    born = flow.used.copy()
    born[flow.links[:, 1]] = False
    linked = sum(price[tail, head] for tail, head in flow.links.tolist())
    return float(nodes[flow.used].sum() + births[born].sum() + linked)


@st.composite
def problems(draw, most: int = 5) -> tuple[np.ndarray, np.ndarray, Arcs]:
    n = draw(st.integers(0, most))
    price = st.sampled_from([-3.0, -1.0, 0.0, 0.5, 1.0, 2.0, 4.0])
    pairs = [(i, j) for j in range(n) for i in range(j)]
    chosen = draw(st.lists(st.sampled_from(pairs), unique=True, max_size=7)) if pairs else []
    links = arcs(*[(i, j, draw(price)) for i, j in chosen])
    numbers = st.lists(price, min_size=n, max_size=n)
    births = st.lists(st.sampled_from([0.0, 1.0, 3.0]), min_size=n, max_size=n)
    return np.array(draw(numbers), float), np.array(draw(births), float), links


@given(problems())
def test_the_flow_is_as_cheap_as_the_best_of_all_sets_of_tracks(problem) -> None:
    flow = cheapest_flow(*locked(problem))
    assert flow.cost == pytest.approx(brute_force(*problem), abs=1e-9)
    assert flow.cost == pytest.approx(cost_of(flow, *problem), abs=1e-9)


@given(problems())
def test_a_node_has_one_forerunner_one_successor_and_one_track(problem) -> None:
    flow = cheapest_flow(*problem)
    for side in flow.links.T:
        assert len(set(side.tolist())) == len(side)
        assert flow.used[side].all()
    tracks = flow.tracks
    assert (tracks[flow.links[:, 0]] == tracks[flow.links[:, 1]]).all()
    assert len(set(tracks.tolist())) == len(tracks) - len(flow.links)


def test_weak_nodes_vanish_and_strong_chains_stay() -> None:
    """Two strong ones 0-2 earn their birth, the single 1 does not; 3 is skipped for 4."""
    nodes = np.array([-3.0, -3.0, -3.0, 2.0, -3.0])
    links = arcs((0, 2, 0.0), (2, 3, 0.0), (3, 4, 0.0), (2, 4, 1.0))
    flow = cheapest_flow(nodes, np.full(5, 4.0), links)
    assert flow.links.tolist() == [[0, 2], [2, 4]]
    assert flow.used.tolist() == [True, False, True, False, True]
    assert flow.cost == pytest.approx(-3.0 * 3 + 1.0 + 4.0)


def test_a_crossing_is_decided_by_the_sum_and_not_by_the_cheapest_link() -> None:
    links = arcs((0, 2, 0.0), (0, 3, 1.0), (1, 2, 1.0), (1, 3, 5.0))
    flow = cheapest_flow(np.full(4, -10.0), np.full(4, 8.0), links)
    assert flow.links.tolist() == [[0, 3], [1, 2]]


def test_nothing_seen_is_no_track() -> None:
    flow = cheapest_flow(np.zeros(0), np.zeros(0), arcs())
    assert (flow.links.shape, len(flow.used), flow.cost) == ((0, 2), 0, 0.0)
    assert flow.tracks.tolist() == []


def test_the_same_problem_has_the_same_answer() -> None:
    links = arcs(*[(i, j, 1.0) for j in range(8) for i in range(j)])
    one, two = (cheapest_flow(np.full(8, -2.0), np.full(8, 3.0), links) for _ in range(2))
    np.testing.assert_array_equal(one.links, two.links)


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
def test_costs_that_are_not_finite_are_refused(bad: float) -> None:
    with pytest.raises(BadConfig, match=r"node 0 to 1 costs -?(nan|inf).*leave out"):
        arcs((0, 1, bad))
    with pytest.raises(BadConfig, match=r"node 1 costs.*finite"):
        cheapest_flow(np.array([0.0, bad]), np.zeros(2), arcs())


def test_links_backwards_and_links_given_twice_are_refused() -> None:
    with pytest.raises(BadConfig, match=r"from node 2 back to 1.*order of time"):
        arcs((2, 1, 0.0))
    with pytest.raises(BadConfig, match="same two nodes"):
        cheapest_flow(np.zeros(2), np.ones(2), arcs((0, 1, 0.0), (0, 1, 0.5)))
