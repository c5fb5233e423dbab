"""The frame around the commands: help, version, pipes, and the commands that need no data."""

import json
import os
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import pytest

from mot_sim.cli import COMMANDS
from mot_sim.cli import doctor as doctor_module
from mot_sim.simulation.scene_names import SCENES
from tests.mot_sim.cli.conftest import FRAMES, CommandLine


def console_script(*arguments: str, **more: object) -> subprocess.CompletedProcess[str]:
    """The installed `mot-sim` in a process of its own."""
    script = Path(sys.executable).with_name("mot-sim")
    command = [str(script)] if script.is_file() else [sys.executable, "-m", "mot_sim"]
    return subprocess.run(
        [*command, *arguments], capture_output=True, text=True, check=False, timeout=300, **more
    )


@pytest.mark.parametrize(
    ("line", "told"),
    [
        ([], "no command is given; mot-sim --help lists them"),
        (["trak", "--out", "x"], "Did you mean 'track'?"),
        (["-v", "track"], "-v is no command; options follow it: mot-sim COMMAND -v"),
    ],
)
def test_what_is_no_command_is_one_line(mot_sim: CommandLine, line: list[str], told: str) -> None:
    outcome = mot_sim(*line)
    assert (outcome.code, outcome.out) == (2, "")
    assert outcome.err.startswith("error: ")
    assert outcome.err.endswith(f"{told}\n")
    assert outcome.err.count("\n") == 1


@pytest.mark.parametrize("columns", [60, 100])
def test_the_overview_keeps_within_the_terminal(
    mot_sim: CommandLine, monkeypatch: pytest.MonkeyPatch, columns: int
) -> None:
    monkeypatch.setenv("COLUMNS", str(columns))
    widths = [len(line) for line in mot_sim("--help").out.splitlines()]
    assert columns - 20 < max(widths) <= columns


@pytest.mark.parametrize("command", [None, *COMMANDS])
def test_help_says_what_a_command_does_with_an_example(
    mot_sim: CommandLine, command: str | None
) -> None:
    outcome = mot_sim(*([] if command is None else [command]), "--help")
    assert outcome.code == 0
    if command is None:
        unwrapped = " ".join(outcome.out.replace("│", " ").split())
        for name, kind in COMMANDS.items():
            assert f"{name} {(kind.__doc__ or '').splitlines()[0]}" in unwrapped
    else:
        assert f"\nmot-sim {command}" in outcome.out


def test_the_console_script_ends_in_one_line_and_exit_code_2(tmp_path: Path) -> None:
    env = {key: value for key, value in os.environ.items() if key != "MOT_SIM_KITTI_ROOT"}
    done = console_script("track", "--out", str(tmp_path / "out"), env=env)
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr == "error: no KITTI root is given; set MOT_SIM_KITTI_ROOT or pass --root\n"
    assert not (tmp_path / "out").exists()


def test_version_is_one_line(mot_sim: CommandLine) -> None:
    outcome = mot_sim("--version")
    assert outcome.code == 0
    assert outcome.out.startswith("mot-sim ")


@pytest.mark.parametrize(
    "command", ["--help", pytest.param("list", marks=pytest.mark.slow)], ids=str
)
def test_a_broken_pipe_is_silent(command: str) -> None:
    reading, writing = os.pipe()
    os.close(reading)
    try:
        done = subprocess.run(
            [sys.executable, "-m", "mot_sim", command],
            stdout=writing,
            stderr=subprocess.PIPE,
            check=False,
            timeout=60,
        )
    finally:
        os.close(writing)
    assert (done.returncode, done.stderr) == (0, b"")


