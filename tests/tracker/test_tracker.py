"""The online tracker: identities over gaps, turns and crossings."""

from dataclasses import replace

import numpy as np
import pytest
from jaxtyping import Bool
from numpy import ndarray as Array

from tests.tracker.samples import LEVEL, PITCHED, Car, Drive, drive, frames_with, ids_of
from tracker import Camera, Detections, Frame, Tracker
from tracker.association import Match
from tracker.batch import follows_together
from tracker.lifecycle import ActiveTracks, Lifecycle
from tracker.state import TrackerStatistics
from tracker.suppression import Suppression

PRESETS = pytest.mark.parametrize("preset", [Tracker.paper, Tracker.default])
BOX = [[600.0, 180.0, 650.0, 230.0]]


def forward(time: float) -> tuple[float, float, float]:
    """The ego car drives straight on at 8 m/s."""
    return 0.0, 8.0 * time, 0.0


def turning_right(time: float) -> tuple[float, float, float]:
    """The ego car turns on the spot by 60 degrees a second."""
    return 0.0, 0.0, np.deg2rad(60.0) * time


@pytest.mark.parametrize("camera", [LEVEL, PITCHED], ids=["level", "pitched"])
def test_an_id_survives_a_gap_of_a_second_while_the_ego_car_drives(camera) -> None:
    parked = [Car(-3.5, 45.0), Car(4.0, 55.0, yaw=0.0)]
    gap = drive(parked, forward, 35, hidden=lambda frame, car: 10 <= frame < 20, camera=camera)
    assert ids_of(Tracker.default(camera), gap) == {0: [0], 1: [1]}


def test_a_gap_longer_than_the_memory_begins_a_new_track() -> None:
    gap = drive([Car(0.0, 30.0)], count=60, hidden=lambda frame, car: 10 <= frame < 45)
    assert ids_of(Tracker.default(LEVEL), gap) == {0: [0, 1]}


def test_a_moving_car_is_expected_where_its_velocity_leads() -> None:
    """At 15 m/s across it goes 7.5 m, twice its length, while it is hidden."""
    crossing = Car(-12.0, 35.0, yaw=0.0, velocity=(15.0, 0.0))
    gap = drive([crossing], count=20, hidden=lambda frame, car: 8 <= frame < 13)
    assert ids_of(Tracker.default(LEVEL), gap) == {0: [0]}


@PRESETS
def test_a_turn_of_60_degrees_a_second_keeps_all_ids_with_ego_motion(preset) -> None:
    parked = [Car(12.0, 30.0), Car(20.0, 33.0), Car(30.0, 30.0), Car(35.0, 22.0)]
    known = drive(parked, turning_right, 12)
    ids = ids_of(preset(LEVEL), known)
    assert len(ids) == 4
    assert all(len(had) == 1 for had in ids.values())


def test_a_turn_without_ego_motion_costs_ids() -> None:
    parked = [Car(12.0, 30.0), Car(20.0, 33.0), Car(30.0, 30.0), Car(35.0, 22.0)]
    unknown = drive(parked, turning_right, 12, know_motion=False)
    assert sum(map(len, ids_of(Tracker.default(LEVEL), unknown).values())) > 4


@PRESETS
def test_without_any_ego_motion_a_standing_camera_keeps_its_ids(preset) -> None:
    slow = [Car(-4.0, 20.0, velocity=(0.0, 1.0)), Car(3.0, 30.0)]
    ids = ids_of(preset(LEVEL), drive(slow, count=15, know_motion=False))
    assert all(len(had) == 1 for had in ids.values())


def test_two_crossing_cars_keep_their_ids() -> None:
    """They pass each other in opposite directions; the further one is hidden for 0.4 s."""
    assert _passed(Tracker.default(LEVEL)) == {0: [0], 1: [1]}


@pytest.mark.unchecked  # many frames of one shape
def test_a_car_that_stands_still_for_300_frames_keeps_one_id() -> None:
    tracker = Tracker.default(LEVEL)
    assert ids_of(tracker, drive([Car(0.0, 25.0)], count=300)) == {0: [0]}
    belief = tracker.state.tracks.beliefs
    assert np.abs(belief.velocity).max() < 0.1
    assert np.linalg.eigvalsh(belief.cov).min() > 0.0
    assert tracker.state.tracks.hits.tolist() == [300]


