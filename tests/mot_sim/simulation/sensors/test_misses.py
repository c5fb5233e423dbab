"""Misses, bursts, shared frames, and kinds taken for cars."""

import numpy as np
import pytest

from mot_sim.simulation.sensors.correlated_noise import Autocorrelation, bursts
from mot_sim.simulation.sensors.misses import HEIGHT_KNOTS, Confusion, Misses
from tests.mot_sim.simulation.sensors.sights import STEP, by_object, crowd, lag_one, sightings_of
from tracker.errors import BadConfig

SLOW = Autocorrelation((1.0,), (1.0,))
LOGIT_OF_A_TENTH = 2.1972


def test_the_marginal_rate_is_exact_whatever_the_memory() -> None:
    for autocorrelation in (Autocorrelation(), SLOW, Autocorrelation((0.5, 0.5), (0.1, 3.0))):
        missed, _ = Misses(LOGIT_OF_A_TENTH, autocorrelation=autocorrelation)(
            crowd(2000, 40), 1, STEP
        )
        assert missed.mean() == pytest.approx(0.1, abs=0.012)


def test_the_rate_is_exact_while_it_varies() -> None:
    rates = np.repeat(np.linspace(0.05, 0.5, 10), 3000)
    frames, ids = np.repeat(np.arange(10), 3000), np.tile(np.arange(3000), 10)
    happens = bursts(rates, 5, "x", ids, frames, SLOW, STEP).reshape(10, 3000)
    np.testing.assert_allclose(happens.mean(axis=1), np.linspace(0.05, 0.5, 10), atol=0.04)


def test_misses_come_in_bursts_and_not_without_memory() -> None:
    missed = [
        by_object(
            Misses(LOGIT_OF_A_TENTH, autocorrelation=autocorrelation)(crowd(), 1, STEP)[0]
        ).astype(float)
        for autocorrelation in (Autocorrelation(), SLOW)
    ]
    assert abs(lag_one(missed[0])) < 0.03
    # Orthant probability of a normal pair with correlation exp(-0.1) at 10 %: .69.
    assert lag_one(missed[1]) == pytest.approx(0.69, abs=0.06)


def test_bursts_last_as_long_at_twice_the_frame_rate() -> None:
    slow, fast = (
        by_object(Misses(0.0, autocorrelation=SLOW)(crowd(400, 200), 1, step)[0], 400)
        for step in (0.1, 0.05)
    )
    agree = [(slow[:-4] == slow[4:]).mean(), (fast[:-8] == fast[8:]).mean()]
    assert agree[0] == pytest.approx(agree[1], abs=0.02)


def test_flutter_keeps_the_rate_and_shortens_the_bursts_of_hidden_cars_only() -> None:
    flutter = {
        "flutter": (0.8, 0.8, 0.0, 0.0),
        "flutter_autocorrelation": Autocorrelation((1.0,), (0.2,)),
    }
    model = Misses(LOGIT_OF_A_TENTH, autocorrelation=SLOW, **flutter)
    hidden, plain = (
        by_object(model(crowd(2000, 40, visible=v), 1, STEP)[0], 2000).astype(float)
        for v in (0.35, 0.95)
    )
    assert hidden.mean() == pytest.approx(0.1, abs=0.012)
    assert plain.mean() == pytest.approx(0.1, abs=0.012)
    assert lag_one(hidden) < lag_one(plain) - 0.1


def test_bursts_of_a_smooth_memory_last_as_long_at_twice_the_frame_rate() -> None:
    smooth = Autocorrelation((1.0,), (0.5,), (1.0,))
    slow, fast = (
        by_object(Misses(0.0, autocorrelation=smooth)(crowd(400, 200), 1, step)[0], 400)
        for step in (0.1, 0.05)
    )
    agree = [(slow[:-4] == slow[4:]).mean(), (fast[:-8] == fast[8:]).mean()]
    assert agree[0] == pytest.approx(agree[1], abs=0.02)


def test_a_frame_shares_its_misses() -> None:
    shared = Misses(0.0, shared=0.8)
    missed = by_object(shared(crowd(), 1, STEP)[0]).mean(axis=1)
    alone = by_object(Misses(0.0)(crowd(), 1, STEP)[0]).mean(axis=1)
    assert missed.std() > 5 * alone.std()
    many = by_object(shared(crowd(50, 2000), 1, STEP)[0], 50)
    assert many.mean() == pytest.approx(0.5, abs=0.05)


