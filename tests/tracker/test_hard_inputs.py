"""What broke other trackers must not break these: odd boxes, odd times, odometry that drops out."""

from dataclasses import replace

import numpy as np
import pytest

from tests.tracker.samples import LEVEL, Car, drive, frames_with, ids_of
from tracker import FRAMEWORKS, Detections, Frame, Tracker, Tracks

PRESETS = pytest.mark.parametrize("preset", [Tracker.paper, Tracker.default])


def run(tracker: Tracker, frames: list[Frame]) -> Tracks:
    """All rows, checked: finite boxes that are not inverted, no id twice in a frame."""
    rows = Tracks.concatenate([tracker.step(frame) for frame in frames])
    assert np.isfinite(rows.boxes).all()
    assert (rows.boxes[:, 2:] >= rows.boxes[:, :2]).all()
    rows.require_unique_ids()
    return rows


@PRESETS
def test_a_box_that_shrinks_to_nothing_before_a_gap(preset) -> None:
    shrinking = [[[600.0, 180.0, 600.0 + 40.0 * 0.5**i, 180.0 + 30.0 * 0.5**i]] for i in range(12)]
    again = [[[600.0, 180.0, 640.0, 210.0]]] * 3
    rows = run(preset(LEVEL), frames_with(*shrinking, *[[]] * 6, *again))
    assert (rows.frames >= 18).any()


@PRESETS
@pytest.mark.parametrize("dt", [0.0, 1e-12, 1e-6])
def test_frames_that_follow_each_other_at_once(preset, dt: float) -> None:
    box = np.array([[600.0, 180.0, 640.0, 210.0]])
    frames = [
        Frame(i, dt * i, Detections(box + 0.1 * i, np.ones(1)), np.eye(4) if i else None)
        for i in range(8)
    ]
    assert set(run(preset(LEVEL), frames).ids.tolist()) == {0}


@PRESETS
def test_odometry_that_drops_out_while_driving_straight_keeps_the_ids(preset) -> None:
    parked = [Car(-4.0, 40.0), Car(4.0, 50.0)]
    seen = drive(parked, lambda time: (0.0, 8.0 * time, 0.0), 30)
    deaf = [
        replace(frame, T_now_before=None, motion_cov=None) if 10 <= frame.index < 16 else frame
        for frame in seen.frames
    ]
    ids = ids_of(preset(LEVEL), replace(seen, frames=deaf))
    assert all(len(had) == 1 for had in ids.values())


def test_what_a_detector_misses_often_is_predicted_where_it_is() -> None:
    moving = [Car(-6.0, 25.0, yaw=0.0, velocity=(3.0, 0.0))]
    exact = drive(moving, count=40)
    gaps = drive(moving, count=40, hidden=lambda frame, car: frame % 5 == 4)
    rows = run(Tracker.default(LEVEL), gaps.frames)
    for frame in (24, 29, 34):
        (predicted,) = rows.boxes[rows.frames == frame]
        (truth,) = exact.frames[frame].detections.boxes
        np.testing.assert_allclose(predicted, truth, atol=5.0)
        assert 0.5 <= rows.scores[rows.frames == frame][0] < 1.0


def test_without_evidence_nothing_is_written_that_was_not_seen() -> None:
    gap = drive([Car(0.0, 25.0)], count=20, hidden=lambda frame, car: frame in {10, 11})
    rows = run(replace(Tracker.default(LEVEL), existence=None), gap.frames)
    assert not set(rows.frames.tolist()) & {10, 11}


@pytest.mark.parametrize("framework", ["greedy", "hungarian"])
def test_online_never_looks_ahead(framework: str) -> None:
    """What comes after a frame changes nothing of what was said up to it."""
    moving = [Car(-6.0, 25.0, yaw=0.0, velocity=(5.0, 0.0)), Car(2.0, 35.0)]
    frames = drive(moving, count=24, hidden=lambda frame, car: (frame + car) % 7 == 3).frames
    whole = run(FRAMEWORKS[framework](Tracker.default(LEVEL)), frames)
    for end in (1, 9, 17):
        cut = run(FRAMEWORKS[framework](Tracker.default(LEVEL)), frames[:end])
        before = whole.select(whole.frames < end)
        np.testing.assert_array_equal(cut.ids, before.ids)
        np.testing.assert_array_equal(cut.boxes, before.boxes)