def test_ctrl_c_outside_of_tracking_is_one_line(
    mot_sim: CommandLine, monkeypatch: pytest.MonkeyPatch
) -> None:
    def interrupt(*_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(COMMANDS["list"], "__call__", interrupt)
    outcome = mot_sim("list")
    assert (outcome.code, outcome.err) == (130, "error: interrupted\n")


def test_verbose_says_what_is_done(mot_sim: CommandLine, tree: Path) -> None:
    outcome = mot_sim("kitti", "--root", tree, "-v")
    assert f"info: 0030: {2 * FRAMES} rows of 2 ids\n" in outcome.err
    assert mot_sim("kitti", "--root", tree).err == ""


def test_list_names_what_the_registers_hold(mot_sim: CommandLine) -> None:
    names = json.loads(mot_sim("list", "--json").out)
    assert {"default", "paper"} <= names["--tracker"].keys()
    assert {"image_overlap", "reprojection", "volume"} <= names["--costs"].keys()
    assert {"oxts", "orbslam3", "none"} <= names["--ego"].keys()
    assert all(what for register in names.values() for what in register.values())
    shown = mot_sim("list")
    assert shown.code == 0
    assert "hungarian" in shown.out


def test_doctor_finds_what_a_tree_holds(mot_sim: CommandLine, tree: Path) -> None:
    outcome = mot_sim("doctor", "--root", tree, "--json")
    assert outcome.code == 0
    found = {each["what"]: each for each in json.loads(outcome.out)["findings"]}
    assert found["training sequences"]["detail"] == "3: 0030-0032"
    assert found["training/label_02"]["detail"] == "2: 0030-0031"
    assert found["training/image_02"]["state"] == "missing"
    assert found["detections"]["detail"] == "rrc"
    assert found["numpy"]["state"] == found["OpenCV build"]["state"] == "ok"
    assert {"OpenGL: EGL", "OpenGL: OSMesa", "video: H.264"} <= found.keys()


def test_doctor_without_data_is_no_failure(mot_sim: CommandLine, tmp_path: Path) -> None:
    for root in ([], ["--root", tmp_path / "nowhere"]):
        outcome = mot_sim("doctor", *root)
        assert outcome.code == 0
        assert "KITTI root" in outcome.out


def test_doctor_fails_when_the_core_is_broken(
    mot_sim: CommandLine, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(doctor_module, "CORE_PACKAGES", ("numpy", "no_such_package"))
    outcome = mot_sim("doctor")
    assert outcome.code == 1
    assert "broken" in outcome.out


def test_doctor_warns_of_a_second_opencv(monkeypatch: pytest.MonkeyPatch) -> None:
    class Installed:
        def __init__(self, name: str) -> None:
            self.metadata, self.version = {"Name": name}, "5.0"

    both = [Installed("opencv-python-headless"), Installed("opencv-python"), Installed("numpy")]
    monkeypatch.setattr("importlib.metadata.distributions", lambda: both)
    finding = doctor_module.find_opencv()
    assert finding.state == "missing"
    assert "opencv-python 5.0, opencv-python-headless 5.0; uninstall" in finding.detail


def test_the_demo_writes_its_files_and_shows_its_scores(
    mot_sim: CommandLine, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    demo = pytest.importorskip("mot_sim.demo")
    from mot_sim.metrics import evaluate_sequence
    from tracker import Tracks

    scores = {"default": evaluate_sequence(Tracks.empty(), Tracks.empty(), 3)}
    asked = []

    def run_demo(out: Path, seed: int, overwrite: bool, progress, scene) -> object:
        asked.append((out, seed, overwrite, scene.name))
        for done in range(3):
            progress(done + 1, 3)
        return SimpleNamespace(
            video=out / "demo.mp4",
            stills=(out / "a.png", out / "b.png"),
            tracks=out / "tracks.txt",
            truth=out / "truth.txt",
            scores_json=out / "scores.json",
            scores_table=out / "scores.md",
            frame_count=3,
            scores=scores,
        )

    monkeypatch.setattr(demo, "run_demo", run_demo)
    out = tmp_path / "demo"
    outcome = mot_sim("demo", "--out", out, "--seed", 7, "--overwrite")
    assert asked == [(out, 7, True, "intersection")]
    assert (outcome.code, outcome.err) == (0, "")
    assert f"video:   {out / 'demo.mp4'}\n" in outcome.out
    assert "seed 7" in outcome.out
    summary = json.loads(mot_sim("demo", "--out", out, "--json").out)
    assert summary["frames"] == 3
    assert summary["files"]["tracks"] == [str(out / "tracks.txt")]


@pytest.mark.slow
def test_the_real_demo_runs(mot_sim: CommandLine, tmp_path: Path) -> None:
    out = tmp_path / "demo"
    few = "--scene", "gauntlet", "--knobs", "frames=12,weather=rain"
    outcome = mot_sim("demo", "--out", out, *few)
    assert outcome.code == 0
    assert (out / "demo.mp4").is_file()
    again = mot_sim("demo", "--out", out)
    assert again.code == 2
    assert again.err.count("\n") == 1


def test_scenes_are_listed_with_their_knobs(mot_sim: CommandLine) -> None:
    listed = mot_sim("scenes")
    assert listed.code == 0
    row = next(line for line in listed.out.splitlines() if line.startswith(" gauntlet"))
    assert "Cars cross behind parked vans." in row
    assert "rate=0.35, speed=9.0, vans=5" in row
    assert "weather=noon" in listed.err
    told = json.loads(mot_sim("scenes", "--json").out)
    assert sorted(told) == sorted(SCENES)
    assert told["crossing"]["knobs"] == {"frames": 140}
