"""Scores on any scale, and none: what the boxes say of them."""

from collections.abc import Callable

import numpy as np
import pytest
from numpy import ndarray as Array

from tracker import Camera, Detections, Frame, Tracker, Tracks
from tracker.errors import BadConfig
from tracker.multi_frame import NetworkFlow, Window
from tracker.score_scale import JUDGED_AT, ScoreMemory, ScoreScale, separation

K = np.array([[721.5, 0.0, 609.6], [0.0, 721.5, 172.9], [0.0, 0.0, 1.0]])
CAMERA = Camera.mounted(K, (1242, 375), 1.65)
SCALES: dict[str, Callable[[Array], Array]] = {
    "percent": lambda scores: 100.0 * scores,
    "logits": lambda scores: np.log(scores / (1.0 - scores)),
    "logarithms": np.log,
    "tenths": lambda scores: 0.1 * scores,
    **{f"all {v}": (lambda scores, v=v: np.full(len(scores), v)) for v in (0.05, 0.25, 0.5, 1.0)},
}


def drive(scale: Callable[[Array], Array] = np.array, frames: int = 40) -> list[Frame]:
    """Four cars that stay, with high scores, and false boxes that vanish, with low ones."""
    rng = np.random.default_rng(0)
    found = []
    for index in range(frames):
        cars = np.array([[100.0 + 200 * car, 180, 180 + 200 * car, 230] for car in range(4)])
        false = np.column_stack((rng.uniform(0, 1100, 2), rng.uniform(180, 250, 2)))
        boxes = np.vstack((cars + 0.5 * index, np.hstack((false, false + (60.0, 40.0)))))
        scores = np.concatenate((rng.uniform(0.82, 0.98, 4), rng.uniform(0.02, 0.2, 2)))
        detections = Detections(boxes, scale(scores))
        found.append(Frame(index, 0.1 * index, detections, T_now_before=np.eye(4)))
    return found


def rows_of(tracker: Tracker | Window | NetworkFlow, frames: list[Frame]) -> Tracks:
    """All rows of a drive."""
    parts = [tracker.step(frame) for frame in frames]
    if not isinstance(tracker, Tracker):
        parts.append(tracker.finish())
    return Tracks.concatenate(parts)


def cars_of(rows: Tracks) -> int:
    """In how many frames a car of the drive has a row, out of 160."""
    at = (rows.boxes[:, 0] - 0.5 * rows.frames - 100.0) / 200.0
    return int((np.abs(at - np.round(at)) < 0.03).sum())


@pytest.mark.parametrize("name", SCALES)
def test_cars_that_stay_are_tracked_whatever_their_scores_say(name: str) -> None:
    plain = rows_of(Tracker.default(CAMERA), drive())
    rows = rows_of(Tracker.default(CAMERA), drive(SCALES[name]))
    assert cars_of(plain) == 160
    assert cars_of(rows) >= 145
    if not name.startswith("all"):  # the scores tell false boxes from cars
        assert len(rows) - cars_of(rows) <= 6


@pytest.mark.parametrize("make", [Window, NetworkFlow])
@pytest.mark.parametrize("name", ["percent", "all 0.25"])
def test_so_they_are_by_trackers_that_look_ahead(
    make: Callable[[Tracker], Window | NetworkFlow], name: str
) -> None:
    rows = rows_of(make(Tracker.default(CAMERA)), drive(SCALES[name]))
    assert cars_of(rows) >= 145


def test_probabilities_are_taken_as_they_are() -> None:
    scale, memory = ScoreScale(), ScoreMemory()
    for frame in drive(frames=400):
        memory = scale.watch(memory, frame.detections)
        assert memory.judgement == ""
        assert scale(memory, frame.detections) is frame.detections
    assert memory.watched >= JUDGED_AT[-1]
    assert memory.watched < JUDGED_AT[-1] + 10  # no more are kept
    assert len(memory.confirmed) + len(memory.vanished) == memory.watched


def test_boxes_are_confirmed_by_those_of_the_next_frame_alone() -> None:
    here, moved, far = [0.0, 0, 10, 10], [1.0, 0, 11, 10], [50.0, 0, 60, 10]
    scale, memory = ScoreScale(), ScoreMemory()
    drives: list[tuple[list[list[float]], list[float]]] = [
        ([here, far], [0.1, 0.2]), ([moved], [0.3]), ([], []), ([moved], [0.4]),
        ([far, here, moved], [0.5, 0.6, 0.7]),
    ]  # fmt: skip
    for boxes, scores in drives:
        memory = scale.watch(memory, Detections.of(boxes, scores))
    memory = memory.told_apart()
    assert memory.confirmed.tolist() == [0.1, 0.4]
    assert memory.vanished.tolist() == [0.2, 0.3]
    assert memory.watched == 4
    for _ in range(200):  # frames without boxes are forgotten
        memory = scale.watch(memory, Detections.empty())
    assert len(memory.frames) < 100
    assert memory.vanished.tolist() == [0.2, 0.3, 0.5, 0.6, 0.7]


def test_scores_that_say_nothing_count_the_same() -> None:
    rng, scale, memory = np.random.default_rng(1), ScoreScale(), ScoreMemory()
    for frame in drive(rng.permutation, 100):
        memory = scale.watch(memory, frame.detections)
    assert memory.judgement == "even"
    assert set(scale(memory, frame.detections).scores) == {scale.strong}


def test_low_scores_of_boxes_that_vanish_are_believed() -> None:
    rng, scale, memory = np.random.default_rng(1), ScoreScale(), ScoreMemory()
    for _ in range(100):
        left = rng.uniform(0, 1000, (4, 1))
        boxes = np.hstack((left, left * 0 + 100, left + 50, left * 0 + 150))
        memory = scale.watch(memory, Detections(boxes, rng.uniform(0.05, 0.2, 4)))
    assert memory.judgement == ""


def test_a_single_weak_box_is_no_scale() -> None:
    memory = ScoreScale().watch(ScoreMemory(), Detections.of([[10.0, 10, 50, 50]], [0.3]))
    assert memory.judgement == ""


def test_what_is_remembered_is_no_part_of_the_frame() -> None:
    frame = drive(frames=1)[0]
    memory = ScoreScale().watch(ScoreMemory(), frame.detections)
    boxes, scores = (column.copy() for column in memory.frames[-1])
    frame.detections.boxes[:] = 0.0
    frame.detections.scores[:] = 0.0
    assert (memory.frames[-1][0] == boxes).all()
    assert (memory.frames[-1][1] == scores).all()


def test_separation_is_a_half_by_chance_and_one_where_scores_tell() -> None:
    rng = np.random.default_rng(0)
    same, other = rng.normal(size=(2, 2000))
    assert separation(same, other) == pytest.approx(0.5, abs=0.03)
    assert separation(same + 10.0, other) > 0.99
    assert separation(np.ones(500), np.ones(500)) == pytest.approx(0.5, abs=0.01)


@pytest.mark.parametrize(
    "wrong", [{"strong": 0.0}, {"least_strong": 2.0}, {"least_separation": 0.4}]
)
def test_shares_that_are_none_are_refused(wrong: dict[str, float]) -> None:
    with pytest.raises(BadConfig):
        ScoreScale(**wrong)
