"""`mot-sim diagnose`: on a scene, on a suite, on KITTI; what it writes and what it refuses."""

import json
from pathlib import Path

import pytest

from mot_sim.diagnosis import work
from mot_sim.experiments.result_file import read_result
from tests.mot_sim.cli.conftest import CommandLine, files, write
from tests.mot_sim.cli.test_bad_input import require_one_line

BARE = ("--set", "scene.houses=0", "--set", "scene.trees=0", "--set", "scene.furniture=0")
SMALL = ("diagnose", "crossing", "--seeds", "1", "--frames", "12", *BARE)
ODD = "odd=tests.mot_sim.diagnosis.odd:NewNameAtTen"


@pytest.fixture(autouse=True)
def cache(tmp_path_factory: pytest.TempPathFactory, monkeypatch: pytest.MonkeyPatch) -> None:
    """Truths are kept for all tests of this file, and not in the user's cache."""
    monkeypatch.setenv("MOT_SIM_CACHE", str(tmp_path_factory.getbasetemp() / "cache"))


def test_a_scene_is_diagnosed_drawn_and_kept(mot_sim: CommandLine, tmp_path: Path) -> None:
    out = tmp_path / "why"
    options = ("--tracker", ODD, "--attribute",
               "--contact-sheet", out / "moments", "--max-switches", "1",
               "--renderer", "none", "--out", out)  # fmt: skip
    done = mot_sim(*SMALL, *options)
    assert done.code == 0
    for words in ("around", "occlusion", "hangs on", "scene or tracker", "crossing/0"):
        assert words in done.out
    assert "written:" in done.err
    result = read_result(out)
    assert (result.kind, result.made.trials) == ("diagnosis", (1, 1))
    assert result.files[0] == "moments/sheet.png"
    events = result.table("events")
    assert events is not None
    assert events.column("switches")[-1] > 0  # type: ignore[operator]
    there = files(out)
    assert {"cases.csv", "cases.parquet", "events.csv", "result.json"} < set(there)
    assert any(name.startswith("drives/") for name in there)


def test_json_and_csv_hold_everything(mot_sim: CommandLine) -> None:
    told = json.loads(mot_sim(*SMALL, "--tracker", ODD, "--json", "-").out)
    assert set(told) == {"events", "drives", "cases"}
    assert told["events"][-1]["switches"] == len(
        [row for row in told["cases"] if row["switch"]]
    )  # fmt: skip
    lines = mot_sim(*SMALL, "--tracker", ODD, "--csv", "-").out.splitlines()
    assert lines[0].startswith("around,events,switches,switches per event,")
    assert lines[-1].startswith("all,")


def test_no_switches_are_said_and_no_error(mot_sim: CommandLine, tmp_path: Path) -> None:
    options = ("--profile", "perfect", "--attribute", "--contact-sheet", tmp_path / "sheet")
    done = mot_sim(*SMALL, *options)
    assert done.code == 0
    assert "no switches: there is nothing to explain" in done.err
    assert not (tmp_path / "sheet").exists()


def test_a_drive_without_cars_says_so(mot_sim: CommandLine, tree: Path) -> None:
    write(
        tree / "training/label_02/0030.txt",
        "0 -1 DontCare -1 -1 -10 1 1 9 9 -1 -1 -1 -1 -1 -1 -1\n",
    )
    done = mot_sim("diagnose", "--root", tree, "--sequences", "0030")
    assert done.code == 0
    assert "no car that counts in any drive" in done.err


def test_kitti_is_diagnosed_as_far_as_its_labels_say(mot_sim: CommandLine, tree: Path) -> None:
    done = mot_sim("diagnose", "--root", tree, "--detections", "rrc", "--tracker", "paper")
    assert done.code == 0
    for words in ("0030", "0031", "detector gap", "camera turns", "look-alike."):
        assert words in " ".join(done.out.split())
    assert "0032" not in done.out
    without = mot_sim("diagnose", "--root", tree, "--ego", "none")
    assert "camera turns" in " ".join(without.out.split()).partition("do not tell of")[2]


def test_an_interrupt_keeps_what_is_finished(
    mot_sim: CommandLine, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def interrupted(*_: object, **__: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(work, "diagnose", interrupted)
    done = mot_sim(*SMALL, "--out", tmp_path / "out")
    assert done.code == 130
    assert f"finished drives stand in {tmp_path / 'out'}" in " ".join(done.err.split())


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ([], ["give one of", "--suite"]),
        (["crossing", "--suite", "night"], ["give one of"]),
        (["crosing"], ["unknown scene 'crosing'", "Did you mean 'crossing'"]),
        (["--suite", "nigth"], ["unknown suite 'nigth'", "Did you mean 'night'"]),
        (["crossing", "--tracker", "defalt"], ["unknown tracker", "Did you mean 'default'"]),
        (["crossing", "--tracker", "default,paper"], ["give one tracker"]),
        (["crossing", "--tracker", "x=no_such:Thing"], ["no_such"]),
        (["crossing", "--seeds", "0"], ["--seeds 0", "1 or more"]),
        (["crossing", "--first-seed", "-2"], ["--first-seed -2"]),
        (["crossing", "--profile", "rcc"], ["unknown profile", "Did you mean 'rrc'"]),
        (["crossing", "--frames", "0"], ["0 frames"]),
        (["crossing", "--frames", "first-half"], ["--frames first-half", "whole number"]),
        (["crossing", "--set", "odometry"], ["--set odometry", "NAME=LEVEL"]),
        (["crossing", "--set", "odometry.drfit=1"], ["odometry.drift"]),
        (["crossing", "--jobs", "0"], ["--jobs 0"]),
        (["crossing", "--max-switches", "0"], ["--max-switches 0"]),
        (["crossing", "--contact-sheet", "x", "--renderer", "rastr"], ["renderer", "raster"]),
        (["--root", "/nowhere"], ["/nowhere"]),
        (["--root", "/nowhere", "--attribute"], ["--attribute is for scenes"]),
        (["--root", "/nowhere", "--first-seed", "3"], ["--first-seed is for scenes"]),
        (["crossing", "--json", "-", "--csv", "-"], ["would mix"]),
    ],
)
def test_bad_options_are_one_line(
    mot_sim: CommandLine, options: list[str], words: list[str]
) -> None:
    require_one_line(mot_sim("diagnose", *options), *words)


def test_a_sequence_without_labels_is_refused(mot_sim: CommandLine, tree: Path) -> None:
    done = mot_sim("diagnose", "--root", tree, "--sequences", "0032")
    require_one_line(done, "sequence 0032: no labels", "--sequences labelled")


def test_a_tracker_that_fails_is_one_line(mot_sim: CommandLine) -> None:
    done = mot_sim(*SMALL, "--tracker", "odd=tests.mot_sim.diagnosis.odd:FailsAtFive")
    assert done.code == 2
    assert "tracker odd failed in frame 5 of crossing/0: ValueError: five" in done.err
