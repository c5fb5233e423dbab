"""What happens to cars: hidden, crossing, turning, undetected; one hand-made case each."""

import numpy as np
import pytest

from mot_sim.datasets.recorded import DetectionLog
from mot_sim.diagnosis.context_events import EVENT_KINDS, SCENERY, ContextEvents, bin_names
from mot_sim.diagnosis.event_finders import (
    box_crossings,
    camera_turns,
    car_turns,
    detector_gaps,
    exact_occlusions,
    headings_of,
    labelled_occlusions,
    look_alike_pairs,
)
from mot_sim.simulation.truth import EVENTS
from tests.mot_sim.diagnosis.conftest import Crossing
from tests.mot_sim.metrics.test_breaks import tracks
from tracker.geometry import homogeneous, rotation_y
from tracker.types import Cuboids, Detections, Tracks


def standing(count: int, yaw: np.ndarray, depth: float = 20.0) -> Cuboids:
    """Cars ahead of the camera."""
    base = np.tile([0.0, 0.0, depth], (count, 1))
    return Cuboids(base, yaw, np.tile([4.0, 1.5, 1.6], (count, 1)))


@pytest.mark.parametrize(
    ("row", "names"),
    [
        (("occlusion", 3, 7, 1, 2, 1.5), ["up to 0.5 s", "occluder up to 2 m nearer"]),
        (("occlusion", 3, 8, 1, 2, 4.0), ["0.6 to 1 s", "2 to 5 m nearer"]),
        (("occlusion", 3, 40, 1, SCENERY, np.nan), ["longer than 2 s", "behind no car"]),
        (("occlusion", 3, 3, 1, -2, np.nan), ["up to 0.5 s", "behind something unknown"]),
        (("detector gap", 3, 3, 1, -2, np.nan), ["1 frame"]),
        (("detector gap", 3, 5, 1, -2, np.nan), ["0.2 to 0.3 s"]),
        (("detector gap", 3, 13, 1, -2, np.nan), ["longer than 1 s"]),
        (("crossing", 3, 13, 1, 4, np.nan), []),
    ],
)
def test_a_happening_lies_in_its_bins(row: tuple, names: list[str]) -> None:
    found = ContextEvents.of([row]).bins_of(0)
    assert list(found) == [row[0], *(f"{row[0]}, {name}" for name in names)]
    assert set(found) <= set(bin_names(row[0]))


def test_no_happenings_are_an_empty_table() -> None:
    assert len(ContextEvents.of([])) == 0


def test_cars_that_change_sides_cross_once() -> None:
    rows = [(frame, 1, 10.0 * frame) for frame in range(20)] + [(f, 2, 100.0) for f in range(20)]
    cars = tracks(sorted(rows))
    (found,) = box_crossings(cars)
    assert found[:5] == ("crossing", 3, 17, 1, 2)
    beside = tracks(sorted([(f, 1, 0.0) for f in range(9)] + [(f, 2, 40.0) for f in range(9)]))
    assert list(box_crossings(beside)) == []
    assert list(box_crossings(Tracks.empty())) == []


def test_only_cars_of_one_look_that_are_near_are_look_alikes() -> None:
    cars = tracks([(0, 1, 0.0), (0, 2, 100.0), (0, 3, 100.0), (0, 4, 600.0)])
    ids, looks = np.array([1, 2, 3, 4]), np.array([8, 8, 5, 8])
    found = list(look_alike_pairs(cars, ids, looks))
    assert [row[3:5] for row in found] == [(1, 2)]


def test_gaps_are_counted_between_the_first_and_the_last_box() -> None:
    cars = tracks([(frame, 1, 0.0) for frame in range(10)])
    seen = [2, 3, 6, 8]
    log = DetectionLog(np.array(seen), Detections.of(cars.boxes[seen]))
    found = list(detector_gaps(cars, log, np.arange(10)))
    assert [row[1:4] for row in found] == [(4, 5, 1), (7, 7, 1)]
    # Frames 4, 5 and 7 never come: the detector missed nothing.
    assert list(detector_gaps(cars, log, np.array([0, 1, 2, 3, 6, 8, 9]))) == []
    nothing = DetectionLog(np.zeros(0, np.int64), Detections.empty())
    assert list(detector_gaps(cars, nothing, np.arange(10))) == []
    assert list(detector_gaps(Tracks.empty(), nothing, np.arange(10))) == []


