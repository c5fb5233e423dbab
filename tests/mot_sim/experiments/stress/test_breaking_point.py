"""Breaking points: searched by the fall of each seed, told with the interval of the level."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given as drawn
from hypothesis import strategies as st

from mot_sim.__main__ import main
from mot_sim.experiments.stress import breaking_point
from mot_sim.experiments.stress.breaking_point import (
    BreakingPoint,
    BreakingPointSpec,
    Reach,
    breaking_points,
)
from tests.mot_sim.experiments.small import BARE, trial_files
from tracker.errors import BadConfig, TrackingError, UnknownName

ODD = "tests.mot_sim.experiments.odd"
SMALL = [
    "breaking-point", "--scene", "crossing", "--seeds", "2", "--frames", "6",
    "--trackers", "default",
    *(word for axis in BARE for word in ("--set", f"{axis}=0")),
]  # fmt: skip


def small(axis: str = "detector.jitter", **changes: Any) -> BreakingPointSpec:
    """A question about an open crossing."""
    given: dict[str, Any] = {
        "trackers": ("default",), "scene": "crossing", "seeds": 2, "frames": 6, "fixed": BARE,
    }  # fmt: skip
    return BreakingPointSpec(axis, **{**given, **changes})


class Swept:
    """A sweep whose score falls by slope * level + wobble, a seed a wobble."""

    def __init__(self, slopes: list[float]) -> None:
        self.slopes, self.levels = slopes, []

    def __call__(self, design: Any, folder: Path, **_: Any) -> Any:
        (levels,) = design.axes.values()
        self.levels.append(levels[0])
        rows = [
            {"seed": seed, "error": None, "HOTA": 0.8 + 0.05 * seed - slope * levels[0]}
            for seed, slope in enumerate(self.slopes)
        ]
        return type("Table", (), {"to_pylist": lambda self: rows})()


def test_a_line_breaks_where_it_must_with_the_interval_of_its_seeds(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    slopes = [0.04, 0.05, 0.06]
    fake = Swept(slopes)
    monkeypatch.setattr(breaking_point, "sweep", fake)
    (found,) = breaking_points(small(seeds=3, precision=0.02, end=8.0), tmp_path)
    # fall = slope * level: the mean reaches 0.05 at 1; its interval is 0.05 ± 4.303 * 0.01 / 3**0.5
    half = 4.302653 * 0.01 / np.sqrt(3.0)
    assert found.level == pytest.approx(1.0, rel=0.02)
    assert found.low == pytest.approx(0.05 / (0.05 + half), rel=0.03)
    assert found.high == pytest.approx(0.05 / (0.05 - half), rel=0.03)
    assert len(fake.levels) == len(set(fake.levels))  # no level was run twice
    assert found.score.mean == pytest.approx(0.85)


def test_what_never_breaks_is_said_to(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(breaking_point, "sweep", Swept([0.001, 0.001]))
    (found,) = breaking_points(small(end=4.0), tmp_path)
    assert (found.level, found.low, found.high, found.tried) == (None, None, None, 4.0)


def test_an_axis_ends_where_it_refuses_levels(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    fake = Swept([0.0, 0.0])
    monkeypatch.setattr(breaking_point, "sweep", fake)
    (found,) = breaking_points(small("timing.drops"), tmp_path)
    assert found.tried == 1.0


def test_listed_levels_are_tried_and_no_others(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    class Rates(Swept):
        def __call__(self, design: Any, folder: Path, **_: Any) -> Any:
            (levels,) = design.axes.values()
            self.levels.append(levels[0])
            rows = [{"seed": n, "error": None, "HOTA": 0.01 * levels[0]} for n in range(2)]
            return type("Table", (), {"to_pylist": lambda self: rows})()

    fake = Rates([])
    monkeypatch.setattr(breaking_point, "sweep", fake)
    (found,) = breaking_points(small("rig.frame_rate", levels=(10.0, 5.0, 2.5, 2.0)), tmp_path)
    assert found.level == 5.0
    assert set(fake.levels) <= {10.0, 5.0, 2.5, 2.0}


@pytest.mark.slow
def test_real_noise_breaks_a_real_tracker_and_nothing_is_repeated(tmp_path: Path) -> None:
    told: list[object] = []
    question = small(drop=0.1, precision=0.5, frames=4)
    (found,) = breaking_points(question, tmp_path, tell=lambda name, level: told.append(level))
    assert isinstance(found.level, float)
    assert 0.0 < found.level < 64.0
    assert told[0] == 0.0
    falls = {level: fall.mean for level, _, fall in found.curve}
    assert falls[0.0] == 0.0
    assert min(level for level, fall in falls.items() if fall >= 0.1) >= found.level / 1.5
    files = {path: path.stat().st_mtime_ns for path in trial_files(tmp_path / "runs")}
    assert len(files) == 2 * len(found.curve)
    (again,) = breaking_points(question, tmp_path)
    assert (again.level, again.low, again.high) == (found.level, found.low, found.high)
    assert {path: path.stat().st_mtime_ns for path in trial_files(tmp_path / "runs")} == files


def test_the_command_shows_table_curves_and_json(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    plot, out = tmp_path / "curve.png", tmp_path / "out"
    line = [
        *SMALL, "--axis", "detector.misses", "--to", "4", "--drop", "0.9", "--costs", "volume",
        "--out", str(out),
    ]  # fmt: skip
    content_file = tmp_path / "points.json"
    assert main([*line, "--plot", str(plot), "--json", str(content_file)]) == 0
    shown = capsys.readouterr()
    assert "costs 90 points of HOTA" in " ".join(shown.out.split())
    *_, default, volume, _, note, _ = shown.out.splitlines()
    assert [each.split()[0] for each in (default, volume)] == ["default", "volume"]
    assert note == "2 seeds: too few for an interval to mean much; 5 or more are better."
    assert plot.read_bytes()[:4] == b"\x89PNG"
    content = json.loads(content_file.read_text())
    assert [each["tracker"] for each in content["trackers"]] == ["default", "volume"]
    assert content["trackers"][0]["curve"][0]["level"] == 0.0


def test_a_tracker_that_fails_has_no_breaking_point(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    question = small(trackers=(f"odd={ODD}:Raises",), end=1.0)
    (found,) = breaking_points(question, tmp_path)
    assert isinstance(found, BreakingPoint)
    assert (found.level, found.failed) == (None, 4)
    assert "ZeroDivisionError" in str(found.error)


@pytest.mark.parametrize(
    ("given", "error", "told"),
    [
        ({"axis": "detector.jitta"}, UnknownName, "Did you mean 'detector.jitter'"),
        ({"metric": "IDSW"}, UnknownName, "unknown rate 'IDSW'"),
        ({"drop": 5.0}, BadConfig, "a drop of 5"),
        ({"seeds": 1}, BadConfig, "2 or more"),
        ({"precision": 0.0}, BadConfig, "precision 0"),
        ({"axis": "detector.weather", "start": "clear"}, BadConfig, "--levels"),
        ({"levels": (1.0,)}, BadConfig, "two levels or more"),
        ({"end": 0.0}, BadConfig, "from 0.0 to 0.0 is no way"),
        ({"end": -3.0}, TrackingError, "-3"),
        ({"axis": "rig.frame_rate", "start": 10.0, "end": 3.1}, BadConfig, "10 Hz over a whole"),
    ],
)
def test_questions_without_an_answer_are_refused(
    given: dict, error: type[TrackingError], told: str
) -> None:
    with pytest.raises(error, match=told):
        small(**given)


@pytest.mark.parametrize(
    ("options", "told"),
    [
        (["--axis", "detector.jitta"], "Did you mean"),
        (["--axis", "detector.jitter", "--plot", "x.jpg"], "ends in .png"),
        (["--axis", "detector.jitter", "--set", "scene.cars"], "write NAME=LEVEL"),
    ],
)
def test_wrong_input_is_one_line_and_exit_code_2(
    options: list[str], told: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main([*SMALL, *options]) == 2
    shown = capsys.readouterr().err
    assert told in " ".join(shown.split())
    assert "Traceback" not in shown


def test_a_search_by_hand() -> None:
    asked: list[float] = []

    def is_bad(place: float) -> bool:
        asked.append(place)
        return place >= 3.1

    assert Reach(1.0, 64.0, 0.1).bracket(is_bad) == (3.0, 3.25)
    assert asked == [1.0, 2.0, 4.0, 3.0, 3.5, 3.25]


def test_what_never_turns_bad_has_no_bracket() -> None:
    asked: list[float] = []
    assert Reach(1.0, 5.0).bracket(lambda place: bool(asked.append(place))) is None
    assert asked == [1.0, 2.0, 4.0, 5.0]


def test_what_is_bad_from_the_start_on_is_found_at_0() -> None:
    found = Reach(1.0, 64.0).bracket(lambda _: True)
    assert found is not None
    assert found[0] == 0.0
    assert found[1] <= 1e-4


@drawn(st.integers(1, 40), st.integers(1, 5), st.integers(1, 40))
def test_whole_places_are_found_exactly(turn: int, first: int, most: int) -> None:
    found = Reach(float(first), float(most), is_whole=True).bracket(lambda place: place >= turn)
    assert found == ((turn - 1.0, float(turn)) if turn <= most else None)


@drawn(st.floats(1e-3, 60.0), st.floats(0.1, 4.0), st.sampled_from([0.01, 0.1, 0.5]))
def test_the_bracket_holds_the_turn_and_is_narrow(
    turn: float, first: float, precision: float
) -> None:
    found = Reach(first, 64.0, precision).bracket(lambda place: place >= turn)
    assert found is not None
    near, far = found
    assert near < turn <= far
    assert far - near <= precision * far


@pytest.mark.parametrize("is_whole", [True, False])
def test_the_first_step_is_cut_to_the_farthest_place(is_whole: bool) -> None:
    asked: list[float] = []
    Reach(8.0, 3.0, is_whole=is_whole).bracket(lambda place: bool(asked.append(place)))
    assert asked == [3.0]
