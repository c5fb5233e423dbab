"""Latents that remember: stationary, of the promised autocorrelation, a function of their key."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mot_sim.simulation.sensors.correlated_noise import (
    BLOCK_FRAMES,
    Autocorrelation,
    correlated_normal_columns,
    correlated_normals,
    prefetch_draws,
)
from tracker.errors import BadConfig

OBJECTS, FRAMES = 600, 3 * BLOCK_FRAMES
IDS, TIMES = np.tile(np.arange(OBJECTS), FRAMES), np.repeat(np.arange(FRAMES), OBJECTS)


def table(autocorrelation: Autocorrelation, step: float = 0.1, seed: int = 1) -> np.ndarray:
    return correlated_normals(seed, "x", IDS, TIMES, autocorrelation, step)[:, 0].reshape(
        FRAMES, OBJECTS
    )


@pytest.mark.parametrize("tau", [0.12, 1.2, 15.0])
def test_every_frame_is_standard_normal(tau) -> None:
    x = table(Autocorrelation((1.0,), (tau,)))
    assert np.abs(x.mean(axis=1)).max() < 5.0 / np.sqrt(OBJECTS)
    assert np.abs(x.std(axis=1) - 1.0).max() < 0.15


@pytest.mark.parametrize("tau", [0.12, 1.2])
def test_neighbours_correlate_as_promised_across_blocks_too(tau) -> None:
    x = table(Autocorrelation((1.0,), (tau,)))
    rho = np.exp(-0.1 / tau)
    within = [np.corrcoef(x[k], x[k + 1])[0, 1] for k in range(FRAMES - 1)]
    assert np.mean(within) == pytest.approx(rho, abs=0.01)
    assert within[BLOCK_FRAMES - 1] == pytest.approx(rho, abs=0.12)
    far = [
        np.corrcoef(x[k], x[k + 2 * BLOCK_FRAMES])[0, 1] for k in range(FRAMES - 2 * BLOCK_FRAMES)
    ]
    assert np.mean(far) == pytest.approx(np.exp(-0.2 * BLOCK_FRAMES / tau), abs=0.05)


def test_a_mixture_has_the_mixed_autocorrelation() -> None:
    autocorrelation = Autocorrelation((0.3, 0.5, 0.2), (0.0, 0.5, float("inf")))
    x = table(autocorrelation)
    for lag in (1, 5, 20):
        rho = np.corrcoef(x[:-lag].ravel(), x[lag:].ravel())[0, 1]
        assert rho == pytest.approx(autocorrelation.correlation(0.1 * lag), abs=0.03)


@pytest.mark.parametrize("tau", [0.12, 0.5, 5.0])
def test_smooth_latents_are_stationary_and_keep_their_promise_across_blocks(tau) -> None:
    autocorrelation = Autocorrelation((1.0,), (tau,), (1.0,))
    x = table(autocorrelation)
    assert np.abs(x.std(axis=1) - 1.0).max() < 0.15
    for lag in (1, 3, BLOCK_FRAMES + 1):
        rho = [np.corrcoef(x[k], x[k + lag])[0, 1] for k in range(FRAMES - lag)]
        assert np.mean(rho) == pytest.approx(autocorrelation.correlation(0.1 * lag), abs=0.05)
    across = np.corrcoef(x[BLOCK_FRAMES - 2], x[BLOCK_FRAMES + 1])[0, 1]
    assert across == pytest.approx(autocorrelation.correlation(0.3), abs=0.12)


def test_the_correlation_of_a_smooth_memory_by_hand() -> None:
    assert Autocorrelation((1.0,), (0.5,), (1.0,)).correlation(0.5) == pytest.approx(2.0 / np.e)
    half = Autocorrelation((0.5, 0.5), (0.5, 0.5), (1.0, 0.0))
    assert half.correlation(0.5) == pytest.approx(1.5 / np.e)
    assert half.slower(2.0).correlation(1.0) == pytest.approx(1.5 / np.e)


def test_smooth_latents_cross_a_limit_less_often_than_rough_ones() -> None:
    rough, smooth = (table(Autocorrelation((1.0,), (0.5,), (kind,))) > 1.0 for kind in (0.0, 1.0))
    assert (rough[1:] != rough[:-1]).mean() > 1.5 * (smooth[1:] != smooth[:-1]).mean()


def test_what_is_drawn_side_by_side_is_what_is_drawn_alone() -> None:
    first, second = (
        Autocorrelation((0.2, 0.8), (0.0, 1.2)),
        Autocorrelation((0.5, 0.5), (0.25, 4.0), (1.0, 0.0)),
    )
    ids, frames = np.array([5, 7, 9]), np.array([40, 70, 40])
    many = np.tile(ids, 40), np.tile(frames, 40)
    whole = [
        correlated_normal_columns(8, "a", *many, (first, second), 0.1),
        correlated_normals(8, "b", *many, second, 0.1),
    ]
    prefetch_draws(8, ids, frames, (("a", (first, second)), ("b", (second,))), 0.1)
    assert (
        correlated_normal_columns(8, "a", ids, frames, (first, second), 0.1) == whole[0][:3]
    ).all()
    assert (correlated_normals(8, "b", ids, frames, second, 0.1) == whole[1][:3]).all()


def test_twice_the_frame_rate_gives_the_same_autocorrelation_in_seconds() -> None:
    autocorrelation = Autocorrelation((0.7, 0.3), (0.4, 1.2), (0.0, 1.0))
    slow, fast = table(autocorrelation, 0.1), table(autocorrelation, 0.05)
    rho_slow = np.corrcoef(slow[:-3].ravel(), slow[3:].ravel())[0, 1]
    rho_fast = np.corrcoef(fast[:-6].ravel(), fast[6:].ravel())[0, 1]
    assert rho_slow == pytest.approx(rho_fast, abs=0.03)


@settings(max_examples=20)
@given(st.sets(st.integers(0, len(IDS) - 1), min_size=1, max_size=40))
def test_a_row_depends_on_its_key_alone(rows) -> None:
    chosen = np.array(sorted(rows))
    autocorrelation = Autocorrelation((0.2, 0.3, 0.5), (0.0, 1.2, 0.5), (0.0, 0.0, 1.0))
    whole = correlated_normals(3, "x", IDS, TIMES, autocorrelation, 0.1, 2)
    some = correlated_normals(3, "x", IDS[chosen], TIMES[chosen], autocorrelation, 0.1, 2)
    assert (whole[chosen] == some).all()


def test_objects_effects_and_seeds_are_independent() -> None:
    autocorrelation = Autocorrelation((1.0,), (1.2,))
    x = table(autocorrelation)
    assert abs(np.corrcoef(x[:, :300].ravel(), x[:, 300:].ravel())[0, 1]) < 0.06
    assert abs(np.corrcoef(x.ravel(), table(autocorrelation, seed=2).ravel())[0, 1]) < 0.06
    other = correlated_normals(1, "y", IDS, TIMES, autocorrelation, 0.1)[:, 0]
    assert abs(np.corrcoef(x.ravel(), other)[0, 1]) < 0.06


def test_nobody_has_no_latent() -> None:
    nobody = np.zeros(0, np.int64)
    assert correlated_normals(
        1, "x", nobody, nobody, Autocorrelation((1.0,), (1.0,)), 0.1, 3
    ).shape == (0, 3)


@pytest.mark.parametrize(
    ("smooth", "told"), [((1.0, 0.0), "or none"), ((0.5,), "0 or 1"), ((1.0,), "at most 60 s")]
)
def test_a_smoothness_that_cannot_be_is_refused(smooth, told) -> None:
    with pytest.raises(BadConfig, match=told):
        Autocorrelation((1.0,), (100.0,), smooth)


@pytest.mark.parametrize(
    ("shares", "seconds", "told"),
    [((0.5,), (1.0,), "sum 1"), ((1.0,), (1.0, 2.0), "as many"), ((1.0,), (-1.0,), "0 \\(none\\)")],
)
def test_a_memory_that_cannot_be_is_refused(shares, seconds, told) -> None:
    with pytest.raises(BadConfig, match=told):
        Autocorrelation(shares, seconds)
