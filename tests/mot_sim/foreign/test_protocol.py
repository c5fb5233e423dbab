"""How trackers are asked: by their arguments, and as the library that they come from."""

import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from mot_sim.experiments.sweep.tracker_specs import TrackerSpec
from mot_sim.foreign.protocol import as_steps, make_steps
from mot_sim.simulation.rig import Rig
from mot_sim.testing import SeededEpisode, follow
from tests.mot_sim.foreign.libraries import write_libraries
from tracker import Detections, Frame, Tracker
from tracker.errors import BadConfig, UnknownName

CAMERA = Rig.kitti().camera
BOXES = [[10.0, 180, 90, 240], [500, 190, 560, 230]]
FRAME = Frame(0, 0.0, Detections.of(BOXES, [0.9, 0.8]), image=np.zeros((4, 6, 3), np.uint8))
NAMES = ("motpy", "norfair", "supervision", "trackers")


@pytest.fixture
def libraries(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """Small stand-ins of the four libraries, as if they were installed."""
    monkeypatch.syspath_prepend(str(write_libraries(tmp_path)))
    yield
    for name in NAMES:
        sys.modules.pop(name, None)


class Ours:
    """Says what it was given."""

    given: Any = None

    def answer(self, *given: Any) -> np.ndarray:
        self.given = given
        return np.column_stack((BOXES, [1, 2]))


class OfBoxes(Ours):
    def update(self, boxes: np.ndarray, scores: np.ndarray) -> np.ndarray:
        return self.answer(boxes, scores)


class OfImage(Ours):
    def update(self, boxes: np.ndarray, scores: np.ndarray, image: Any = None) -> np.ndarray:
        return self.answer(boxes, scores, image)


class WithSetting(Ours):
    def update(self, boxes: np.ndarray, scores: np.ndarray, threshold: float = 0.3) -> np.ndarray:
        return self.answer(boxes, scores, threshold)


class OfFrame(Ours):
    def step(self, frame: Frame) -> np.ndarray:
        return self.answer(frame)


class OfSupervision(Ours):
    def update(self, detections: Any) -> np.ndarray:
        return self.answer(detections)


class OfNorfair(Ours):
    def update(self, detections: Any = None) -> np.ndarray:
        return self.answer(detections)


class OfMotpy(Ours):
    def step(self, detections: Any) -> np.ndarray:
        return self.answer(detections)


def given_to(tracker: Ours) -> tuple[Any, ...]:
    """What the tracker was given, after its answer was read."""
    rows = as_steps(tracker, "mine").step(FRAME)
    assert (rows.ids.tolist(), rows.boxes.tolist()) == ([1, 2], BOXES)
    given: tuple[Any, ...] = tracker.given
    return given


def test_trackers_are_asked_as_their_arguments_say() -> None:
    boxes, scores = given_to(OfBoxes())
    assert (boxes.tolist(), scores.tolist()) == (BOXES, [0.9, 0.8])
    boxes[:] = np.nan
    assert FRAME.found.boxes.tolist() == BOXES  # it was given a copy
    assert given_to(OfImage())[2].shape == (4, 6, 3)
    assert given_to(WithSetting())[2] == 0.3
    assert given_to(OfFrame()) == (FRAME,)


@pytest.mark.usefixtures("libraries")
def test_detections_are_those_of_the_library_that_the_argument_is_from() -> None:
    assert given_to(OfSupervision())[0].xyxy.tolist() == BOXES
    assert [each.points.tolist() for each in given_to(OfNorfair())[0]] == [
        [box[:2], box[2:]] for box in BOXES
    ]
    assert [each.box.tolist() for each in given_to(OfMotpy())[0]] == BOXES


@pytest.mark.usefixtures("libraries")
@pytest.mark.parametrize(
    "made_by",
    [
        "motpy:MultiObjectTracker",
        "norfair:Tracker",
        "supervision:ByteTrack",
        "trackers:SORTTracker",
    ],
)
def test_a_class_of_a_library_is_made_and_asked_by_its_adapter(
    episode: SeededEpisode, made_by: str
) -> None:
    rows = make_steps(made_by, CAMERA, 10.0).step(FRAME)
    assert rows.boxes.tolist() == BOXES
    assert len(set(rows.ids.tolist())) == 2
    seen = sum(len(frame.found) for frame in episode.frames)
    assert len(follow(f"mine={made_by}", episode)) == seen
    with pytest.raises(BadConfig, match="speed"):
        make_steps(made_by, CAMERA, 10.0, speed=3).step(FRAME)


def test_without_its_library_a_form_is_refused() -> None:
    with pytest.raises(BadConfig, match="takes supervision's detections: pip install supervision"):
        as_steps(OfSupervision(), "mine")


def test_ours_stay_what_they_are_and_other_arguments_are_refused() -> None:
    ours = Tracker.default(CAMERA)
    assert as_steps(ours, "default") is ours

    class OfRows:
        def update(self, dets: np.ndarray) -> None: ...

    with pytest.raises(BadConfig, match=r"update\(dets\) takes one argument.*the forms: step"):
        as_steps(OfRows(), "mine")
    with pytest.raises(BadConfig, match="a int is no tracker"):
        as_steps(7, "mine")


def test_guests_are_trackers_of_sweeps_by_their_names(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("MOT_SIM_GUESTS", "/nowhere")
    spec = TrackerSpec.parse("mine=norfair:min_score=0.5")
    assert spec.is_guest
    guest: Any = spec.build(CAMERA, 5.0)
    assert (guest.min_score, guest.frame_rate) == (0.5, 5.0)
    with pytest.raises(UnknownName, match="setting of guest norfair: 'speed'"):
        TrackerSpec.parse("norfair:speed=1").build(CAMERA)
