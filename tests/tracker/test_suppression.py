"""Which detections reach the tracker."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.tracker.samples import LEVEL, locked
from tracker.errors import BadConfig
from tracker.suppression import Suppression
from tracker.types import Detections

A, NEARLY_A, B = [100.0, 100, 200, 200], [104.0, 100, 204, 200], [400.0, 100, 500, 200]
POINT, LINE = [300.0, 50, 300, 50], [310.0, 50, 310, 90]


def kept(boxes: list, scores: list[float], suppress: Suppression) -> list[int]:
    """The numbers of the boxes that are left."""
    numbers = np.arange(len(boxes)) * 1.0
    detections = Detections(np.array(boxes).reshape(-1, 4), np.array(scores) * 1.0, yaw=numbers)
    return suppress(locked(detections), LEVEL).yaw.astype(int).tolist()


def test_of_two_that_overlap_the_stronger_is_kept_and_the_order_too() -> None:
    assert kept([A, B, NEARLY_A], [0.5, 0.6, 0.9], Suppression()) == [1, 2]
    assert kept([A, B, NEARLY_A], [0.9, 0.6, 0.5], Suppression()) == [0, 1]


def test_at_equal_scores_the_earlier_is_kept() -> None:
    assert kept([A, NEARLY_A, A], [0.7, 0.7, 0.7], Suppression()) == [0]


def test_a_suppressed_box_suppresses_nobody() -> None:
    """The middle one overlaps both others by 60 %, which overlap each other by 33 %."""
    chain = [[0.0, 0, 100, 100], [25.0, 0, 125, 100], [50.0, 0, 150, 100]]
    assert kept(chain, [0.9, 0.8, 0.7], Suppression(max_iou=0.5)) == [0, 2]


def test_boxes_that_overlap_less_than_the_limit_are_both_kept() -> None:
    iou = 96 / 104
    assert kept([A, NEARLY_A], [0.9, 0.8], Suppression(max_iou=iou + 0.01)) == [0, 1]
    assert kept([A, NEARLY_A], [0.9, 0.8], Suppression(max_iou=iou - 0.01)) == [0]


def test_scores_from_the_least_on_are_kept() -> None:
    assert kept([A, B], [0.3, 0.29], Suppression(min_score=0.3)) == [0]


def test_a_box_below_the_least_score_suppresses_nobody() -> None:
    assert kept([A, NEARLY_A], [0.3, 0.2], Suppression(min_score=0.25)) == [0]
    assert kept([NEARLY_A, A], [0.2, 0.3], Suppression(min_score=0.25)) == [1]


def test_boxes_without_area_in_the_image_go() -> None:
    outside = [[-50.0, 10, -20, 60], [1300.0, 10, 1400, 60], [10.0, 400, 60, 500]]
    assert kept([POINT, A, LINE, *outside], [1.0] * 6, Suppression()) == [1]


def test_boxes_without_area_do_not_hide_that_others_overlap() -> None:
    assert kept([A, NEARLY_A, POINT, LINE], [0.9, 0.8, 0.9, 0.9], Suppression()) == [0]


def test_nothing_stays_nothing() -> None:
    assert len(Suppression()(Detections.empty(), LEVEL)) == 0


@given(st.integers(0, 10_000), st.integers(0, 12), st.floats(0.1, 1.0))
def test_what_is_left_overlaps_no_more_than_the_limit(seed, n, max_iou) -> None:
    rng = np.random.default_rng(seed)
    corners = rng.uniform(0, 60, (n, 2))
    boxes = np.concatenate((corners, corners + rng.uniform(0, 60, (n, 2))), axis=1)
    detections = Detections(boxes, rng.choice([0.3, 0.5, 0.9], n))
    left = Suppression(max_iou=max_iou)(detections, LEVEL)
    again = Suppression(max_iou=max_iou)(left, LEVEL)
    np.testing.assert_array_equal(again.boxes, left.boxes)
    if n:
        assert left.scores.max() == detections.scores.max()


@pytest.mark.parametrize("n", [1, 2, 3])
def test_boxes_far_apart_are_handed_on_in_arrays_of_their_own(n: int) -> None:
    boxes = np.array([[100.0 * i, 10, 100.0 * i + 50, 60] for i in range(n)])
    detections = Detections(boxes, np.ones(n))
    kept = Suppression()(detections, LEVEL)
    np.testing.assert_array_equal(kept.boxes, boxes)
    assert not np.shares_memory(kept.boxes, boxes)
    assert not np.shares_memory(kept.scores, detections.scores)


def test_two_sure_boxes_stay_unless_they_overlap_more() -> None:
    iou = 96 / 104
    above, below = (Suppression(max_iou_of_sure=iou + each) for each in (0.01, -0.01))
    assert kept([A, NEARLY_A], [0.95, 0.9], above) == [0, 1]
    assert kept([A, NEARLY_A], [0.95, 0.9], below) == [0]
    assert kept([A, NEARLY_A], [0.95, 0.9], replace(above, sure_score=0.94)) == [0]


def test_a_sure_box_suppresses_one_that_is_not() -> None:
    assert kept([A, NEARLY_A], [0.89, 0.95], Suppression(max_iou_of_sure=1.0)) == [1]


def test_boxes_that_score_alike_are_as_sure_of_one_as_of_the_other() -> None:
    assert kept([A, NEARLY_A], [0.5, 0.5], Suppression(max_iou_of_sure=1.0)) == [0, 1]
    assert kept([A, NEARLY_A], [0.5, 0.5], Suppression(max_iou_of_sure=0.9)) == [0]


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"max_iou": -0.1}, "max_iou -0.1"),
        ({"max_iou": 0.7, "max_iou_of_sure": 0.6}, "not the smaller one"),
        ({"max_iou_of_sure": 1.1}, "in 0..1"),
        ({"max_iou": float("nan")}, "max_iou nan"),
        ({"sure_score": float("nan")}, "sure_score nan"),
        ({"min_score": float("nan")}, "min_score nan"),
    ],
)
def test_limits_that_cannot_be_are_refused(given: dict[str, float], words: str) -> None:
    with pytest.raises(BadConfig, match=words):
        Suppression(**given)
