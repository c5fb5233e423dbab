"""Edges are off as the noise says: spread, mean, growth, correlation, memory."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mot_sim.simulation.sensors import Autocorrelation
from mot_sim.simulation.sensors.jitter import (
    EdgeNoise,
    Jitter,
    edge_errors,
    edges_of_centre,
    move_edges,
)
from mot_sim.simulation.sensors.profile import read_profile
from tests.mot_sim.simulation.sensors.sights import STEP, by_object, crowd, lag_one
from tracker.errors import BadConfig, UnknownName

SLOW = Autocorrelation((1.0,), (1.0,))


def sure(sightings):
    """Full scores."""
    return np.ones(len(sightings))


def test_level_0_and_no_spread_give_the_very_same_boxes() -> None:
    sightings = crowd()
    jitter = Jitter(left=EdgeNoise(0.1, bias=0.1))
    assert jitter(sightings.boxes, sightings, sure(sightings), 1, STEP, 0.0) is sightings.boxes
    assert Jitter()(sightings.boxes, sightings, sure(sightings), 1, STEP) is sightings.boxes


def test_unsure_boxes_are_off_further() -> None:
    sightings = crowd(300, 20)
    jitter = Jitter(left=EdgeNoise(0.05, unsure=2.0))
    scores = np.where(np.arange(len(sightings)) % 2 == 0, 1.0, 0.5)
    errors = edge_errors(jitter(sightings.boxes, sightings, scores, 1, STEP), sightings.boxes)
    ratio = errors[scores < 1.0, 0].std() / errors[scores == 1.0, 0].std()
    assert ratio == pytest.approx(np.exp(2.0 * 0.5**0.25), rel=0.08)


def test_boxes_jump_where_scores_fall_and_rise() -> None:
    sightings = crowd(300, 60)
    part = EdgeNoise(0.03, autocorrelation=SLOW)
    jitter = Jitter(part, part, part, part, unsure_own=0.5)
    scores = np.where(sightings.frames // 10 % 2 == 0, 0.95, 0.85)
    moved = jitter(sightings.boxes, sightings, scores, 1, STEP)
    errors = by_object(edge_errors(moved, sightings.boxes)[:, 0], 300)
    changes = np.square(np.diff(errors, axis=0)).mean(axis=1) / 0.03**2
    at_turns = np.arange(9, 59, 10)
    steady = 2.0 * (1.0 - SLOW.correlation(STEP))
    assert changes[at_turns].mean() == pytest.approx(
        2.0 - 0.5**0.5 * (2.0 - steady), abs=0.1
    )  # each keeps half of its variance
    assert np.delete(changes, at_turns).mean() == pytest.approx(steady, rel=0.1)
    assert errors.std(axis=1) == pytest.approx(np.full(60, 0.03), rel=0.15)


def test_edges_are_off_by_their_own_spread_and_mean() -> None:
    sightings = crowd(500, 100)
    jitter = Jitter(
        EdgeNoise(0.03, bias=0.02), EdgeNoise(0.05, bias_pixels=1.0), EdgeNoise(0.1),
        EdgeNoise(0.02, bias=-0.03), horizontal=0.6, vertical=-0.4,
    )  # fmt: skip
    errors = edge_errors(
        jitter(sightings.boxes, sightings, sure(sightings), 1, STEP), sightings.boxes
    )
    np.testing.assert_allclose(errors.std(axis=0), [0.03, 0.05, 0.1, 0.02], rtol=0.06)
    pixel = float(np.mean(1.0 / sightings.height))
    np.testing.assert_allclose(errors.mean(axis=0), [0.02, pixel, 0.0, -0.03], atol=0.004)
    together = np.corrcoef(errors.T)
    assert together[0, 2] == pytest.approx(0.6, abs=0.03)
    assert together[1, 3] == pytest.approx(-0.4, abs=0.05)
    assert abs(together[0, 1]) < 0.03


def test_errors_remember_and_grow_with_what_hides() -> None:
    part = EdgeNoise(0.03, hidden=2.0, autocorrelation=SLOW)
    open_cars, hidden = crowd(visible=0.95), crowd(visible=0.45)
    errors = [
        by_object(edge_errors(Jitter(left=part)(s.boxes, s, sure(s), 1, STEP), s.boxes)[:, 0])
        for s in (open_cars, hidden)
    ]
    assert lag_one(errors[0]) == pytest.approx(np.exp(-0.1), abs=0.02)
    np.testing.assert_allclose(errors[1], np.e * errors[0])


def test_errors_grow_with_size_and_with_its_extremes() -> None:
    part = EdgeNoise(1.0, by_height=-0.5, by_extremes=0.3)
    visible, height = np.full(3, 0.95), np.array([25.0, 50.0, 100.0])
    far = np.exp(0.3 * np.log(2.0) ** 2)
    np.testing.assert_allclose(
        part.growth(visible, height, np.ones(3)), [2**0.5 * far, 1.0, 2**-0.5 * far]
    )


def test_tails_and_skew_have_the_promised_quantiles() -> None:
    part = EdgeNoise(1.0, tail=0.8, skew=0.1)
    x = np.array([-2.0, 0.0, 2.0])
    np.testing.assert_allclose(part.shape(x), np.sinh(0.8 * x) / 0.8 + 0.1 * (x**2 - 1.0))


@given(st.floats(0.0, 5.0), st.floats(0.0, 3.0), st.floats(0.0, 1.5))
def test_boxes_never_turn_inside_out(level: float, spread: float, tail: float) -> None:
    sightings = crowd(20, 5)
    part = EdgeNoise(spread, tail=tail)
    boxes = Jitter(part, part, part, part)(
        sightings.boxes, sightings, sure(sightings), 2, STEP, level
    )
    assert (boxes[:, 2:] > boxes[:, :2]).all()


def test_moving_and_measuring_are_inverse() -> None:
    boxes = crowd(5, 1).boxes
    moved = move_edges(boxes, np.full((5, 4), 0.1))
    np.testing.assert_allclose(edge_errors(moved, boxes), 0.1)


def test_errors_of_centre_and_size_become_those_of_edges() -> None:
    sightings = crowd(500, 100)
    left, right, together = edges_of_centre(EdgeNoise(0.03, bias=0.01), EdgeNoise(0.04, bias=0.02))
    boxes = Jitter(left=left, right=right, horizontal=together)(
        sightings.boxes, sightings, sure(sightings), 1, STEP
    )
    errors = edge_errors(boxes, sightings.boxes)
    centre, size = 0.5 * (errors[:, 0] + errors[:, 2]), errors[:, 2] - errors[:, 0]
    assert centre.std() == pytest.approx(0.03, rel=0.05)
    assert size.std() == pytest.approx(0.04, rel=0.05)
    assert (centre.mean(), size.mean()) == pytest.approx((0.01, 0.02), abs=0.003)


def test_a_profile_of_version_1_has_edges(tmp_path) -> None:
    path = tmp_path / "old.toml"
    path.write_text("version = 1\n[jitter.x]\nspread = 0.03\n[jitter.width]\nspread = 0.04\n")
    jitter = read_profile(path).jitter
    assert jitter is not None
    assert jitter.left.spread == pytest.approx(np.hypot(0.03, 0.02))
    assert jitter.upper.spread == 0.0
    path.write_text("version = 1\n[jitter.z]\nspread = 0.03\n")
    with pytest.raises(UnknownName, match="'z'"):
        read_profile(path)


@pytest.mark.parametrize("make", [lambda: EdgeNoise(-0.1), lambda: Jitter(vertical=1.5)])
def test_what_no_noise_can_be_is_refused(make) -> None:
    with pytest.raises(BadConfig, match="jitter"):
        make()


def test_held_errors_stay_and_jump_together() -> None:
    sightings = crowd(200, 60)
    part = EdgeNoise(0.03, autocorrelation=SLOW)
    moving = Jitter(part, part, part, part)
    held = replace(moving, hold=0.3)
    errors, free = (
        edge_errors(each(sightings.boxes, sightings, sure(sightings), 1, STEP), sightings.boxes)
        for each in (held, moving)
    )
    assert errors.std(axis=0) == pytest.approx(free.std(axis=0), rel=0.05)
    stays = np.abs(np.diff(by_object(errors[:, 0]), axis=0)) < 1e-9
    assert stays.mean() == pytest.approx(np.exp(-STEP / 0.3), abs=0.06)
    assert (stays == (np.abs(np.diff(by_object(errors[:, 3]), axis=0)) < 1e-9)).all()
    trembling = replace(held, unsteady=0.1)(sightings.boxes, sightings, sure(sightings), 1, STEP)
    changes = np.diff(by_object(edge_errors(trembling, sightings.boxes)[:, 0]), axis=0)
    assert np.median(np.abs(changes)) == pytest.approx(0.03 * 0.67 * 0.2**0.5, rel=0.5)


def test_held_errors_hang_on_object_and_frame_alone() -> None:
    sightings = crowd(5, 40)
    part = EdgeNoise(0.03, autocorrelation=SLOW)
    jitter = Jitter(part, part, part, part, hold=0.3, unsteady=0.1)
    whole = jitter(sightings.boxes, sightings, sure(sightings), 1, STEP)
    rows = np.flatnonzero(sightings.frames == 33)
    alone = sightings.select(rows)
    assert (jitter(alone.boxes, alone, sure(alone), 1, STEP) == whole[rows]).all()
