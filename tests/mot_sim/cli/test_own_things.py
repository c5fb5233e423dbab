"""Things of the working folder, by `module:name`: through the installed `mot-sim` itself."""

import json
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.mot_sim.cli.conftest import CommandLine
from tests.mot_sim.cli.test_bad_input import require_one_line
from tests.mot_sim.cli.test_command_line import console_script
from tests.mot_sim.own_things import FILES, write_own_things, write_package

SWEEP = (
    "sweep", "--scene", "mine:my_scene", "--axis", "scene.speed=10,18", "--seeds", "1",
    "--frames", "6", "--trackers", "default:costs=image_overlap=0.8+mine:MyCost=0.2,m=mine:Numbers",
    "--jobs", "2", "--out", "out/sweep",
)  # fmt: skip


@pytest.fixture
def place(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """A working folder with things of a user's own."""
    _forget(tmp_path.parent.parent)
    monkeypatch.chdir(write_own_things(tmp_path))
    yield tmp_path
    _forget(tmp_path)


def _forget(folder: Path) -> None:
    """Modules of these names in the folder or below it are loaded anew when they are asked for."""
    for name in FILES:
        module = sys.modules.get(name.removesuffix(".py"))
        if module is not None and Path(str(module.__file__)).is_relative_to(folder):
            del sys.modules[module.__name__]


def test_a_scene_of_the_working_folder_is_recorded_verified_and_tracked(place: Path) -> None:
    knobs = ("--knobs", "speed=18,frames=6", "--no-images")
    done = console_script("record", "mine:my_scene", "--out", "out/town", *knobs, cwd=place)
    assert (done.returncode, done.stderr) == (0, "")
    assert "1 episode, 6 frames" in done.stdout
    assert console_script("verify", "out/town", cwd=place).returncode == 0
    tracked = console_script(
        "track", "--root", "out/town", "--detections", "simulated", "--out", "out/tracks",
        "--tracker", "mine:forgetful", "--costs", "image_overlap=0.5,mine:MyCost=0.5",
        "--association", "mine:greedy", cwd=place,
    )  # fmt: skip
    assert (tracked.returncode, tracked.stderr) == (0, "")


def test_a_sweep_in_processes_finds_the_modules_and_goes_on(place: Path) -> None:
    done = console_script(*SWEEP, cwd=place)
    assert done.returncode == 0, done.stderr
    trials = sorted((place / "out/sweep/trials").rglob("*.json"))
    assert len(trials) == 4
    times = [path.stat().st_mtime_ns for path in trials]
    (place / "mine.py").write_text(FILES["mine.py"] + "\n# another\n")
    again = console_script(*SWEEP, cwd=place)
    assert again.returncode == 0, again.stderr
    assert [path.stat().st_mtime_ns for path in trials] == times
    assert len(sorted((place / "out/sweep/trials").rglob("*.json"))) == 8


def test_suites_and_trackers_of_the_working_folder_are_run(
    mot_sim: CommandLine, place: Path
) -> None:
    done = mot_sim("stress", "mine:MY_SUITE", "--seeds", 1, "--trackers", "m=mine:Numbers,default")
    assert done.code == 0, done.err
    assert [line.split()[:3] for line in done.out.splitlines()] == [
        ["pass", "overtaken", "m"], ["pass", "overtaken", "default"],
    ]  # fmt: skip
    scene = ("--scene", "mine:my_scene", "--seeds", "0", "--knobs", "frames=6")
    compared = mot_sim("compare", *scene, "--trackers", "m=mine:Numbers,mine:Stepper,iou")
    require_one_line(compared, "there is no callable 'Stepper' in mine")
    compared = mot_sim("compare", *scene, "--trackers", "m=mine:Numbers,bad:Stepper,iou")
    assert compared.code == 1
    assert "tracker bad:Stepper: failed on mine:my_scene-0: ZeroDivisionError" in compared.err
    assert compared.out.count("\n iou ") == compared.out.count("\n m ") > 0
    diagnosed = mot_sim("diagnose", "mine:my_scene", "--seeds", 1, "--set", "scene.frames=6")
    assert diagnosed.code == 0, diagnosed.err
    assert mot_sim("show", "mine:my_scene", "--frames", "0:1", "--out", "out/film").code == 0
    assert mot_sim("scenes", "mine:my_scene").out.startswith("One car drives ahead of us")


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["record", "nowhere:f", "--out", "x"], ["No module named 'nowhere'", "working folder"]),
        (["record", "mine:my_scen", "--out", "x"], ["Did you mean 'my_scene'"]),
        (["record", "divides:f", "--out", "x"], ["ZeroDivisionError", "(divides.py:2)"]),
        (["record", "bad:N", "--out", "x"], ["'bad:N' is no function"]),
        (["record", "bad:gives_none", "--out", "x"], ["gives a NoneType, no Scene"]),
        (["record", "bad:late", "--out", "x", "--no-images"], ["bad.py:", "AttributeError"]),
        (["record", "a:car:b", "--out", "x"], ["'a:car:b' is not written as MODULE:NAME"]),
        (["sweep", "--scene", "bad:timeless", "--axis", "scene.speed=1,2"], ["no knob frames"]),
        (["stress", "bad:N"], ["suite 'bad:N' is a int, no suite"]),
        (["stress", "mine:MY_SUITE", "--trackers", "m=scenes:my_scene"], ["hidden by another"]),
        (["kitti", "--costs", "bad:NoCost"], ["gives a NoCost, no Cost"]),
        (["track", "--out", "x", "--tracker", "mine:Numbers"], ["gives a Numbers, no Tracker"]),
        (["kitti", "--costs", "bad:RaisingCost"], ["bad.py:", "KeyError: 'nope'"]),
    ],
)
def test_what_cannot_be_had_is_one_line_and_exit_code_2(
    mot_sim: CommandLine, place: Path, tree: Path, arguments: list[str], words: list[str]
) -> None:
    root = ["--root", tree] if arguments[0] in ("kitti", "track") else []
    require_one_line(mot_sim(*arguments, *root), *words)


