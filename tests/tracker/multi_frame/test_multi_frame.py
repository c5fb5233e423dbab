"""Sliding window and network flow: gaps, clutter, lag, memory."""

from dataclasses import replace

import numpy as np
import pytest

from tests.tracker.samples import LEVEL, Car, Drive, drive, outlines
from tracker import Detections, Frame, Tracker, Tracks
from tracker.association import Hungarian
from tracker.errors import BadConfig
from tracker.geometry import box_iou
from tracker.multi_frame import FlowCosts, NetworkFlow, Window
from tracker.multi_frame.linking import Linker, LinkerState

both = pytest.mark.parametrize("framework", [NetworkFlow, Window])


def forward(time: float) -> tuple[float, float, float]:
    """The ego car drives at 8 m/s in a bend."""
    return 0.0, 8.0 * time, 0.1 * time


def rows_of(framework: NetworkFlow | Window, frames: list[Frame]) -> Tracks:
    return Tracks.concatenate([*(framework.step(frame) for frame in frames), framework.finish()])


def gap(first: int, last: int) -> tuple[Drive, Drive]:
    """A crossing car, seen throughout, and unseen from the first to before the last frame."""
    cars = [Car(-8.0, 45.0, yaw=0.0, velocity=(6.0, 0.0))]
    whole = drive(cars, forward, 30)
    return whole, drive(cars, forward, 30, hidden=lambda frame, _: first <= frame < last)


@both
def test_a_gap_is_filled_where_the_car_was(framework) -> None:
    whole, holed = gap(12, 18)
    rows = rows_of(framework(Tracker.default(LEVEL)), holed.frames)
    assert rows.ids.tolist() == [0] * 30
    truth = np.concatenate([frame.detections.boxes for frame in whole.frames])
    overlaps = box_iou(rows.boxes, truth)
    assert overlaps[12:18].min() > 0.75
    np.testing.assert_array_equal(
        np.delete(rows.boxes, range(12, 18), 0), truth[[*range(12), *range(18, 30)]]
    )


def test_a_window_fills_no_more_than_it_sees_the_end_of() -> None:
    """Frame 16 is decided before 22 is seen; at 17 one detection after the gap is too little."""
    _, holed = gap(8, 22)
    rows = rows_of(Window(Tracker.default(LEVEL), lag=5), holed.frames)
    assert sorted(set(range(30)) - set(rows.frames.tolist())) == list(range(8, 18))
    assert set(rows.ids.tolist()) == {0}


@both
def test_a_gap_longer_than_the_memory_is_left_open(framework) -> None:
    standing = drive([Car(0.0, 30.0)], count=60, hidden=lambda frame, _: 10 <= frame < 45)
    rows = rows_of(framework(Tracker.default(LEVEL)), standing.frames)
    assert sorted(set(range(60)) - set(rows.frames.tolist())) == list(range(10, 45))
    assert set(rows.ids.tolist()) == {0, 1}


@both
def test_clutter_that_comes_and_goes_vanishes_and_a_weak_car_that_stays_does_not(framework) -> None:
    steady = drive([Car(0.0, 25.0)], count=20, score=lambda frame, _: 0.6).frames
    flashes = {4: [100.0, 150.0, 180.0, 220.0], 11: [900.0, 100.0, 1000.0, 180.0]}
    frames = []
    for frame in steady:
        boxes, scores = frame.detections.boxes, frame.detections.scores
        if frame.index in flashes:
            boxes, scores = np.vstack((boxes, flashes[frame.index])), np.append(scores, 0.97)
        frames.append(replace(frame, detections=Detections(boxes, scores)))
    rows = rows_of(framework(Tracker.default(LEVEL)), frames)
    np.testing.assert_array_equal(rows.boxes, np.vstack([f.detections.boxes for f in steady]))
    assert set(rows.ids.tolist()) == {0}


