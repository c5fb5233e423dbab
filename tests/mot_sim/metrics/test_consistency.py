"""Stated uncertainties against errors drawn from them."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mot_sim.metrics.consistency import (
    CHANCE_BINS,
    Consistency,
    brier_score,
    chances_by_range,
    squared_deviations,
)


def test_deviation_by_hand():
    covs = np.array([np.diag([4.0, 1.0]), np.diag([1.0, 9.0])])
    np.testing.assert_allclose(squared_deviations(np.array([[2.0, 1.0], [0.0, 6.0]]), covs), [2, 4])


@pytest.mark.parametrize("size", [1, 2, 3])
def test_errors_drawn_from_their_covariance_are_consistent(size: int):
    rng = np.random.default_rng(1)
    A = rng.normal(size=(20_000, size, size))
    covs = A @ A.swapaxes(1, 2) + 0.1 * np.eye(size)
    errors = (np.linalg.cholesky(covs) @ rng.normal(size=(20_000, size, 1)))[:, :, 0]
    found = Consistency.of(squared_deviations(errors, covs), errors.shape[1])
    assert found.nees == pytest.approx(size, rel=0.05)
    assert found.inside_1_sigma == pytest.approx(found.ideal(1.0), abs=0.02)
    assert found.inside_2_sigma == pytest.approx(found.ideal(2.0), abs=0.02)


def test_ideal_shares_are_those_of_the_normal_distribution():
    plane = Consistency(2, 0, 0.0, 0.0, 0.0)
    assert plane.ideal(1.0) == pytest.approx(1 - np.exp(-0.5))
    assert plane.ideal(2.0) == pytest.approx(1 - np.exp(-2.0))
    assert Consistency(1, 0, 0.0, 0.0, 0.0).ideal(2.0) == pytest.approx(0.9545, abs=1e-4)


@given(scale=st.floats(0.2, 5.0))
def test_too_small_sigmas_are_seen_as_overconfidence(scale: float):
    rng = np.random.default_rng(3)
    errors = rng.normal(size=(500, 2))
    covs = np.tile(np.eye(2) * scale**2, (500, 1, 1))
    expected = float((errors**2).sum(axis=1).mean()) / scale**2
    assert Consistency.of(squared_deviations(errors, covs), errors.shape[1]).nees == pytest.approx(
        expected
    )


def test_rows_without_an_honest_covariance_are_left_out():
    covs = np.array([np.eye(2), np.full((2, 2), np.nan), np.zeros((2, 2)), -np.eye(2)])
    found = Consistency.of(squared_deviations(np.ones((4, 2)), covs), 2)
    assert (found.rows, found.nees) == (1, 2.0)
    nothing = Consistency.of(squared_deviations(np.zeros((0, 2)), np.zeros((0, 2, 2))), 2)
    assert nothing.rows == 0
    assert np.isnan(nothing.nees)
    assert set(nothing.numbers("centre")) == {
        "centre_inside_1_sigma", "centre_inside_2_sigma", "centre_nees"
    }  # fmt: skip


def test_chances_are_held_against_what_came_true():
    chances = np.array([0.5, 0.55, 0.97, 0.99, 1.0, np.nan])
    true = np.array([1.0, 0.0, 1.0, 1.0, 0.0, 1.0])
    ranges = chances_by_range(chances, true)
    assert [each.rows for each in ranges] == [2, 0, 0, 0, 0, 3]
    assert (ranges[0].stated, ranges[0].came_true) == (0.525, 0.5)
    assert ranges[-1].came_true == pytest.approx(2 / 3)
    assert np.isnan(ranges[1].came_true)
    assert (ranges[0].low, ranges[-1].high) == (CHANCE_BINS[0], CHANCE_BINS[-1])


def test_brier_score_by_hand():
    assert brier_score(np.array([1.0, 0.5]), np.array([1.0, 0.0])) == 0.125
    assert np.isnan(brier_score(np.zeros(0), np.zeros(0)))