def test_the_papers_tracker_forgets_at_the_first_missed_frame() -> None:
    missed = drive([Car(0.0, 25.0)], count=6, hidden=lambda frame, car: frame == 3)
    assert ids_of(Tracker.paper(LEVEL), missed) == {0: [0, 1]}


def test_weak_detections_continue_tracks_but_begin_none() -> None:
    cars = [Car(-3.0, 25.0), Car(3.0, 25.0)]
    weak = drive(
        cars, count=6, score=lambda frame, car: 0.5 if car == 1 or frame in (2, 3) else 0.9
    )
    tracker = Tracker.default(LEVEL)
    rows = [tracker.step(frame) for frame in weak.frames]
    assert [tracks.ids.tolist() for tracks in rows] == [[0]] * 6
    assert [tracks.scores.tolist() for tracks in rows[1:4]] == [[0.9], [0.5], [0.5]]


def test_rows_carry_frame_box_and_score_of_the_detection() -> None:
    detections = Detections.of([*BOX, [200.0, 180, 260, 240]], [0.9, 0.95])
    tracks = Tracker.default(LEVEL).step(Frame(7, 0.7, detections))
    assert tracks.frames.tolist() == [7, 7]
    np.testing.assert_array_equal(tracks.boxes, detections.boxes)
    assert tracks.scores.tolist() == [0.9, 0.95]


@pytest.mark.parametrize("keep_every", [2, 3, 5])
def test_dropped_frames_keep_their_ids_when_the_motion_is_composed(keep_every: int) -> None:
    parked = [Car(-3.5, 45.0), Car(4.0, 55.0)]
    full = drive(parked, lambda t: (0.0, 8.0 * t, 0.05 * t), 35)
    frames, names, since = [], [], np.eye(4)
    for frame, rows in zip(full.frames, full.cars, strict=True):
        since = since if frame.T_now_before is None else frame.T_now_before @ since
        if frame.index % keep_every == 0:
            frames.append(replace(frame, T_now_before=since if frames else None))
            names.append(rows)
            since = np.eye(4)
    ids = ids_of(Tracker.default(LEVEL), Drive(frames, names))
    assert ids == {0: [0], 1: [1]}


def test_of_two_identical_boxes_one_is_tracked() -> None:
    tracker = Tracker.default(LEVEL)
    for frame in frames_with(BOX * 2, BOX * 2):
        assert tracker.step(frame).ids.tolist() == [0]


@PRESETS
def test_two_identical_boxes_without_suppression_are_two_tracks(preset) -> None:
    tracker = replace(preset(LEVEL), suppress=Suppression(max_iou=1.0))
    for frame in frames_with(BOX * 2, BOX * 2, BOX * 2):
        assert sorted(tracker.step(frame).ids.tolist()) == [0, 1]


@PRESETS
def test_a_box_without_area_is_no_car(preset) -> None:
    tracker = preset(LEVEL)
    for frame in frames_with(*[[[620.0, 200, 620, 200], *BOX, [50.0, 80, 50, 90]]] * 3):
        assert tracker.step(frame).ids.tolist() == [0]


@PRESETS
def test_500_boxes_a_frame_are_500_tracks(preset) -> None:
    x, y = np.meshgrid(np.arange(25) * 48.0, np.arange(20) * 18.0)
    corners = np.stack((x.ravel(), y.ravel()), axis=1)
    boxes = np.concatenate((corners, corners + [40.0, 15.0]), axis=1)
    tracker = preset(LEVEL)
    for index in range(2):
        tracks = tracker.step(Frame(index, index / 10, Detections.of(boxes), np.eye(4)))
        assert sorted(tracks.ids.tolist()) == list(range(500))


@pytest.mark.unchecked  # many frames of one shape
@PRESETS
def test_a_thousand_empty_frames_give_no_tracks_and_no_memory(preset) -> None:
    tracker = preset(LEVEL)
    for index in range(1000):
        tracks = tracker.step(Frame(index, index / 10, Detections.empty(), np.eye(4)))
        assert len(tracks) == 0
    assert tracks.boxes.shape == (0, 4)
    assert len(tracker.state.tracks) == 0
    assert tracker.state.statistics == TrackerStatistics(frames=1000)