@both
@pytest.mark.parametrize("score", [0.4, 1.0])
def test_where_every_score_is_the_same_three_boxes_in_a_row_are_a_car(framework, score) -> None:
    cars = [Car(0.0, 25.0), Car(4.0, 40.0)]
    frames = drive(cars, count=5, score=lambda *_: score).frames
    flash = np.array([[100.0, 150.0, 180.0, 220.0]])
    boxes = np.vstack((frames[2].detections.boxes, flash))
    frames[2] = replace(frames[2], detections=Detections(boxes, np.full(3, score)))
    rows = rows_of(framework(Tracker.default(LEVEL)), frames[:3])
    last = rows.select(rows.frames == 2)
    assert np.bincount(rows.frames, minlength=3).tolist() == [2, 2, 2]
    np.testing.assert_array_equal(last.boxes, boxes[:2])


@both
def test_links_over_many_frames_are_possible_only_within_the_memory(framework) -> None:
    """The paper's tracker forgets at once: so do its costs in another framework."""
    missed = drive([Car(0.0, 25.0)], count=20, hidden=lambda frame, _: frame == 9)
    rows = rows_of(framework(Tracker.paper(LEVEL)), missed.frames)
    assert rows.ids.tolist() == [0] * 9 + [1] * 10


def test_a_window_as_long_as_the_drive_finds_the_tracks_of_the_whole_flow() -> None:
    _, holed = gap(12, 18)
    window = rows_of(Window(Tracker.default(LEVEL), lag=100), holed.frames)
    whole = rows_of(NetworkFlow(Tracker.default(LEVEL)), holed.frames)
    np.testing.assert_array_equal(window.ids, whole.ids)
    np.testing.assert_array_equal(window.frames, whole.frames)


def test_a_window_remembers_its_frames_and_no_more() -> None:
    window = Window(Tracker.default(LEVEL), lag=5)
    for frame in drive([Car(0.0, 25.0)], count=60).frames:
        window.step(frame)
    memory = Tracker.default(LEVEL).lifecycle.max_gap
    assert len(window.state.window) == 5
    assert len(window.state.past) <= 10 * memory + 1
    assert len(window.state.linker.recent) <= 10 * memory + 2
    assert len(window.state.ends) == 1


def test_cars_that_a_window_keeps_are_those_that_it_would_filter_anew() -> None:
    crossing = [Car(-8.0, 45.0, yaw=0.0, velocity=(6.0, 0.0)), Car(3.0, 40.0), Car(-4.0, 25.0)]
    seen = drive(  # the weak last car is believed in by and by
        crossing, forward, 24, lambda frame, car: frame in (12 + car, 13 + car),
        lambda frame, car: 0.6 if car == 2 else 0.95,
    )  # fmt: skip
    keeping, forgetting = (Window(Tracker.default(LEVEL), lag=6) for _ in range(2))
    both_rows = []
    for frame in seen.frames:
        forgetting.state = replace(forgetting.state, filtered=())
        both_rows.append((keeping.step(frame), forgetting.step(frame)))
    assert len(keeping.state.filtered) == 6  # of all open frames
    kept, anew = (Tracks.concatenate(rows) for rows in zip(*both_rows, strict=True))
    assert len(kept) > 30
    assert kept.estimates is not None
    assert anew.estimates is not None
    np.testing.assert_array_equal(kept.ids, anew.ids)
    np.testing.assert_allclose(kept.estimates.means, anew.estimates.means, rtol=1e-6, atol=1e-8)
    np.testing.assert_allclose(kept.estimates.covs, anew.estimates.covs, rtol=1e-5, atol=1e-8)


def test_a_window_too_short_for_any_birth_is_refused() -> None:
    with pytest.raises(BadConfig, match="no track would begin; look further ahead"):
        Window(Tracker.default(LEVEL), lag=1)
    assert Window(Tracker.default(LEVEL), FlowCosts(birth=3.0), lag=0).lag == 0


