"""The effects put together."""

import numpy as np
import pytest

from mot_sim.rig import Rig
from mot_sim.sensors import Detector
from mot_sim.traffic import Route, Script, Scripted
from mot_sim.truth import Truth, exact_truth
from tracker.errors import BadConfig

RIG = Rig.kitti()
CAMERA = RIG.camera
EXACT = Detector(jitter=0.0, misses=0.0, doubt=0.0)


def drive(*cars: Script) -> Truth:
    """The truth of twenty frames; we stand at the origin."""
    traffic = Scripted(cars, Script(Route([(0.0, 0.0), (9.0, 0.0)]), [(0.0, 0.0)]))
    return exact_truth([traffic.at(0.1 * frame) for frame in range(20)], RIG)


def leaving(y: float) -> Script:
    return Script(Route([(12.0, y), (200.0, y)]), [(0.0, 8.0)])


def test_a_detector_without_noise_gives_the_exact_boxes() -> None:
    truth = drive(leaving(0.0), leaving(4.0))
    log = EXACT(truth, 5, CAMERA)
    assert (log.detections.boxes == truth.tracks.boxes).all()
    assert (log.detections.scores == 1.0).all()
    assert (log.frames == truth.tracks.frames).all()


def test_a_car_of_which_nothing_is_visible_is_never_seen() -> None:
    wall = Script(Route([(10.0, 0.0), (10.0, 9.0)]), [(0.0, 0.0)], size=(9.0, 3.0, 2.0))
    truth = drive(wall, leaving(0.0))
    assert (truth.visible[truth.tracks.ids == 1] == 0.0).all()
    assert (EXACT(truth, 0, CAMERA).detections.boxes == truth.tracks.boxes[::2]).all()


def test_one_more_car_changes_no_other_cars_noise() -> None:
    far_away = Script(Route([(150.0, -40.0), (300.0, -40.0)]), [(0.0, 1.0)])
    alone, both = drive(leaving(3.0)), drive(leaving(3.0), far_away)
    log_alone, log_both = (Detector()(truth, 9, CAMERA) for truth in (alone, both))
    rows = {tuple(row) for row in log_both.detections.boxes}
    assert all(tuple(row) in rows for row in log_alone.detections.boxes)


def test_the_seed_decides() -> None:
    truth = drive(leaving(0.0), leaving(4.0))
    first, again, other = (Detector()(truth, seed, CAMERA) for seed in (1, 1, 2))
    assert (first.detections.boxes == again.detections.boxes).all()
    assert (
        first.detections.boxes.shape != other.detections.boxes.shape
        or (first.detections.boxes != other.detections.boxes).any()
    )


def test_boxes_stay_in_the_image() -> None:
    beside = Script(Route([(4.0, 3.0), (60.0, 3.0)]), [(0.0, 0.1)])
    boxes = Detector()(drive(beside), 0, CAMERA).detections.boxes
    assert len(boxes)
    assert (boxes >= 0.0).all()
    assert (boxes <= np.array([1241.0, 374.0] * 2)).all()


def test_no_cars_no_detections() -> None:
    assert len(Detector()(drive(), 0, CAMERA).detections) == 0


def test_a_negative_level_is_refused() -> None:
    with pytest.raises(BadConfig, match=r"0 \(none\) or more"):
        Detector(jitter=-1.0)
