"""Jitter, occlusion-fitted boxes, the border, second boxes, merges, splits."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mot_sim.simulation.sensors.boxes import (
    Border,
    Component,
    Jitter,
    VisiblePart,
    box_errors,
    move_boxes,
)
from mot_sim.simulation.sensors.correlated_noise import Autocorrelation
from mot_sim.simulation.sensors.multiplicity import Duplicates, Merges, Splits
from mot_sim.simulation.sensors.quantiles import Quantiles
from tests.mot_sim.simulation.sensors.sights import (
    CAMERA,
    STEP,
    by_object,
    crowd,
    lag_one,
    sightings_of,
)
from tracker.errors import BadConfig
from tracker.geometry import box_iou

SLOW = Autocorrelation((1.0,), (1.0,))


def test_level_0_and_no_spread_give_the_very_same_boxes() -> None:
    sightings = crowd()
    jitter = Jitter(x=Component(0.1, bias=0.1))
    assert jitter(sightings.boxes, sightings, 1, STEP, 0.0) is sightings.boxes
    assert Jitter()(sightings.boxes, sightings, 1, STEP) is sightings.boxes


def test_centre_and_size_are_off_by_their_own_spread_and_bias() -> None:
    sightings = crowd(500, 100)
    jitter = Jitter(
        Component(0.03, bias=0.02), Component(0.05), Component(0.1), Component(0.02, bias=-0.03)
    )
    errors = box_errors(jitter(sightings.boxes, sightings, 1, STEP), sightings.boxes)
    np.testing.assert_allclose(errors.std(axis=0), [0.03, 0.05, 0.1, 0.02], rtol=0.03)
    np.testing.assert_allclose(errors.mean(axis=0), [0.02, 0.0, 0.0, -0.03], atol=0.003)
    assert np.abs(np.corrcoef(errors.T) - np.eye(4)).max() < 0.03


def test_errors_remember_and_grow_with_what_hides() -> None:
    part = Component(0.03, hidden=2.0, autocorrelation=SLOW)
    open_cars, hidden = crowd(visible=0.95), crowd(visible=0.45)
    errors = [
        by_object(box_errors(Jitter(x=part)(s.boxes, s, 1, STEP), s.boxes)[:, 0])
        for s in (open_cars, hidden)
    ]
    assert lag_one(errors[0]) == pytest.approx(np.exp(-0.1), abs=0.02)
    np.testing.assert_allclose(errors[1], np.e * errors[0])


def test_tails_and_skew_have_the_promised_quantiles() -> None:
    part = Component(1.0, tail=0.8, skew=0.1)
    x = np.array([-2.0, 0.0, 2.0])
    np.testing.assert_allclose(part.shape(x), np.sinh(0.8 * x) / 0.8 + 0.1 * (x**2 - 1.0))


@given(st.floats(0.0, 5.0), st.floats(0.0, 3.0), st.floats(0.0, 1.5))
def test_boxes_never_turn_inside_out(level, spread, tail) -> None:
    sightings = crowd(20, 5)
    part = Component(spread, tail=tail)
    boxes = Jitter(part, part, part, part)(sightings.boxes, sightings, 2, STEP, level)
    assert (boxes[:, 2:] > boxes[:, :2]).all()


def test_moving_and_measuring_are_inverse() -> None:
    boxes = crowd(5, 1).boxes
    moved = move_boxes(boxes, *np.full((4, 5), 0.1))
    np.testing.assert_allclose(box_errors(moved, boxes), 0.1)


def test_a_box_around_what_is_visible_has_its_lower_edge_lifted() -> None:
    whole = sightings_of([0, 1], [0, 0])
    seen = whole.boxes.copy()
    seen[:, 3] -= 20.0
    seen[1] = np.nan
    hidden = sightings_of([0, 1], [0, 0], seen=seen)
    assert (VisiblePart(0.0)(hidden) == hidden.boxes).all()
    half = VisiblePart(0.5)(hidden)
    assert half[0, 3] == hidden.boxes[0, 3] - 10.0
    assert (half[1] == hidden.boxes[1]).all()


def test_edges_near_the_border_snap_to_it() -> None:
    boxes = np.array([[3.0, 100.0, 60.0, 200.0], [1100.0, 100.0, 1300.0, 373.0]])
    assert Border()(boxes, CAMERA).tolist() == [[3, 100, 60, 200], [1100, 100, 1241, 373]]
    assert Border(5.0)(boxes, CAMERA).tolist() == [[0, 100, 60, 200], [1100, 100, 1241, 374]]


def test_second_boxes_come_at_their_rate_where_they_should() -> None:
    shifted = Quantiles((0.3, 0.3))
    double = Duplicates((0.0, 0.0, 0.0, 0.2), (0.0,) * 4, dx=shifted, autocorrelation=SLOW)
    sightings = crowd(1000, 40, visible=0.95)
    seen = np.zeros(len(sightings), bool)
    rows, boxes, scores = double(sightings, seen, 1, STEP)
    assert len(rows) / len(sightings) == pytest.approx(0.2, abs=0.02)
    np.testing.assert_allclose(box_iou(boxes, sightings.boxes[rows]), 0.7 / 1.3)
    assert (scores == 0.5).all()
    assert not len(double(sightings, ~seen, 1, STEP)[0])
    assert not len(double(sightings, seen, 1, STEP, 0.0)[0])


def test_two_overlapping_cars_may_share_one_box() -> None:
    sightings = sightings_of([0, 1, 30], [0, 0, 0])
    kept, gone, around = Merges(1.0, 0.3)(sightings, sightings.boxes, 1, STEP)
    assert (kept.tolist(), gone.tolist()) == ([0], [1])
    assert around.tolist() == [[300.0, 170.0, 430.0, 230.0]]
    assert not len(Merges(0.0)(sightings, sightings.boxes, 1, STEP)[0])


def test_wide_boxes_may_fall_in_two() -> None:
    sightings = sightings_of([0, 1], [0, 0], height=[60.0, 150.0])
    rows, left, right = Splits(1.0, 200.0)(sightings, sightings.boxes, 1, STEP)
    assert rows.tolist() == [1]
    assert left[0, 2] == right[0, 0]
    assert (left[0, 0], right[0, 2]) == (sightings.boxes[1, 0], sightings.boxes[1, 2])


@pytest.mark.parametrize(
    "make",
    [
        lambda: Component(-0.1),
        lambda: VisiblePart(1.5),
        lambda: Merges(2.0),
        lambda: Splits(-0.5),
        lambda: Border(-1.0),
        lambda: Quantiles((1.0, 0.0)),
        lambda: Duplicates((0.0, 0.0, 0.0, 2.0), (0.0,) * 4),
    ],
)
def test_what_no_detector_does_is_refused(make) -> None:
    with pytest.raises(BadConfig):
        make()