@both
def test_frames_that_go_back_in_time_are_refused(framework) -> None:
    made = framework(Tracker.default(LEVEL))
    made.step(Frame(1, 0.1, Detections.empty()))
    with pytest.raises(BadConfig, match="go forward in time"):
        made.step(Frame(0, 0.0, Detections.empty()))


@pytest.mark.parametrize("limit", [0.0, -1.0])
def test_a_largest_cost_that_forbids_all_links_is_refused(limit: float) -> None:
    tracker = replace(Tracker.default(LEVEL), associate=Hungarian(limit))
    with pytest.raises(BadConfig, match="max_cost"):
        Linker(tracker)


def test_nodes_are_numbered_in_the_order_of_time_and_linked_to_those_before() -> None:
    linker, state, firsts = Linker(Tracker.default(LEVEL)), LinkerState(), []
    for frame in drive([Car(0.0, 25.0), Car(-4.0, 30.0)], count=6).frames:
        state, frame_nodes = linker(state, frame)
        firsts.append(frame_nodes.first)
        assert set(frame_nodes.arcs.heads.tolist()) <= set(frame_nodes.nodes.tolist())
    assert firsts == [0, 2, 4, 6, 8, 10]
    assert state.statistics.frames == 6
    assert len(state.recent) == 12


def test_the_boxes_of_nodes_lose_noise_along_their_likeliest_links() -> None:
    """As in the online tracker: the gain is learned, and the expected boxes are the better ones."""
    rng = np.random.default_rng(4)
    cars = [Car(-9.0, 40.0), Car(-3.0, 30.0), Car(3.0, 35.0), Car(9.0, 45.0)]
    standing = drive(cars, count=80).frames
    linker, state = Linker(Tracker.default(LEVEL)), LinkerState()
    raw, filtered = [], []
    for frame in standing:
        true = frame.detections.boxes
        noisy = replace(frame.detections, boxes=true + rng.normal(0.0, 3.0, true.shape))
        state, frame_nodes = linker(state, replace(frame, detections=noisy))
        raw.append(frame_nodes.detections.boxes - true)
        filtered.append(frame_nodes.beliefs.boxes - true)
    assert state.gains is not None
    assert state.gains.gains[0].max() < 0.75  # it began at .8
    assert np.std(filtered[40:]) < 0.85 * np.std(raw[40:])
    unfiltered = Linker(replace(Tracker.default(LEVEL), box_filter=None))
    _, frame_nodes = unfiltered(state, replace(standing[-1], index=80, time=8.0))
    np.testing.assert_array_equal(frame_nodes.beliefs.boxes, frame_nodes.detections.boxes)


def test_the_path_of_the_ego_car_is_composed_on_the_road() -> None:
    linker, state = Linker(Tracker.default(LEVEL)), LinkerState()
    for frame in drive([], forward, 21).frames:
        state, frame_nodes = linker(state, frame)
    x, z, turn = forward(2.0)
    np.testing.assert_allclose(frame_nodes.T_world_road[:3, 3], [x, 0.0, z], atol=1e-9)
    assert np.arctan2(
        frame_nodes.T_world_road[0, 2], frame_nodes.T_world_road[0, 0]
    ) == pytest.approx(turn)


def test_a_box_that_would_lie_outside_the_image_is_not_filled_in() -> None:
    """The camera turns away and back; meanwhile nothing of the car can be seen."""
    turns = drive([Car(0.0, 20.0)], lambda t: (0.0, 0.0, 1.2 * np.sin(np.pi * t / 2.0)), 21)
    rows = rows_of(NetworkFlow(Tracker.default(LEVEL)), turns.frames)
    seen = [frame.index for frame in turns.frames if len(frame.detections)]
    assert 0 < len(seen) < 15
    assert (rows.boxes[:, 2] > rows.boxes[:, 0]).all()
    assert set(seen) <= set(rows.frames.tolist())
    assert 10 not in rows.frames.tolist()
    assert len(outlines(Car(0.0, 20.0).at(0.0))) == 1
