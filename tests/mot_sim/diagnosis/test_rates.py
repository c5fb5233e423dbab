"""Rates over drives with their intervals."""

import numpy as np
import pytest

from mot_sim.diagnosis.rates import mean_count, rate


def test_a_rate_is_the_sum_over_the_sum() -> None:
    found = rate(np.array([1.0, 3.0]), np.array([10.0, 10.0]))
    assert found.mean == pytest.approx(0.2)
    # Off by -1 and +1: sqrt(2 / 1 * 2) / 20 = 0.1, times t(1) = 12.706.
    assert found.high == pytest.approx(0.2 + 12.7062 * 0.1, rel=1e-4)
    assert found.low == 0.0
    assert rate(np.array([1.0, 3.0]), np.array([10.0, 10.0]), 1.0).high == 1.0


def test_drives_in_which_nothing_could_happen_do_not_count() -> None:
    found = rate(np.array([2.0, 0.0]), np.array([8.0, 0.0]))
    assert (found.mean, found.low, found.high, found.count) == (0.25, None, None, 1)
    assert rate(np.zeros(3), np.zeros(3)).mean is None
    assert rate(np.zeros(0), np.zeros(0)).mean is None


def test_no_case_among_many_leaves_a_small_rate_possible() -> None:
    found = rate(np.zeros(4), np.full(4, 25.0))
    assert (found.mean, found.low) == (0.0, 0.0)
    # exp(-100 * rate) = 0.025
    assert found.high == pytest.approx(0.036889, rel=1e-4)


def test_the_interval_holds_the_rate_as_often_as_it_says() -> None:
    rng, held = np.random.default_rng(5), 0
    for _ in range(400):
        events = rng.integers(5, 40, 8)
        found = rate(rng.binomial(events, 0.3).astype(float), events.astype(float))
        assert found.low is not None
        assert found.high is not None
        held += found.low <= 0.3 <= found.high
    assert 0.91 <= held / 400 <= 0.985


def test_a_mean_of_counts() -> None:
    assert mean_count([1, 2, 3]).mean == 2.0
    assert mean_count([]).mean is None
