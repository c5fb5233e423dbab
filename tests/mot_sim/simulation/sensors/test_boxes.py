"""Jitter, occlusion-fitted boxes, the border, second boxes, merges, splits."""

import numpy as np
import pytest

from mot_sim.simulation.sensors.boxes import (
    Border,
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
    crowd,
    sightings_of,
)
from tracker.errors import BadConfig
from tracker.geometry import box_iou

SLOW = Autocorrelation((1.0,), (1.0,))


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
    double = Duplicates((0.0, 0.0, 0.0, 0.2), (0.0,) * 4, dx=(0.3,), autocorrelation=SLOW)
    sightings = crowd(1000, 40, visible=0.95)
    seen = np.zeros(len(sightings), bool)
    rows, boxes, scores = double(sightings, sightings.boxes, seen, 1, STEP)
    assert len(rows) / len(sightings) == pytest.approx(0.2, abs=0.02)
    np.testing.assert_allclose(box_iou(boxes, sightings.boxes[rows]), 0.7 / 1.3)
    assert (scores == 0.5).all()
    assert not len(double(sightings, sightings.boxes, ~seen, 1, STEP)[0])
    assert not len(double(sightings, sightings.boxes, seen, 1, STEP, 0.0)[0])


def test_second_boxes_are_whole_examples_beside_the_first_box() -> None:
    double = Duplicates(
        (0.0, 0.0, 0.0, 0.5), (0.0,) * 4, dx=(0.1, 0.4), dy=(0.0, 0.2), dw=(0.0, -0.5),
        dh=(0.0, 0.3), log_odds=(3.0, -1.0),
    )  # fmt: skip
    sightings = crowd(200, 20, visible=0.95)
    first, seen = sightings.boxes + 5.0, np.zeros(len(sightings), bool)
    rows, boxes, scores = double(sightings, first, seen, 1, STEP)
    moves = box_errors(boxes, first[rows])
    sure = scores > 0.5
    assert 0.3 < sure.mean() < 0.7
    np.testing.assert_allclose(
        moves[sure], np.tile([0.1, 0.0, 0.0, 0.0], (sure.sum(), 1)), atol=1e-9
    )


def test_a_box_that_jumps_may_be_left_behind() -> None:
    sightings = crowd(200, 20, visible=0.95)
    double = Duplicates(dx=(0.1, 0.2), dy=(0.0,) * 2, dw=(0.0,) * 2, dh=(0.0,) * 2,
                        log_odds=(2.0, -2.0), at_jumps=0.5, at_unsure_jumps=1.0)  # fmt: skip
    sure = np.ones(len(sightings))
    before = sightings.boxes.copy()
    jumped = sightings.ids % 2 == 0
    before[jumped] += 12.0
    chosen = double.may_be_left_behind(sightings, sure, 1)
    assert len(chosen) / len(sightings) == pytest.approx(0.5, abs=0.02)
    some, boxes = sightings.select(chosen), sightings.boxes[chosen]
    rows, scores = double.left_behind(some, boxes, before[chosen], 1)
    assert rows.tolist() == np.flatnonzero(jumped[chosen]).tolist()
    assert set(scores.round(3)) == {0.119, 0.881}
    assert not len(double.may_be_left_behind(sightings, sure, 1, 0.0))
    assert len(double.may_be_left_behind(sightings, 0.8 * sure, 1)) == len(sightings)


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
        lambda: VisiblePart(1.5),
        lambda: Merges(2.0),
        lambda: Splits(-0.5),
        lambda: Border(-1.0),
        lambda: Quantiles((1.0, 0.0)),
        lambda: Duplicates((0.0, 0.0, 0.0, 2.0), (0.0,) * 4),
        lambda: Duplicates(dx=(0.1, 0.2)),
    ],
)
def test_what_no_detector_does_is_refused(make) -> None:
    with pytest.raises(BadConfig):
        make()
