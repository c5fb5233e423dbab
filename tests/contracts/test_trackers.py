"""What every tracker of the register promises."""

import copy
import pickle
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from tests.tracker.samples import LEVEL, Car, Drive, drive, locked
from tracker import TRACKERS, Detections, Frame, Tracker, Tracks

every_tracker = pytest.mark.parametrize("name", list(TRACKERS))


@cache
def town() -> Drive:
    """Thirty frames: parked, oncoming and crossing cars, misses, and four empty frames."""
    cars = [
        Car(-4.0, 30.0),
        Car(4.0, 40.0),
        Car(-1.5, 60.0, yaw=np.pi / 2, velocity=(0.0, -6.0)),
        Car(-15.0, 35.0, yaw=0.0, velocity=(9.0, 0.0)),
    ]
    return drive(
        cars,
        lambda t: (0.2 * t, 6.0 * t, 0.05 * np.sin(t)),
        count=30,
        hidden=lambda frame, car: 14 <= frame < 18 or (frame * 7 + car * 3) % 11 == 0,
        score=lambda frame, car: 0.55 + 0.44 * ((frame * 5 + car) % 7) / 6,
    )


def run(tracker: Tracker, seen: Drive, first: int = 0, last: int | None = None) -> list[Tracks]:
    return [tracker.step(frame) for frame in seen.frames[first:last]]


def assert_same(some: list[Tracks], others: list[Tracks]) -> None:
    for one, other in zip(some, others, strict=True):
        for column in ("frames", "ids", "boxes", "scores"):
            np.testing.assert_array_equal(getattr(one, column), getattr(other, column))
        for column in ("base", "yaw", "size"):
            ours, theirs = getattr(one.cuboids, column), getattr(other.cuboids, column)
            np.testing.assert_array_equal(ours, theirs)


@every_tracker
def test_frames_without_detections_give_at_most_predictions_and_the_others_rows(name: str) -> None:
    seen = town()
    rows = run(TRACKERS[name](LEVEL), seen)
    known = {row for tracks in rows[:14] for row in tracks.ids.tolist()}
    assert all(set(tracks.ids.tolist()) <= known for tracks in rows[14:18])
    assert sum(map(len, rows)) > 40
    plain = replace(TRACKERS[name](LEVEL), existence=None)
    assert [len(tracks) for tracks in run(plain, seen)[14:18]] == [0] * 4


@every_tracker
def test_an_id_stands_once_a_frame_and_every_detection_at_most_once(name: str) -> None:
    """Boxes as they are, and nothing predicted: every row is a detection, with its score."""
    seen = town()
    tracker = TRACKERS[name](LEVEL)
    for frame, tracks in zip(seen.frames, run(tracker, seen), strict=True):
        tracks.require_unique_ids()
        assert (tracks.frames == frame.index).all()
    plain = replace(tracker, existence=None, box_filter=None)
    plain.reset()
    for frame, tracks in zip(seen.frames, run(plain, seen), strict=True):
        given = [tuple(box) for box in frame.detections.boxes.tolist()]
        used = [tuple(box) for box in tracks.boxes.tolist()]
        assert len(set(used)) == len(used)
        assert set(used) <= set(given)
        for box, score in zip(used, tracks.scores.tolist(), strict=True):
            assert frame.detections.scores[given.index(box)] == score


@every_tracker
def test_every_row_carries_a_cuboid_near_where_the_car_is(name: str) -> None:
    """Parked 30 m and 40 m ahead of a standing camera; eq. 2 is off by 3 % at most."""
    tracker, places = TRACKERS[name](LEVEL), np.array([[-4.0, 30.0], [4.0, 40.0]])
    for tracks in run(tracker, drive([Car(*place) for place in places.tolist()], count=3)):
        assert len(tracks) == len(tracks.cuboids) == 2
        np.testing.assert_allclose(tracks.cuboids.base[:, ::2], places, rtol=0.05)
    assert len(TRACKERS[name](LEVEL).step(Frame(0, 0.0, Detections.empty())).cuboids) == 0


@every_tracker
def test_the_cuboid_of_a_row_is_what_is_believed_of_its_id(name: str) -> None:
    tracker = TRACKERS[name](LEVEL)
    for frame in town().frames:
        tracks = tracker.step(frame)
        believed = tracker.state.tracks
        rows = np.array([believed.ids.tolist().index(i) for i in tracks.ids.tolist()], np.int64)
        cars = tracker.car_estimates(believed, tracker.state.road)
        assert (cars is None) == (tracks.estimates is None)
        expected = (believed.beliefs.cuboids if cars is None else cars.cuboids()).select(rows)
        np.testing.assert_array_equal(tracks.cuboids.base, expected.base)
        yaw = expected.yaw if tracker.state_assumed else np.full(len(expected), np.nan)
        np.testing.assert_array_equal(tracks.cuboids.yaw, yaw)  # nothing measured it here


