"""Stress tests: the suites that come along, verdicts, and the command with its exit code."""

import json
from dataclasses import replace
from pathlib import Path

import pytest

from mot_sim.__main__ import main
from mot_sim.experiments.stress.suites import (
    Verdict,
    bound_from,
    find_suites,
    measured,
    read_suites,
    stress,
)
from mot_sim.experiments.sweep.bounds import Bound
from mot_sim.simulation.scene_names import SCENES
from mot_sim.tables import Interval
from tests.mot_sim.experiments.small import trial_files
from tracker.errors import BadConfig, BadFile, TrackingError, UnknownName

ODD = "tests.mot_sim.experiments.odd"
SUITES = """
[easy]
about = "an open road"
scene = "crossing"
frames = 5
settings = { "scene.houses" = 0.0, "scene.trees" = 0.0, "scene.furniture" = 0.0 }
bounds = { hota = 0.05, idsw = 100 }

[too-hard]
about = "an open road, and what nobody reaches"
scene = "crossing"
frames = 5
settings = { "scene.houses" = 0.0, "scene.trees" = 0.0, "scene.furniture" = 0.0 }
bounds = { HOTA = 1.0, IDSW = -1 }
"""
NAMES = {
    "smoke", "intersection", "roundabout", "look-alikes", "long-occlusions", "ego-turns",
    "low-frame-rate",
    "frame-drops", "bad-odometry", "pitch-shake", "night", "fog", "cuboids",
    "detector-skips", "low-score", "parked-row", "blind-corner",
}  # fmt: skip


@pytest.fixture
def suites(tmp_path: Path) -> Path:
    """A file with one suite that passes and one that cannot."""
    file = tmp_path / "suites.toml"
    file.write_text(SUITES)
    return file


def test_the_suites_that_come_along_can_be_run() -> None:
    suites = read_suites()
    assert set(suites) == NAMES
    for suite in suites.values():
        assert suite.scene in SCENES
        # The cheapest scene tells whether settings can be that are no scene's own.
        if suite.name != "parked-row":
            assert len(replace(suite, scene="crossing").design(("default",))) == 8
        metrics = {bound.metric for bound in suite.bounds}
        if suite.name == "cuboids":
            assert {"MOTA3D@2m", "HOTA3D", "within_2m", "heading_over_90"} == metrics
        else:
            assert {"HOTA", "IDF1", "MOTA", "IDSW"} == metrics
        assert suite.about


def test_suites_are_found_by_name() -> None:
    suites = read_suites()
    assert [each.name for each in find_suites(("night", "fog"), suites)] == ["night", "fog"]
    assert len(find_suites((), suites)) == len(suites)
    with pytest.raises(UnknownName, match="Did you mean 'roundabout'"):
        find_suites(("roundabouts",), suites)


PACKAGE = """
from pathlib import Path
from mot_sim import Bound, Suite
SUITES = Path(__file__).with_name("mine.toml")
ONE = Suite(name="one", about="code", scene="crossing", frames=3, bounds=(Bound("HOTA", 0.1),))
"""


