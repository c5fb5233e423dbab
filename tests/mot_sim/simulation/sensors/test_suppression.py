"""A detector's suppression: who is weaker, what level 0 leaves, live steps, how long it lasts."""

from dataclasses import replace

import numpy as np
import pytest

from mot_sim.simulation.sensors import Autocorrelation, Detector, Profile
from mot_sim.simulation.sensors.quantiles import Quantiles
from mot_sim.simulation.sensors.suppression import IOU_BINS, SCORE_BINS, OverlapSuppression
from tests.mot_sim.simulation.sensors.sights import CAMERA, STEP, sightings_of
from tracker.errors import BadConfig

ALL = OverlapSuppression((1.0,) * (len(IOU_BINS) * len(SCORE_BINS)))
HALF = replace(
    ALL,
    dropped=(0.5,) * len(ALL.dropped),
    autocorrelation=Autocorrelation((1.0,), (5.0,)),
)
BOXES = np.array([[0.0, 0.0, 100.0, 50.0], [20.0, 0.0, 120.0, 50.0], [40.0, 0.0, 140.0, 50.0]])


def lost(scores, boxes=BOXES, suppression=ALL, **levels):
    count = len(boxes)
    return suppression(
        np.zeros(count, int), np.arange(count), boxes, np.array(scores), 0, STEP, **levels
    )[0].tolist()


def pairs(frames: int = 100):
    """Two cars in a row of frames, one just behind the other: IoU .85."""
    return sightings_of(np.tile([0, 1], frames), np.repeat(np.arange(frames), 2))


def test_the_weaker_is_dropped_and_what_is_dropped_suppresses_no_others() -> None:
    # IoU: neighbours .67, the outer ones .43
    assert lost([0.9, 0.8, 0.7]) == [False, True, True]
    assert lost([0.7, 0.9, 0.8]) == [True, False, True]
    cut = replace(ALL, dropped=(0.0,) * 6 + (1.0,) * 9)  # from .5 on
    assert lost([0.9, 0.8, 0.7], suppression=cut) == [False, True, False]


def test_of_equal_scores_the_one_farther_up_is_dropped_then_the_later() -> None:
    assert lost([1.0, 1.0], BOXES[:2]) == [False, True]
    assert lost([1.0, 1.0], BOXES[:2] - [[0, 0, 0, 1], [0, 0, 0, 0]]) == [True, False]


def test_scores_choose_the_rate() -> None:
    low_only = replace(ALL, dropped=(1.0, 0.0, 0.0) * len(IOU_BINS))
    assert lost([0.9, 0.3], BOXES[:2], low_only) == [False, True]
    assert lost([0.9, 0.8], BOXES[:2], low_only) == [False, False]


def test_level_0_and_distance_leave_all() -> None:
    assert not any(lost([0.9, 0.8, 0.7], level=0.0))
    assert not any(lost([0.9, 0.8], BOXES[[0, 0]] + [[0.0] * 4, [60.0, 0.0, 60.0, 0.0]]))
    exact = Detector(Profile(suppression=ALL), misses=0.0)
    assert len(exact.sense(pairs(3), 0, CAMERA).log.frames) == 6


def test_a_weaker_one_that_is_left_loses_score() -> None:
    weak = OverlapSuppression(weakened=(1.0,) * len(IOU_BINS), log_odds=Quantiles((0.0, 0.0)))
    frames, ids, scores = np.zeros(2, int), np.arange(2), np.array([0.9, 0.8])
    gone, made = weak(frames, ids, BOXES[:2], scores, 0, STEP)
    assert not gone.any()
    assert made.tolist() == [0.9, 0.5]
    assert weak(frames, ids, BOXES[:2], scores, 0, STEP, 1.0, 0.0)[1].tolist() == [0.9, 0.8]


def test_one_frame_at_a_time_gives_the_bits_of_the_whole_drive_and_lasts() -> None:
    detector, sightings = Detector(Profile(suppression=HALF)), pairs()
    whole = detector.sense(sightings, 3, CAMERA, STEP)
    live = [
        detector.sense(sightings.select(sightings.frames == k), 3, CAMERA, STEP, np.array([k]))
        for k in range(100)
    ]
    assert [len(each.log.frames) for each in live] == np.bincount(whole.log.frames).tolist()
    left = np.concatenate([each.log.detections.boxes for each in live])
    assert left.tobytes() == whole.log.detections.boxes.tobytes()
    counts = np.bincount(whole.log.frames)
    assert set(counts.tolist()) == {1, 2}
    assert np.abs(np.diff(counts)).sum() < 30  # 50 if each frame were drawn anew


def test_rates_outside_are_refused() -> None:
    with pytest.raises(BadConfig, match="give 15, one for each"):
        OverlapSuppression((0.5,))
    with pytest.raises(BadConfig, match=r"rates lie in \[0, 1\]"):
        OverlapSuppression(weakened=(1.5,) * len(IOU_BINS))