@every_tracker
def test_two_trackers_say_the_same_about_the_same(name: str) -> None:
    assert_same(run(TRACKERS[name](LEVEL), town()), run(TRACKERS[name](LEVEL), town()))


@every_tracker
def test_after_a_reset_it_is_as_new(name: str) -> None:
    tracker = TRACKERS[name](LEVEL)
    first = run(tracker, town())
    tracker.reset()
    assert_same(run(tracker, town()), first)
    assert tracker.state.statistics.frames == 30


@every_tracker
@pytest.mark.parametrize("cut", [1, 16, 29])
def test_what_comes_later_changes_nothing_before(name: str, cut: int) -> None:
    whole = run(TRACKERS[name](LEVEL), town())
    assert_same(run(TRACKERS[name](LEVEL), town(), last=cut), whole[:cut])


@every_tracker
def test_frames_are_left_as_they_were(name: str) -> None:
    """Read-only frames are enough: whoever wrote into one would fail."""
    seen = town()
    assert_same(run(TRACKERS[name](LEVEL), locked(seen)), run(TRACKERS[name](LEVEL), town()))


@every_tracker
@pytest.mark.parametrize("keep", [lambda state: state, copy.deepcopy, pickle.dumps])
def test_its_state_can_be_kept_and_given_back(name: str, keep) -> None:
    seen, tracker = town(), TRACKERS[name](LEVEL)
    run(tracker, seen, last=12)
    kept = keep(tracker.state)
    rest = run(tracker, seen, first=12)
    other = TRACKERS[name](LEVEL)
    other.state = pickle.loads(kept) if isinstance(kept, bytes) else kept
    assert_same(run(other, seen, first=12), rest)


@every_tracker
def test_the_clock_and_the_numbers_of_frames_may_start_anywhere(name: str) -> None:
    seen = town()
    later = [replace(f, index=f.index + 1000, time=f.time + 64.0) for f in seen.frames]
    ids = [tracks.ids.tolist() for tracks in run(TRACKERS[name](LEVEL), seen)]
    assert [tracks.ids.tolist() for tracks in run(TRACKERS[name](LEVEL), Drive(later, []))] == ids


@every_tracker
def test_ids_are_given_in_order_from_0_and_never_again(name: str) -> None:
    tracker, known = TRACKERS[name](LEVEL), set()
    for tracks in run(tracker, town()):
        for new in sorted(set(tracks.ids.tolist()) - known):
            assert new == len(known)
            known.add(new)
    assert tracker.state.next_id == len(known)


@every_tracker
def test_what_is_compared_and_explained_shares_nothing_that_can_be_changed(name: str) -> None:
    """Ids of the predicted tracks are the memory's, read-only; boxes of a frame are copies."""
    tracker = replace(TRACKERS[name](LEVEL), explain=True)
    run(tracker, town(), last=5)
    frame = pickle.loads(pickle.dumps(town().frames[5]))
    compared = tracker.cost_matrix(frame)
    with pytest.raises(ValueError, match="read-only"):
        compared.tracks.ids[:] += 1
    tracker.step(frame)
    boxes = tracker.explanation.boxes.copy()
    frame.detections.boxes[:] += 50.0
    np.testing.assert_array_equal(tracker.explanation.boxes, boxes)


@every_tracker
def test_what_nothing_looked_at_is_no_evidence(name: str) -> None:
    """Memory stays as it was, but for the clock: no miss, no rate of the detector."""
    tracker, seen = TRACKERS[name](LEVEL), town()
    run(tracker, seen, last=5)
    before = tracker.state
    rows = [tracker.step(replace(frame, detections=None)) for frame in seen.frames[5:9]]
    assert all(len(each) for each in rows)
    assert tracker.state.tracks is before.tracks
    assert tracker.state.detector == before.detector
    assert tracker.state.gains is before.gains
    assert tracker.state.statistics.frames == 9
    for each in rows:
        assert set(each.ids.tolist()) <= set(before.tracks.ids.tolist())


@every_tracker
def test_a_second_that_nothing_looked_at_ends_no_track_a_missed_one_does(name: str) -> None:
    """Standing cars, and one look after every second: ids last, though rows of misses would not."""
    seen = drive([Car(-4.0, 30.0), Car(4.0, 40.0)], count=31)
    blind = [f if f.index % 10 < 3 else replace(f, detections=None) for f in seen.frames]
    tracker = TRACKERS[name](LEVEL)
    for frame in blind:
        assert tracker.step(frame).ids.tolist() == [0, 1]