def test_a_package_of_a_users_ships_suites(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    package, about = tmp_path / "their_suites", tmp_path / "their_suites-1.0.dist-info"
    package.mkdir()
    about.mkdir()
    (package / "__init__.py").write_text(PACKAGE)
    (package / "mine.toml").write_text(SUITES)
    (about / "METADATA").write_text("Metadata-Version: 2.1\nName: their-suites\nVersion: 1.0\n")
    points = [f"{name} = their_suites:SUITES" for name in ("easy", "theirs")]
    (about / "entry_points.txt").write_text(
        "\n".join(["[mot_sim.suites]", *points, "one = their_suites:ONE", ""])
    )
    monkeypatch.syspath_prepend(str(tmp_path))
    known = read_suites()
    assert [each.name for each in find_suites(("easy", "one", "fog"), known)] == [
        "easy", "one", "fog"
    ]  # fmt: skip
    assert [each.name for each in find_suites(("theirs",), known)] == ["easy", "too-hard"]
    assert main(["stress", "theirs", "--list"]) == 0
    assert "what nobody reaches" in capsys.readouterr().out
    with pytest.raises(BadConfig, match="suite easy is there twice"):
        find_suites(("easy", "theirs"), known)
    with pytest.raises(UnknownName, match="Did you mean 'theirs'"):
        find_suites(("their",), known)


def test_a_verdict_is_the_mean_against_the_bound_and_no_failed_trial() -> None:
    reached = Interval(0.70, 0.65, 0.75, 8)
    assert Verdict("a", "b", Bound("HOTA", 0.70), reached).passed
    assert not Verdict("a", "b", Bound("HOTA", 0.71), reached).passed
    assert not Verdict("a", "b", Bound("HOTA", 0.10), reached, failed=1).passed
    assert not Verdict("a", "b", Bound("HOTA", 0.1), Interval(None, None, None, 0)).passed


def test_bounds_follow_from_measurements_by_the_written_rule() -> None:
    assert bound_from("HOTA", Interval(0.806, 0.794, 0.818, 8)) == Bound("HOTA", 0.78)
    assert bound_from("HOTA", Interval(0.725, 0.677, 0.773, 8)) == Bound("HOTA", 0.67)
    assert bound_from("IDSW", Interval(1.0, 0.37, 1.63, 8)) == Bound("IDSW", 2.0)
    assert bound_from("IDSW", Interval(5.125, 2.66, 7.59, 8)) == Bound("IDSW", 7.6)
    assert bound_from("HOTA", Interval(0.8, None, None, 1)) is None


def test_a_suite_gives_a_verdict_a_tracker_and_bound(suites: Path, tmp_path: Path) -> None:
    suite = read_suites(suites)["easy"]
    trackers = ("default", f"odd={ODD}:GivesNaN")
    verdicts = stress(suite, trackers, tmp_path / "out", seeds=2)
    assert [(each.tracker, each.bound.metric, each.passed) for each in verdicts] == [
        ("default", "HOTA", True), ("default", "IDSW", True),
        ("odd", "HOTA", False), ("odd", "IDSW", False),
    ]  # fmt: skip
    assert verdicts[0].reached.count == 2
    assert verdicts[2].failed == 2
    assert "not finite" in str(verdicts[2].error)
    assert len(trial_files(tmp_path / "out" / "runs")) == 4


def test_the_command_says_pass_or_fail_and_goes_on_where_it_was(
    suites: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "out"
    line = ["stress", "--file", str(suites), "--seeds", "2", "--out", str(out)]
    assert main([*line, "easy"]) == 0
    told = capsys.readouterr()
    assert [each.split()[:4] for each in told.out.splitlines()] == [
        ["pass", "easy", "default", "HOTA"], ["pass", "easy", "default", "IDSW"]
    ]  # fmt: skip
    assert "at least 0.050" in told.out
    assert "2 of 2 bounds are kept" in told.err
    before = {path: path.stat().st_mtime_ns for path in trial_files(out / "runs")}
    assert main([*line, "--json", "-"]) == 1
    content = json.loads(capsys.readouterr().out)
    assert [(each["suite"], each["passed"]) for each in content] == [
        ("easy", True), ("easy", True), ("too-hard", False), ("too-hard", False)
    ]  # fmt: skip
    # too-hard has the same trials as easy: nothing was done twice.
    assert {path: path.stat().st_mtime_ns for path in trial_files(out / "runs")} == before
    assert main([*line, "too-hard"]) == 1
    assert capsys.readouterr().out.startswith("FAIL  too-hard")


def test_a_tracker_that_fails_is_named_and_fails_the_command(
    suites: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    line = ["stress", "easy", "--file", str(suites), "--seeds", "1"]
    assert main([*line, "--trackers", f"odd={ODD}:Raises"]) == 1
    told = capsys.readouterr()
    assert "(1 trials failed)" in told.out
    assert "frame 2: ZeroDivisionError" in " ".join(told.err.split())


def test_a_suite_that_cannot_be_run_is_named(suites: Path) -> None:
    suite = read_suites(suites)["easy"]
    with pytest.raises(BadConfig, match=r"suite easy: unknown axis 'scene\.huoses'.*scene\.houses"):
        stress(replace(suite, settings={"scene.huoses": 0.0}))
    with pytest.raises(BadConfig, match="suite easy: unknown scene 'crosing'"):
        stress(replace(suite, scene="crosing"))


def test_measuring_shows_the_bounds_and_fails_nothing(
    suites: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["stress", "too-hard", "--file", str(suites), "--seeds", "2", "--measure"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert len(lines) == 4
    assert "bound: HOTA = " in lines[0]


def test_suites_are_listed(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["stress", "--list"]) == 0
    shown = capsys.readouterr().out
    assert all(name in shown for name in NAMES)


@pytest.mark.parametrize(
    ("content", "error", "told"),
    [
        ("[a", BadFile, "no suites can be read"),
        ("a = 3", BadFile, "no table"),
        ('[a]\nabout = "x"\nscene = "crossing"\nframes = 3\n', BadFile, "bounds = None"),
        ("[a]\nframe = 3", UnknownName, "Did you mean 'frames'"),
        (
            '[a]\nabout = ""\nscene = "crossing"\nframes = 3\nbounds = {}',
            BadFile,
            "suite a: bounds: no bound",
        ),
        (
            '[a]\nabout = ""\nscene = "crossing"\nframes = 3\nbounds = { HOAT = 1 }',
            BadFile,
            "suite a: bounds: unknown score 'HOAT'",
        ),
        (
            '[a]\nabout = ""\nscene = "crossing"\nframes = 0\nbounds = { HOTA = 1 }',
            BadFile,
            "suite a: frames = 0: give 1 or more",
        ),
    ],
)
def test_files_that_hold_no_suites_are_refused(
    tmp_path: Path, content: str, error: type[TrackingError], told: str
) -> None:
    file = tmp_path / "suites.toml"
    file.write_text(content)
    with pytest.raises(error, match=told):
        read_suites(file)


@pytest.mark.parametrize(
    ("options", "told"),
    [(["nihgt"], "Did you mean 'night'"), (["night", "--seeds", "0"], "0 seeds")],
)
def test_wrong_input_is_one_line_and_exit_code_2(
    options: list[str], told: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["stress", *options]) == 2
    shown = capsys.readouterr().err
    assert told in " ".join(shown.split())
    assert "Traceback" not in shown


def test_a_suite_of_cuboids_is_measured_by_its_own_scores() -> None:
    suites = read_suites()
    of_cuboids = {bound.metric for bound in suites["cuboids"].bounds}
    assert {bound.metric for bound in measured(suites["cuboids"]).bounds} == of_cuboids
    assert measured(suites["cuboids"]).design(("default",)).spatial
    assert {bound.metric for bound in measured(suites["fog"], ("HOTA",)).bounds} == {"HOTA"}


def test_a_bound_on_cuboids_has_them_scored(tmp_path: Path) -> None:
    file = tmp_path / "suites.toml"
    content = '[a]\nabout = ""\nscene = "crossing"\nframes = 3\nbounds = {{{}}}'
    file.write_text(content.format('"mota3d@2m" = 0.1, hota = 0.1'))
    assert read_suites(file)["a"].design(("default",)).spatial
    file.write_text(content.format("hota = 0.1"))
    assert not read_suites(file)["a"].design(("default",)).spatial
