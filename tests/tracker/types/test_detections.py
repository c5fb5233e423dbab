"""Detections: what no detector can mean is refused, with the row."""

import numpy as np
import pytest

from tracker.errors import BadDetections
from tracker.types import Detections

GOOD = [[0.0, 0.0, 10.0, 10.0], [5.0, 5.0, 20.0, 30.0]]


def test_lists_become_columns() -> None:
    detections = Detections.of([[0, 0, 10, 10], [5, 5, 20, 30]], [1, 0])
    np.testing.assert_array_equal(detections.boxes, GOOD)
    assert detections.scores.tolist() == [1.0, 0.0]
    assert detections.yaw is None


def test_scores_default_to_one() -> None:
    assert Detections.of(GOOD).scores.tolist() == [1.0, 1.0]


def test_boxes_without_area_are_allowed() -> None:
    assert len(Detections.of([[3.0, 3.0, 3.0, 3.0]])) == 1


@pytest.mark.parametrize(
    ("boxes", "scores", "told"),
    [
        ([GOOD[0], [5, np.nan, 20, 30]], [1, 1], r"box 1 is not finite: \[5\.0, nan"),
        ([GOOD[0], [5, 5, np.inf, 30]], [1, 1], r"box 1 is not finite.*inf"),
        (GOOD, [np.nan, 1], r"box 0 is not finite.*score nan"),
        (GOOD, [1, -np.inf], r"box 1 is not finite.*score -inf"),
        ([[10, 0, 0, 10]], [1], r"box 0 is inverted: \[10\.0, 0\.0, 0\.0, 10\.0\].*x_min"),
        ([GOOD[0], [0, 10, 10, 9]], [1, 1], r"box 1 is inverted"),
        (GOOD, [1, 1, 1], r"2 boxes but 3 scores"),
        ([], [1], r"0 boxes but 1 scores"),
        ([[0, 0, 10, 10, 0.9]] * 4, [1] * 5, r"shape \(4, 5\).*x_min"),
        ([1, 2, 3], [1], r"shape \(3,\)"),
    ],
)
@pytest.mark.unchecked
def test_bad_detections_are_refused_with_their_row(boxes, scores, told) -> None:
    with pytest.raises(BadDetections, match=told):
        Detections.of(boxes, scores)


@pytest.mark.unchecked
def test_cues_need_a_row_for_every_box() -> None:
    with pytest.raises(BadDetections, match="2 boxes but 1 yaw"):
        Detections.of(GOOD, yaw=np.zeros(1))


def test_a_cue_may_be_missing_for_some_boxes() -> None:
    assert np.isnan(Detections.of(GOOD, yaw=np.array([0.1, np.nan])).yaw).tolist() == [False, True]


@pytest.mark.parametrize("nothing", [[], np.zeros((0, 4)), Detections.empty().boxes])
def test_nothing_detected_is_an_empty_table(nothing) -> None:
    detections = Detections.of(nothing)
    assert len(detections) == 0
    assert detections.boxes.shape == (0, 4)
    assert detections.scores.shape == (0,)


@pytest.mark.parametrize("dtype", [np.int64, np.float32, np.uint16, list])
@pytest.mark.unchecked
def test_the_constructor_converts_what_is_like_an_array(dtype) -> None:
    boxes = GOOD if dtype is list else np.array(GOOD).astype(dtype)
    scores = [1, 0] if dtype is list else np.array([1, 0], dtype)
    taken = Detections(boxes, scores, yaw=[0, 1])
    assert taken.boxes.dtype == taken.scores.dtype == taken.yaw.dtype == np.float64
    np.testing.assert_array_equal(taken.boxes, GOOD)


@pytest.mark.parametrize(
    ("columns", "told"),
    [
        ({"boxes": [["a", "b", "c", "d"]] * 2}, "boxes: values of type"),
        ({"boxes": [GOOD[0], [1, 2, 3]]}, "boxes: .*give an array of numbers"),
        ({"boxes": np.array(GOOD).ravel()}, r"boxes of shape \(8,\)"),
        ({"boxes": [GOOD[0], [5, np.nan, 20, 30]]}, "box 1 is not finite"),
        ({"boxes": [GOOD[0], [20, 5, 5, 30]]}, "box 1 is inverted"),
        ({"scores": [1.0]}, "2 boxes but 1 scores"),
        ({"scores": 1.0}, "2 boxes but one value for the scores"),
        ({"scores": np.ones((2, 1))}, r"scores of shape \(2, 1\)"),
        ({"size": np.ones((3, 3))}, "2 boxes but 3 size"),
        ({"descriptor": "none"}, "descriptor: values of type"),
    ],
)
@pytest.mark.unchecked
def test_the_constructor_refuses_what_no_detector_means(columns, told: str) -> None:
    with pytest.raises(BadDetections, match=told):
        Detections(**{"boxes": np.array(GOOD), "scores": np.ones(2), **columns})