def test_tracks_that_left_the_view_are_forgotten_before_their_time() -> None:
    tracker = Tracker.default(LEVEL)
    passed = drive([Car(3.0, 12.0)], lambda t: (0.0, 10.0 * t, 0.0), 25)
    for frame in passed.frames:
        tracker.step(frame)
    assert len(passed.frames[-1].detections) == 0
    assert len(tracker.state.tracks) == 0


@PRESETS
def test_the_cost_matrix_is_what_the_step_associates_and_changes_nothing(preset) -> None:
    passing = [Car(-4.0, 25.0), Car(2.0, 30.0, velocity=(0.0, -3.0)), Car(3.5, 34.0)]
    tracker, asked = replace(preset(LEVEL), explain=True), preset(LEVEL)
    for frame in drive(passing, forward, 8, hidden=lambda at, car: at == 4 and car == 1).frames:
        before = asked.state
        compared = asked.cost_matrix(frame)
        assert asked.state is before
        tracks = tracker.step(frame)
        np.testing.assert_array_equal(compared.costs, tracker.explanation.total)
        np.testing.assert_array_equal(compared.tracks.ids, tracker.explanation.ids)
        np.testing.assert_array_equal(compared.detections.boxes, tracker.explanation.boxes)
        gated = np.ones(compared.costs.shape, bool)
        gated[compared.pairs.pairs] = False
        np.testing.assert_array_equal(np.isinf(compared.costs), gated)
        np.testing.assert_array_equal(asked.step(frame).boxes, tracks.boxes)


def test_a_match_made_by_anybody_is_applied() -> None:
    tracker = Tracker.paper(LEVEL)
    first, second = drive([Car(-4.0, 25.0), Car(4.0, 25.0)], count=2).frames
    assert tracker.step(first).ids.tolist() == [0, 1]
    crossed = Match.of(np.array([[0, 1]]), 2, 2)
    rows = tracker.apply_match(second, tracker.cost_matrix(second), crossed)
    assert rows.ids.tolist() == [0, 2]
    np.testing.assert_array_equal(rows.boxes, second.detections.boxes[[1, 0]])


def _passed(tracker: Tracker) -> dict[int, list[int]]:
    """The ids of two cars that pass each other, the further one hidden for a while."""
    passing = [
        Car(-8.0, 20.0, yaw=0.0, velocity=(8.0, 0.0)),
        Car(8.0, 27.0, yaw=np.pi, velocity=(-8.0, 0.0)),
    ]
    seen = drive(passing, count=20, hidden=lambda frame, car: car == 1 and 8 <= frame < 12)
    return ids_of(tracker, seen)


@pytest.mark.parametrize("name", ["existence", "box_filter"])
def test_filters_of_ones_own_are_asked(name: str) -> None:
    default, asked = Tracker.default(LEVEL), []

    class Mine(type(getattr(default, name))):  # type: ignore[misc]
        """The same filter, which counts."""

        def __call__(self, *given: object) -> object:
            asked.append(1)
            return super().__call__(*given)

    mine = replace(default, **{name: Mine()})
    assert _passed(mine) == _passed(Tracker.default(LEVEL))
    assert len(asked) >= 19
    assert not follows_together(mine)


def test_a_life_of_ones_own_ends_tracks() -> None:
    class Mine(Lifecycle):
        """No track outlives a miss, whatever gap is allowed."""

        def are_alive(self, tracks: ActiveTracks, camera: Camera) -> Bool[Array, " n"]:
            return ~np.isnan(tracks.scores)

    mine = replace(Tracker.default(LEVEL), lifecycle=Mine(birth_score=0.8, max_gap=3.0))
    assert _passed(mine) == {0: [0], 1: [1, 2]}


@pytest.mark.parametrize("name", ["predict_tracks", "gate", "update_tracks"])
def test_steps_of_ones_own_are_taken(name: str) -> None:
    taken = []

    def step(self: Tracker, *given: object) -> object:
        taken.append(1)
        return getattr(Tracker, name)(self, *given)

    mine = type("Mine", (Tracker,), {name: step}).default(LEVEL)
    assert _passed(mine) == _passed(Tracker.default(LEVEL))
    assert len(taken) >= 19
