"""`mot-sim sweep`: what it shows, what it writes, what it refuses."""

import json
import os
import signal
import subprocess
import sys
import time
from math import pi
from pathlib import Path

import pyarrow.parquet as pq
import pytest
from rich.console import Console

from mot_sim.__main__ import main
from mot_sim.cli.sweep import show_axes
from mot_sim.cli.terminal import Terminal
from mot_sim.files.field_docstrings import field_docstrings
from mot_sim.tables import Column, Table
from tests.mot_sim.experiments.small import trial_files
from tracker import Tracker

ROOT = Path(__file__).parents[4]
SMALL = [
    "sweep", "--scene", "crossing", "--seeds", "2", "--frames", "4", "--set", "scene.houses=0",
    "--set", "scene.trees=0", "--set", "scene.furniture=0",
]  # fmt: skip


def test_a_sweep_shows_means_differences_and_curves(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out, plot = tmp_path / "out", tmp_path / "curves.png"
    line = [*SMALL, "--axis", "detector.jitter=0,2", "--trackers", "default,paper"]
    assert main([*line, "--out", str(out), "--plot", str(plot)]) == 0
    told = capsys.readouterr()
    assert "jitter=2" in told.out
    assert "less default, seed by seed" in told.out
    assert "8 trials" in told.err
    assert plot.read_bytes()[:4] == b"\x89PNG"
    assert pq.read_table(out / "table.parquet").num_rows == 8
    assert main([*line, "--out", str(out), "--json", "-"]) == 0
    content = json.loads(capsys.readouterr().out)
    assert [entry["tracker"] for entry in content] == ["default", "paper"] * 2


def test_failed_trials_are_named_and_the_exit_code_is_1(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    trackers = "default,odd=tests.mot_sim.experiments.odd:Twice"
    line = [*SMALL, "--axis", "detector.jitter=0", "--trackers", trackers]
    assert main([*line, "--out", str(tmp_path)]) == 1
    told = " ".join(capsys.readouterr().err.split())
    assert "odd: 2 trials failed: frame 0: ids that stand twice in a frame: [7]" in told


def test_axes_are_listed_with_what_they_are(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["sweep", "--scene", "crossing", "--list-axes"]) == 0
    shown = {line.split()[0]: line for line in capsys.readouterr().out.splitlines() if line.split()}
    for axis in ("scene.trees", "rig.frame_rate", "odometry.drift", "tracker.lifecycle.max_gap"):
        assert axis in shown
    text = field_docstrings(Tracker)["strong_score"]
    assert shown["tracker.strong_score"].strip().split(maxsplit=2)[1:] == ["0.0", text]


def test_axes_are_listed_as_json(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["sweep", "--scene", "crossing", "--list-axes", "--json", "-"]) == 0
    rows = {row["axis"]: row for row in json.loads(capsys.readouterr().out)}
    assert rows["tracker.lift.use_box_height"]["own value"] == "false"
    assert rows["tracker.lift.yaw"]["own value"] == -0.5 * pi
    assert rows["scene.frames"]["what it is"] == "length of the run in frames, at 10 Hz."
    both = [row["what it is"] for axis, row in rows.items() if axis.startswith("misses.by_both.")]
    assert len(both) == 24
    assert len(set(both)) == 1


def test_a_narrow_terminal_gets_a_list_of_axes(capsys: pytest.CaptureFixture[str]) -> None:
    rows = (
        ("a.x.0", 1.5, "How far the one is from the other, in metres along the road."),
        ("a.x.1", 2, "How far the one is from the other, in metres along the road."),
        ("a.y", "", ""),
    )
    columns = (Column("axis", "name"), Column("own value", "name"), Column("what it is"))
    terminal = Terminal()
    terminal.out = Console(width=40)
    show_axes(terminal, Table(columns, rows))
    assert capsys.readouterr().out == (
        "a.x.0 = 1.5\na.x.1 = 2\n    How far the one is from the other,\n"
        "    in metres along the road.\na.y =\n"
    )


@pytest.mark.parametrize(
    ("options", "told"),
    [
        (["--axis", "detector.jitter=0"], "give --out DIR"),
        ([], "empty design"),
        (["--axis", "detector.jitta=0", "--out", "x"], "Did you mean 'detector.jitter'"),
        (["--axis", "detector.jitter=lots", "--out", "x"], "give a number"),
        (["--axis", "nothing", "--out", "x"], "write NAME=LEVEL"),
        (["--set", "nothing", "--axis", "detector.jitter=0"], "write NAME=LEVEL"),
        (["--profile", "rrk", "--axis", "detector.jitter=0"], "Did you mean 'rrc'"),
        (["--design", "nois"], "Did you mean 'noise'"),
        (["--axis", "detector.jitter=0", "--jobs", "0", "--out", "x"], "--jobs 0"),
        (["--axis", "detector.jitter=0", "--plot", "x.jpg"], "ends in .png"),
        (["--axis", "detector.jitter=0..2", "--out", "x"], "is a range"),
    ],
)
def test_what_is_wrong_is_one_line_and_exit_code_2(
    options: list[str], told: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main([*SMALL, *options]) == 2
    error = capsys.readouterr().err
    assert error.startswith("error: ")
    assert told in " ".join(error.split())
    assert not Path("x").exists()


@pytest.mark.slow
def test_ctrl_c_says_how_to_go_on_and_the_same_command_does_the_rest(tmp_path: Path) -> None:
    levels = ",".join(f"{0.1 * number:.1f}" for number in range(20))
    line = [*SMALL, "--axis", f"detector.jitter={levels}", "--out", str(tmp_path), "--jobs", "2"]
    environment = os.environ | {"PYTHONPATH": str(ROOT)}
    process = subprocess.Popen(
        [sys.executable, "-m", "mot_sim", *line], env=environment, start_new_session=True,
        stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True,
    )  # fmt: skip
    deadline = time.monotonic() + 240.0
    while len(trial_files(tmp_path)) < 4:
        assert process.poll() is None
        assert time.monotonic() < deadline
        time.sleep(0.01)
    os.killpg(process.pid, signal.SIGINT)
    error = process.communicate(timeout=60.0)[1]
    assert process.returncode == 130
    assert "interrupted: finished trials stand in" in " ".join(error.split())
    assert "Traceback" not in error
    before = {path: path.stat().st_mtime_ns for path in trial_files(tmp_path)}
    assert 4 <= len(before) < 80
    assert main(line[:-2]) == 0
    assert len(trial_files(tmp_path)) == 80
    assert all(path.stat().st_mtime_ns == then for path, then in before.items())
