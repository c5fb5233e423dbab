"""The sheet of worst moments: the right frames, with images and without."""

from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest

from mot_sim.diagnosis.contact_sheet import (
    SHEET_FILE,
    SHEET_WIDTH_PIXELS,
    Scenario,
    cause_words,
    draw_case,
    draw_contact_sheet,
    frames_of,
    worst_first,
)
from mot_sim.diagnosis.findings import Case
from mot_sim.experiments.sweep.tracker_specs import TrackerSpec
from mot_sim.simulation.sensors import Profile
from tests.mot_sim.diagnosis.conftest import Crossing
from tests.mot_sim.diagnosis.test_findings import ONE_DRIVE, OTHER
from tracker.errors import BadOutput

RENAMED = TrackerSpec("odd", "tests.mot_sim.diagnosis.odd:NewNameAtTen")


class Flat:
    """Images of one colour, but none of frame 10."""

    def load(self, frame: int) -> np.ndarray | None:
        """A green one."""
        return None if frame == 10 else np.full((375, 1242, 3), (0, 120, 0), np.uint8)


@pytest.fixture(scope="module")
def renamed(short: Crossing) -> tuple[Scenario, list[Case]]:
    """A drive without noise whose cars all switch in frame 10."""
    task = replace(short.task(replace(short.conditions, effects=Profile())), tracker_spec=RENAMED)
    diagnosed, output = task.track()
    return Scenario(diagnosed, output), [each for each in task.run().cases if each.switched]


def test_the_worst_switch_is_the_one_that_tears_off_most() -> None:
    light, heavy = replace(OTHER.cases[0], weight=2), replace(OTHER.cases[0], weight=30)
    found = [replace(ONE_DRIVE), replace(OTHER, cases=(light, heavy))]
    assert [each.weight for each in worst_first(found, 3)] == [30, 5, 5]
    assert worst_first([], 3) == []


def test_the_frames_are_those_before_at_and_after_the_switch(
    renamed: tuple[Scenario, list[Case]],
) -> None:
    scenario, cases = renamed
    at_ten = cases[0]
    assert (at_ten.before, at_ten.frame) == (9, 10)
    assert frames_of(scenario, at_ten) == (8, 9, 10, 11)
    assert frames_of(scenario, replace(at_ten, before=4)) == (4, 9, 10, 11)
    assert frames_of(scenario, replace(at_ten, before=18, frame=19)) == (17, 18, 19, 19)


def test_a_moment_is_drawn_on_images_and_on_plain_ground(
    renamed: tuple[Scenario, list[Case]],
) -> None:
    plain, cases = renamed
    lively = Scenario(plain.diagnosed, plain.output, Flat())
    whole, strip = draw_case(plain, cases[0], 1)
    assert whole.shape[1] == strip.shape[1] == SHEET_WIDTH_PIXELS
    assert whole.shape[0] > strip.shape[0]
    drawn, _ = draw_case(lively, cases[0], 1)
    assert drawn.shape == whole.shape
    green = (drawn == (0, 120, 0)).all(axis=2)
    assert green[100:250, :300].mean() > 0.3  # frame 8 has its image
    assert not green[
        100:250, 2 * SHEET_WIDTH_PIXELS // 4 + 10 : 3 * SHEET_WIDTH_PIXELS // 4 - 10
    ].any()  # frame 10 has none


def test_what_a_switch_hangs_on_is_said() -> None:
    first, second = ONE_DRIVE.cases
    assert cause_words(first) == "hangs on misses"
    assert cause_words(second) == "hangs on misses or jitter"
    assert cause_words(OTHER.cases[0]) == "unexplained: scene or tracker"
    assert cause_words(replace(first, verdict="", sources=())) == ""


def test_a_sheet_has_a_picture_a_switch(short: Crossing, tmp_path: Path) -> None:
    perfect = replace(short.conditions, effects=Profile())
    task = replace(short.task(perfect), tracker_spec=RENAMED)
    findings = [task.run()]
    told: list[tuple[str, int, int]] = []
    files = draw_contact_sheet(
        tmp_path / "a" / "b", findings, [task], max_switches=2, renderer=None,
        progress=lambda *each: told.append(each),
    )  # fmt: skip
    assert files[0].name == SHEET_FILE
    assert len(files) == 3
    assert told == [("pictures", 1, 2), ("pictures", 2, 2)]
    sheet = cv2.imread(str(files[0]))
    assert sheet is not None
    assert sheet.shape[1] == SHEET_WIDTH_PIXELS
    assert files[1].name.startswith("01_crossing_0_car")


@pytest.mark.slow
def test_the_images_of_a_scene_are_drawn(short: Crossing, tmp_path: Path) -> None:
    perfect = replace(short.conditions, effects=Profile())
    task = replace(short.task(perfect), tracker_spec=RENAMED)
    plain, drawn = (
        draw_contact_sheet(
            tmp_path / str(name), [task.run()], [task], max_switches=1, renderer=name
        )
        for name in (None, "raster")
    )
    assert drawn[1].read_bytes() != plain[1].read_bytes()


def test_no_switch_is_no_picture(tmp_path: Path) -> None:
    assert draw_contact_sheet(tmp_path / "none", [], [], max_switches=3) == []
    assert not (tmp_path / "none").exists()


def test_a_folder_that_cannot_be_is_named(short: Crossing, tmp_path: Path) -> None:
    task = replace(short.task(replace(short.conditions, effects=Profile())), tracker_spec=RENAMED)
    (tmp_path / "file").write_text("here")
    with pytest.raises(BadOutput, match="no folder for pictures"):
        draw_contact_sheet(
            tmp_path / "file" / "x", [task.run()], [task], max_switches=1, renderer=None
        )
