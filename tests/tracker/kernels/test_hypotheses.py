"""Kernels over all hypotheses of cars, of edges and of the road equal plain NumPy."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.tracker.kernels import plain_hypotheses as plain
from tests.tracker.samples import LEVEL
from tracker.car_filter import (
    CarFilter,
    CarStates,
    DirectionPrior,
    EdgeModel,
    RoadMemory,
    RoadModel,
)
from tracker.car_filter.edges import hidden_edges
from tracker.car_filter.estimates import estimate
from tracker.car_filter.modes import weighed
from tracker.car_filter.road_memory import SeenBases, believed_heights
from tracker.car_filter.roughness import RoughnessModel
from tracker.car_filter.states import normalised

seeds, counts = st.integers(0, 2**32 - 1), st.integers(0, 6)


def some_states(seed: int, count: int) -> CarStates:
    """Hypotheses with headings that tie, some dead, some of them standing."""
    rng = np.random.default_rng(seed)
    means = rng.normal(0.0, 5.0, (count, 16, 9))
    means[:, :, 3] = rng.choice([*rng.uniform(-9.0, 9.0, 4), 0.0, np.pi / 4], (count, 16))
    means[:, :, 4] = np.abs(means[:, :, 4]) * rng.integers(0, 2, (count, 16)) * 0.3
    roots = rng.normal(0.0, 0.3, (count, 16, 9, 9))
    log_weights = rng.choice([0.0, -2.5, -6.0, -8.0, -20.0, -np.inf], (count, 16))
    log_weights += rng.normal(0.0, 0.5, (count, 16))
    log_weights[:, rng.integers(0, 16)] = 0.0  # one at least is alive
    covs = roots @ roots.transpose(0, 1, 3, 2)
    return CarStates(means, covs, normalised(log_weights))


def same(found: object, expected: object) -> None:
    np.testing.assert_allclose(found, expected, rtol=1e-9, atol=1e-9)


@given(seeds, counts)
def test_directions_and_estimates(seed: int, count: int) -> None:
    states, prior = some_states(seed, count), DirectionPrior()
    own = np.array([[0.5, 0.1], [0.1, 0.3]])
    traffic = np.random.default_rng(seed).uniform(0.0, 5.0, (5, 2))
    memory = RoadMemory(traffic=traffic, camera_velocity_cov=own)
    weights = prior(memory, states)
    same(weights, plain.plain_directions(prior, memory, states))
    found, expected = estimate(states, weights), plain.plain_estimate(states, weights)
    for name in ("means", "covs", "heading_known"):
        same(getattr(found, name), getattr(expected, name))
    stated = CarFilter().stated(expected, memory, 1.5)
    same(stated.covs, plain.plain_stated(CarFilter(), expected, memory, 1.5).covs)


@given(seeds, counts, st.sampled_from([0.02, 0.5]), st.sampled_from([0.1, 1e3]))
def test_weights_and_modes_that_begin_again(
    seed: int, count: int, switch: float, least_speed: float
) -> None:
    rng = np.random.default_rng(seed)
    shape = count, 16
    fits, told = rng.normal(-2.0, 2.0, shape), rng.choice([0.0, -1.0, 0.5], shape)

    def fitted() -> CarStates:
        states = some_states(seed, count)
        states.means[:, :, 4] -= least_speed * (states.means[:, :, 4] == 0.0)
        return states

    counted = fitted().log_weights, fits, told, 0.5, switch
    expected, parents = plain.plain_weighed(fitted(), *counted)
    found, found_parents = weighed(fitted(), *counted)
    np.testing.assert_array_equal(found_parents, parents)
    same(found.means, expected.means)
    same(found.covs, expected.covs)
    same(np.exp(found.log_weights), np.exp(expected.log_weights))


@given(seeds, counts)
def test_traffic_and_heights(seed: int, count: int) -> None:
    states, memory = some_states(seed, count), RoadMemory()
    states.means[: count // 2, 8:, 4] += 20.0  # some move for certain
    states.log_weights[: count // 2, :8] = -20.0
    states = states.replaced(log_weights=normalised(states.log_weights))
    found = DirectionPrior().update(memory, states, 0.1).traffic
    same(found, plain.plain_traffic(states, 0.1, memory))
    same(believed_heights(states), plain.plain_heights(states))


@pytest.mark.parametrize("spread", [1e-3, 60.0, 1e6])
@given(seed=seeds, count=counts, others=counts)
def test_edges_and_the_road(seed: int, count: int, others: int, spread: float) -> None:
    rng, edges = np.random.default_rng(seed), EdgeModel(bias=(0.01, -0.006, 0.0, 0.02))
    low = rng.uniform(-30.0, 400.0, (count + others, 2))
    both = np.concatenate((low, low + rng.uniform(0.0, spread, (count + others, 2))), axis=1)
    boxes, scores = both[:count], rng.uniform(-0.5, 1.5, count)
    hidden = hidden_edges(boxes, both)
    np.testing.assert_array_equal(hidden, plain.plain_hidden_edges(boxes, both))
    unbiased, variances = edges(boxes, scores, hidden)
    same(unbiased, plain.plain_unbiased(edges, boxes))
    same(variances, plain.plain_variances(edges, unbiased, scores, hidden))
    seen = boxes, scores, hidden, LEVEL
    bases, expected = SeenBases.of(*seen), plain.plain_bases(*seen)
    for one, other in zip(bases, expected, strict=True):
        same(one, other)
    road, roughness, memory = RoadModel(), RoughnessModel(), RoadMemory(0.01, 0.001)
    heights = rng.uniform(0.5, 3.0, count)
    assert road.update(memory, bases, heights)[:2] == pytest.approx(
        plain.plain_slope(road, memory, bases, heights)[:2]
    )
    assert roughness.update(memory, bases, 1.5).flatness == pytest.approx(
        plain.plain_flatness(roughness, memory, bases, 1.5).flatness, abs=1e-9
    )