def test_things_of_installed_packages_are_listed_and_broken_ones_named(
    mot_sim: CommandLine, place: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    write_package(place / "site", "theirs", {
        "mot_sim.scenes": {"overtaking": "mine:my_scene", "gone": "no.such:thing"},
        "mot_sim.costs": {"height": "mine:MyCost"},
    })  # fmt: skip
    monkeypatch.syspath_prepend(str(place / "site"))
    listed = mot_sim("list")
    assert "One car drives ahead of us" in listed.out
    assert "How much lower the lower of two" in listed.out
    assert "broken: scene 'gone' of package theirs" in listed.out
    assert mot_sim("scenes", "overtaking").code == 0
    require_one_line(mot_sim("scenes", "gone"), "package theirs 1.0", "No module named 'no'")


def test_a_scene_is_measured_when_it_is_asked_for(mot_sim: CommandLine, place: Path) -> None:
    measured = mot_sim("scenes", "mine:my_scene", "--measure", "--seeds", "1", "--json")
    figures = json.loads(measured.out)["mine:my_scene"]
    assert figures["cars"] > 0.5
    assert figures["yaw_rate"] == 0.0
    assert figures["labels"]["pixels_1"] >= 200
    require_one_line(mot_sim("scenes", "--seeds", "3"), "--seeds 3 is for --measure")
    require_one_line(mot_sim("scenes", "--measure", "--seeds", "0"), "--seeds 0: give 1 or more")


def test_a_scene_is_held_against_recorded_drives(
    mot_sim: CommandLine, place: Path, tree: Path
) -> None:
    (tree / "training/oxts/0032.txt").unlink()
    measure = ("scenes", "mine:my_scene", "--measure", "--seeds", 1)
    beside = (*measure, "--like", "kitti", "--root", tree)
    shown = mot_sim(*beside, "--json", "--out", "out/like")
    assert shown.code == 0, shown.err
    assert "left out: 0032: no NAME.txt in" in shown.err
    like = json.loads(shown.out)["mine:my_scene"]["like"]["KITTI"]
    cars, standing = like["statistics"]["cars"], like["statistics"]["ego_standing"]
    assert (cars["low"], cars["median"], cars["high"]) == (2.0, 2.0, 2.0)
    assert cars["outside"] == pytest.approx(abs(cars["value"] - 2.0) / 2.0)
    assert (standing["median"], standing["value"], standing["outside"]) == (1.0, 0.0, 1.0)
    assert standing["gap"] == 1.0
    assert like["statistics"]["ego_speed"]["median"] is None  # no drive shows any
    assert mot_sim("report", "out/like", "--out", "like.html").code == 0
    assert "Cumulated distributions" in (place / "like.html").read_text()
    require_one_line(mot_sim(*measure, "--like", "kiti"), "Did you mean 'kitti'?")
    require_one_line(mot_sim(*measure, "--like", "kitti"), "set MOT_SIM_KITTI_ROOT or pass --root")
    require_one_line(mot_sim(*measure, "--root", tree), "is for --like NAME")
    require_one_line(mot_sim("scenes", "--like", "kitti"), "--like kitti is for --measure")
    require_one_line(mot_sim("scenes", "--measure", "--knobs", "frames=9"), "name the scene")