def test_one_box_of_the_detector_covers_one_car_only() -> None:
    cars = tracks([(frame, car, 10.0 * car) for frame in range(5) for car in (0, 1)])
    keep = np.flatnonzero((cars.ids == 0) | (cars.frames != 2))
    log = DetectionLog(cars.frames[keep], Detections.of(cars.boxes[keep]))
    assert [row[1:4] for row in detector_gaps(cars, log, np.arange(5))] == [(2, 2, 1)]


def test_the_camera_turns_for_every_car_in_the_image() -> None:
    yaw = np.concatenate((np.zeros(10), np.linspace(0.0, 1.0, 21), np.full(10, 1.0)))
    poses = np.array([homogeneous(rotation_y(float(angle)), np.zeros(3)) for angle in yaw])
    headings = headings_of(poses)
    np.testing.assert_allclose(headings, yaw, atol=1e-9)
    cars = tracks([(frame, 4, 0.0) for frame in range(41)] + [(frame, 5, 0.0) for frame in (0, 1)])
    cars = cars.select(np.argsort(cars.frames, kind="stable"))
    ((kind, first, last, car, _, _),) = camera_turns(cars, headings, 10.0)
    assert (kind, car) == ("camera turns", 4)
    assert 7 <= first <= 11
    assert 29 <= last <= 33
    assert list(camera_turns(cars, np.zeros(41), 10.0)) == []
    assert len(headings_of(np.zeros((0, 4, 4)))) == 0


def test_a_car_turns_in_the_world_and_not_because_the_camera_does() -> None:
    turning = np.linspace(0.0, 1.0, 21)
    still = tracks([(frame, 4, 0.0) for frame in range(21)], cuboids=standing(21, -turning))
    assert list(car_turns(still, turning, 10.0)) == []
    ((kind, _, _, car, _, _),) = car_turns(still, np.zeros(21), 10.0)
    assert (kind, car) == ("car turns", 4)
    unknown = tracks([(0, 1, 0.0)], cuboids=standing(1, np.array([np.nan])))
    assert list(car_turns(unknown, np.zeros(1), 10.0)) == []


def test_labels_tell_occlusions_by_level_and_by_gaps() -> None:
    frames = [*range(0, 10), *range(14, 20)]  # no label in 10..13
    levels = [0, 0, 2, 3, 2, 0, 0, 0, 0, 0] + [0] * 6
    rows = [(frame, 1, 0.0) for frame in frames] + [(frame, 2, 20.0) for frame in frames]
    cars = tracks(
        rows,
        kinds=np.full(len(rows), "Car"),
        occlusion=np.array([*levels, *([0] * 16)]),
        cuboids=Cuboids(
            np.array([[0.0, 0.0, 20.0]] * 16 + [[0.0, 0.0, 14.0]] * 16),
            np.zeros(32),
            np.ones((32, 3)),
        ),
    )
    cars = cars.select(np.lexsort((cars.ids, cars.frames)))
    found = [row for row in labelled_occlusions(cars) if row[3] == 1]
    assert [row[1:5] for row in found] == [(2, 4, 1, 2), (10, 13, 1, 2)]
    assert [row[5] for row in found] == [6.0, 6.0]
    assert list(labelled_occlusions(tracks([(0, 1, 0.0)]))) == []


def test_exact_occlusions_are_those_of_the_truth(crossing: Crossing) -> None:
    annotated, events = crossing.recorded.annotations, crossing.recorded.events
    found = list(exact_occlusions(annotated.truth, annotated.occlusions))
    begun = [
        (int(frame), int(car))
        for frame, kind, car in zip(events.frames, events.kinds, events.ids, strict=True)
        if kind == "occlusion begins"
    ]
    assert found
    assert sorted((row[1], row[3]) for row in found) == sorted(begun)
    for _, _, _, _, other, gap in found:
        assert (other >= 0) == bool(np.isfinite(gap))
        assert not gap < 0.0


def test_the_kinds_are_no_names_of_the_truths_events() -> None:
    assert len(EVENT_KINDS) == len(set(EVENT_KINDS))
    assert set(EVENT_KINDS) & set(EVENTS) == {"crossing"}