def test_small_hidden_and_cut_cars_are_missed_more() -> None:
    model = Misses(
        2.0, (-3.0, -2.0, -1.0, 0.0), (-2.0, -1.0, 0.0, 0.0, 0.0, 0.0), (0.0, -1.0, -3.0)
    )
    open_car = model.rates(sightings_of([0], [0]))[0]
    assert open_car == pytest.approx(1.0 / (1.0 + np.exp(2.0)))
    assert model.rates(sightings_of([0], [0], height=HEIGHT_KNOTS[0]))[0] == pytest.approx(0.5)
    assert model.rates(sightings_of([0], [0], visible=0.35))[0] == pytest.approx(0.5)
    assert model.rates(sightings_of([0], [0], cut=0.6))[0] > 0.7
    near = Misses(2.0, by_truncation=(0.0, -1.0, -3.0), truncation_by_height=(0.0, 0.0, -2.0))
    rates = near.rates(sightings_of([0, 1], [0, 0], height=100.0, cut=[0.2, 0.6]))
    np.testing.assert_allclose(rates, [1.0 / (1.0 + np.exp(1.0)), 1.0 / (1.0 + np.exp(-1.0))])
    farther = near.rates(sightings_of([0], [0], height=50.0, cut=0.6))[0]
    assert farther < rates[1]


def test_what_hides_and_what_is_small_may_work_together() -> None:
    both = np.zeros((4, 6))
    both[1, 0] = -1.0
    model = Misses(0.0, by_both=tuple(both.ravel().tolist()))
    rates = model.rates(sightings_of([0, 1, 2], [0, 0, 0], [0.35, 0.35, 0.95], [15.0, 60.0, 15.0]))
    assert rates[0] > 0.7
    assert rates[1:].tolist() == [0.5, 0.5]


def test_level_0_misses_nobody_but_the_invisible_and_levels_nest() -> None:
    sightings = crowd(visible=np.tile(np.linspace(0.0, 1.0, 200), 100))
    model = Misses(0.0, autocorrelation=SLOW)
    none, some, more = (model(sightings, 1, STEP, level)[0] for level in (0.0, 0.5, 1.0))
    assert (none == (sightings.visible <= 0.0)).all()
    assert (none <= some).all()
    assert (some <= more).all()


def test_how_well_the_others_are_seen_is_standard_normal() -> None:
    missed, ease = Misses(LOGIT_OF_A_TENTH, autocorrelation=SLOW)(crowd(1000, 50), 1, STEP)
    assert ease[~missed].mean() == pytest.approx(0.0, abs=0.05)
    assert ease[~missed].std() == pytest.approx(1.0, abs=0.05)


def test_vans_are_taken_for_cars_at_their_rate_and_cars_always() -> None:
    confusion = Confusion(van=0.3, truck=0.0, autocorrelation=Autocorrelation((1.0,), (5.0,)))
    assert confusion(crowd(), 1, STEP).all()
    assert not confusion(crowd(kind="Truck"), 1, STEP).any()
    taken = by_object(confusion(crowd(2000, 30, kind="Van"), 1, STEP), 2000)
    assert taken.mean() == pytest.approx(0.3, abs=0.03)
    assert lag_one(taken.astype(float)) > 0.8


@pytest.mark.parametrize(
    ("make", "told"),
    [
        (lambda: Misses(0.0, shared=1.5), "rates lie in"),
        (lambda: Misses(0.0, by_visible=(0.0,)), "give 4"),
        (lambda: Misses(0.0, truncation_by_height=(0.0,)), "give 3"),
        (lambda: Misses(0.0, flutter=(0.0, 0.0, 0.0, 1.5)), "rates lie in"),
        (lambda: Misses(float("nan")), "not finite"),
        (lambda: Misses(0.0, shared_seconds=-1.0), "0 \\(none\\)"),
        (lambda: Confusion(van=-0.1), "rates lie in"),
    ],
)
def test_what_no_detector_does_is_refused(make, told) -> None:
    with pytest.raises(BadConfig, match=told):
        make()
