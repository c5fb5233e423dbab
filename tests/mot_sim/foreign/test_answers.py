"""What trackers answer: every form that is read, and what is wrong with the others."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from mot_sim.foreign.answers import BadRows, tracks_from
from tracker import Detections, Frame, Tracks

# Three cars; the first is at the left edge, where a width is more than x_min.
BOXES = np.array([[10.0, 180, 90, 240], [500, 190, 560, 230], [700, 170, 790, 235]])
FRAME = Frame(3, 0.3, Detections.of(BOXES))
XYWH = np.column_stack((BOXES[:, :2], BOXES[:, 2:] - BOXES[:, :2]))
CXCYWH = np.column_stack((0.5 * (BOXES[:, :2] + BOXES[:, 2:]), XYWH[:, 2:]))
IDS = np.array([4, 5, 6])


def rows(boxes: np.ndarray, ids: object = IDS) -> np.ndarray:
    return np.column_stack((boxes, ids))


def of_supervision(ids: Any, boxes: np.ndarray = BOXES) -> SimpleNamespace:
    return SimpleNamespace(xyxy=boxes, tracker_id=ids, confidence=np.full(len(boxes), 0.5))


@pytest.mark.parametrize(
    "answer",
    [
        rows(BOXES),
        rows(BOXES).tolist(),
        np.column_stack((rows(BOXES), np.ones(3), np.zeros(3))),
        (IDS, BOXES),
        (IDS.tolist(), BOXES.tolist()),
        (IDS.astype(object), BOXES.astype(object)),
        (row for row in rows(BOXES)),
        of_supervision(IDS),
        Tracks(np.full(3, 3), IDS, BOXES, np.ones(3)),
    ],
)
def test_every_form_gives_the_same_rows(answer: Any) -> None:
    found = tracks_from(answer, FRAME)
    assert (found.frames.tolist(), found.ids.tolist()) == ([3, 3, 3], [4, 5, 6])
    assert found.boxes.tolist() == BOXES.tolist()


@pytest.mark.parametrize(
    "answer",
    [[], np.zeros((0, 5)), np.zeros((0, 7)), ([], []), of_supervision(None, np.zeros((0, 4)))],
)
def test_no_rows_are_an_answer_too(answer: Any) -> None:
    assert len(tracks_from(answer, FRAME)) == 0


def test_detections_without_a_name_are_left_out() -> None:
    found = tracks_from(of_supervision(np.array([4, -1, 6])), FRAME)
    assert (found.ids.tolist(), found.scores.tolist()) == ([4, 6], [0.5, 0.5])


@pytest.mark.unchecked
@pytest.mark.parametrize(
    ("answer", "told"),
    [
        (None, "gave a NoneType, not Tracks: give Tracks, rows x_min"),
        (7, "gave a int, not Tracks"),
        (rows(XYWH), r"x_max < x_min in 2 of 3 rows \(row 1: 500 190 60 40\): xywh\? give"),
        (rows(CXCYWH), r"x_max < x_min in 2 of 3 rows \(row 1: .*\): cxcywh\? give"),
        ((IDS, XYWH), r"xywh\? give"),
        (rows(BOXES[:, [2, 1, 0, 3]]), r"x_max < x_min in 3 of 3 .*xywh or cxcywh\?"),
        (rows(BOXES[:, [0, 3, 2, 1]]), r"y_max < y_min in 3 of 3 rows"),
        (rows(BOXES / [1242, 375, 1242, 375]), r"lie in 0\.\.1 \(row 0: .*\): normalised boxes\?"),
        (rows(XYWH / [1242, 375, 1242, 375]), r"normalised boxes\?"),
        (BOXES, r"shape \(3, 4\), not n rows of box and id: no ids"),
        (rows(BOXES)[0], r"shape \(5,\), not n rows"),
        (rows(BOXES, [4, 5, 6.5]), "ids that are no whole numbers, in row 2: 6.5"),
        (rows(BOXES, [4, np.nan, 6]), "ids that are no whole numbers, in row 1: nan"),
        ([[1.0, 2, 3, 4, 7], [1.0, 2, 3, 4, "car-1"]], "row 1: id 'car-1' is no number"),
        ([[1.0, 2, 3, 4, 7], [1.0, 2, 3, 4, "8"]], "row 1: id '8' is no number"),
        ([[1.0, 2, 3, 4, 7], [1.0, 2, 3]], "row 1 has 3 columns, not x_min, y_min, x_max"),
        ([[1.0, 2, None, 4, 7]], "row 0: x_max 'None' is no number"),
        ((["a", "b", "c"], BOXES), "row 0: id 'a' is no number"),
        ((IDS[:2], BOXES), r"ids of shape \(2,\) and boxes of shape \(3, 4\)"),
        (of_supervision(None), "3 rows without tracker_id: no ids"),
    ],
)
def test_what_is_wrong_is_named_with_the_row(answer: Any, told: str) -> None:
    with pytest.raises(BadRows, match=told):
        tracks_from(answer, FRAME)
