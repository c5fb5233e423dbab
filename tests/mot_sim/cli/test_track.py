"""`mot-sim track`: what it writes, and how it goes on after Ctrl-C."""

import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import cv2
import numpy as np
import pytest

from mot_sim.datasets import read_results
from tests.mot_sim.cli.conftest import (
    CAMERA,
    FRAMES,
    NAMES,
    OXTS_ROW,
    CommandLine,
    boxes_csv,
    files,
    write,
)
from tracker import Frame, Tracker, Tracks


def run_of(*names: str) -> list[str]:
    """The files of a run with these sequences finished, in order."""
    return [f"{name}{end}" for name in names for end in (".estimates.csv", ".txt")] + ["run.json"]


ALL_FILES = run_of("0030", "0031", "0032")


@pytest.fixture
def interrupt_after(monkeypatch: pytest.MonkeyPatch) -> Callable[[int], None]:
    """Sets the number of frames after which Ctrl-C comes; negative: never."""
    step, left = Tracker.step, [-1]

    def interrupted(tracker: Tracker, frame: Frame) -> Tracks:
        left[0] -= 1
        if left[0] == -1:
            raise KeyboardInterrupt
        return step(tracker, frame)

    monkeypatch.setattr(Tracker, "step", interrupted)
    return lambda frames: left.__setitem__(0, frames)


def test_every_sequence_gets_a_result_file_labels_or_not(
    mot_sim: CommandLine, tree: Path, tmp_path: Path
) -> None:
    out = tmp_path / "a" / "b"
    outcome = mot_sim("track", "--root", tree, "--out", out)
    assert (outcome.code, outcome.err) == (0, "")
    assert outcome.out.startswith(f"{out}: 3 sequences, {3 * FRAMES} frames, ")
    assert "ego-motion" not in outcome.out
    assert files(out) == ALL_FILES
    tracks = read_results(out / "0032.txt", frame_count=FRAMES)
    assert len(tracks) == 2 * FRAMES
    assert set(tracks.ids.tolist()) == {0, 1}
    assert len((out / "0032.txt").read_text().split("\n")[0].split()) == 18


def test_the_run_file_says_how_the_results_were_made(
    mot_sim: CommandLine, tree: Path, tmp_path: Path
) -> None:
    arguments = ["--tracker", "paper", "--costs", "volume=0.6,reprojection=0.4"]
    arguments += ["--association", "greedy", "--ego", "none", "--height", "1.6", "--pitch", "-0.5"]
    outcome = mot_sim("track", "--root", tree, "--out", tmp_path / "out", *arguments, "--json")
    assert outcome.code == 0
    run = json.loads((tmp_path / "out" / "run.json").read_text())
    assert run["complete"] is True
    assert run["versions"]["numpy"] == np.__version__
    assert run["settings"] == {
        "tracker": "paper",
        "costs": "reprojection=0.4,volume=0.6",
        "association": "greedy",
        "cues": None,
        "root": str(tree),
        "split": "training",
        "detections": "rrc",
        "detection_format": None,
        "ego": "none",
        "height": 1.6,
        "pitch_deg": -0.5,
        "drop_bad_boxes": False,
        "score_map": None,
    }
    summary = json.loads(outcome.out)
    assert summary["sequences"] == run["sequences"]
    sums = {"frames", "detections", "rows", "ids", "seconds", "pairs", "compared", "unmeasured"}
    sums |= {"stages", "contradiction", "ego_scale"}
    assert run["sequences"]["0031"].keys() == sums
    assert 0.0 < summary["pairs_skipped"] < 1.0
    assert summary["frames"] == 3 * FRAMES
    assert summary["frames_per_second"] > 0.0


def test_only_the_named_sequences_are_tracked(
    mot_sim: CommandLine, tree: Path, tmp_path: Path
) -> None:
    for wanted, expected in {
        "0031": run_of("0031"),
        "0032, 0030,0032": run_of("0030", "0032"),
        "labelled": run_of("0030", "0031"),
        "given": run_of("0030", "0031"),
    }.items():
        out = tmp_path / wanted
        assert mot_sim("track", "--root", tree, "--out", out, "--sequences", wanted).code == 0
        assert files(out) == expected


def test_the_testing_split_has_folders_of_its_own(
    mot_sim: CommandLine, tree: Path, tmp_path: Path
) -> None:
    (tree / "training").rename(tree / "testing")
    for kind in ("rrc",):
        source = tree / "detections" / kind / "0030.txt"
        write(tree / "detections" / kind / "testing" / "0030.txt", source.read_text())
    arguments = ["--split", "testing", "--sequences", "0030"]
    outcome = mot_sim("track", "--root", tree, "--out", tmp_path / "out", *arguments)
    assert outcome.code == 0
    assert files(tmp_path / "out") == run_of("0030")


def test_bad_boxes_can_be_left_out_and_are_counted_aloud(
    mot_sim: CommandLine, tree: Path, tmp_path: Path
) -> None:
    path = tree / "detections/rrc/0030.txt"
    path.write_text(path.read_text() + "1,500,200,500,240,0.9\n")
    arguments = ["--root", tree, "--out", tmp_path / "out", "--drop-bad-boxes"]
    outcome = mot_sim("track", *arguments)
    assert outcome.code == 0
    assert outcome.err.startswith("warning: ")
    assert "1 boxes without area" in outcome.err
    assert outcome.err.count("\n") == 1


def test_boxes_of_ones_own_need_only_a_csv_and_a_camera(
    mot_sim: CommandLine, tmp_path: Path
) -> None:
    boxes = write(tmp_path / "drive.csv", boxes_csv())
    camera = write(tmp_path / "camera.toml", CAMERA)
    poses = write(tmp_path / "poses.txt", "1 0 0 0 0 1 0 0 0 0 1 0\n" * FRAMES)
    images = tmp_path / "images"
    images.mkdir()
    for frame in range(FRAMES):
        cv2.imwrite(str(images / f"{frame:06d}.png"), np.zeros((375, 1242), np.uint8))
    own = ["--boxes", boxes, "--camera", camera]
    for number, more in enumerate([[], ["--ego", "none"], ["--ego", poses, "--images", images]]):
        out = tmp_path / f"out{number}"
        outcome = mot_sim("track", *own, *more, "--out", out)
        assert (outcome.code, outcome.err) == (0, "")
        assert ("Without ego-motion" in outcome.out) == (number < 2)
        assert files(out) == run_of("drive")
        assert len(read_results(out / "drive.txt")) == 2 * FRAMES


def test_the_scale_of_the_odometry_is_said_and_kept(mot_sim: CommandLine, tmp_path: Path) -> None:
    boxes = write(tmp_path / "drive.csv", boxes_csv())
    camera = write(tmp_path / "camera.toml", CAMERA)
    poses = write(tmp_path / "poses.txt", "1 0 0 0 0 1 0 0 0 0 1 0\n" * FRAMES)
    own = ["--boxes", boxes, "--camera", camera, "--ego-scale"]
    outcome = mot_sim("track", *own, "auto", "--ego", poses, "--out", tmp_path / "out")
    assert outcome.code == 0
    assert "drive: no scale of the odometry found: the camera stands" in outcome.out
    run = json.loads((tmp_path / "out" / "run.json").read_text())
    assert run["settings"]["ego_scale"] == "auto"
    assert run["sequences"]["drive"]["ego_scale"] == {}
    outcome = mot_sim("track", *own, "metres", "--ego", poses, "--out", tmp_path / "other")
    assert (outcome.code, outcome.err.count("\n")) == (2, 1)
    assert "unknown scale of the ego-motion 'metres'; known: auto" in outcome.err


def test_ctrl_c_keeps_the_finished_sequences_and_resume_does_the_rest(
    mot_sim: CommandLine, tree: Path, tmp_path: Path, interrupt_after: Callable[[int], None]
) -> None:
    out, whole = tmp_path / "out", tmp_path / "whole"
    mot_sim("track", "--root", tree, "--out", whole)
    interrupt_after(FRAMES + 2)
    outcome = mot_sim("track", "--root", tree, "--out", out)
    assert outcome.code == 130
    assert outcome.err.count("\n") == 1
    assert "1 of 3 sequences are finished" in outcome.err
    assert "--resume" in outcome.err
    assert files(out) == run_of("0030")
    assert json.loads((out / "run.json").read_text())["complete"] is False

    (out / "0030.txt").chmod(0o444)
    stamp = (out / "0030.txt").stat().st_mtime_ns
    resumed = mot_sim("track", "--root", tree, "--out", out, "--resume", "--json")
    assert resumed.code == 0
    assert json.loads(resumed.out)["resumed"] == ["0030"]
    assert files(out) == ALL_FILES
    assert (out / "0030.txt").stat().st_mtime_ns == stamp
    for name in NAMES:
        assert (out / f"{name}.txt").read_text() == (whole / f"{name}.txt").read_text()
    assert json.loads((out / "run.json").read_text())["complete"] is True


def test_ctrl_c_before_the_first_sequence_is_finished_leaves_nothing(
    mot_sim: CommandLine, tree: Path, tmp_path: Path, interrupt_after: Callable[[int], None]
) -> None:
    interrupt_after(2)
    outcome = mot_sim("track", "--root", tree, "--out", tmp_path / "a" / "out")
    assert outcome.code == 130
    assert "nothing is left" in outcome.err
    assert not (tmp_path / "a").exists()


def test_resuming_a_finished_run_changes_nothing(
    mot_sim: CommandLine, tree: Path, tmp_path: Path
) -> None:
    mot_sim("track", "--root", tree, "--out", tmp_path / "out")
    outcome = mot_sim("track", "--root", tree, "--out", tmp_path / "out", "--resume")
    kept = f"3 sequences, 3 of them finished before, {3 * FRAMES} frames;"
    assert outcome.out.startswith(f"{tmp_path / 'out'}: {kept}")
    assert outcome.out.endswith("of the pairs\n")


def test_a_result_file_that_is_gone_is_made_again(
    mot_sim: CommandLine, tree: Path, tmp_path: Path
) -> None:
    mot_sim("track", "--root", tree, "--out", tmp_path / "out")
    (tmp_path / "out" / "0031.txt").unlink()
    outcome = mot_sim("track", "--root", tree, "--out", tmp_path / "out", "--resume", "--json")
    assert json.loads(outcome.out)["resumed"] == ["0030", "0032"]
    assert files(tmp_path / "out") == ALL_FILES


def test_resume_refuses_other_settings_and_names_them(
    mot_sim: CommandLine, tree: Path, tmp_path: Path
) -> None:
    out = tmp_path / "out"
    mot_sim("track", "--root", tree, "--out", out, "--sequences", "0030")
    more = ["--resume", "--ego", "none", "--pitch", "1"]
    outcome = mot_sim("track", "--root", tree, "--out", out, *more)
    assert outcome.code == 2
    assert "ego was 'oxts' and is 'none'; pitch_deg was 0.0 and is 1.0" in outcome.err
    assert files(out) == run_of("0030")


@pytest.mark.parametrize("text", ["{", "[]", '{"settings": {}, "sequences": {"../x": {}}}'])
def test_a_run_file_that_is_none_is_refused(
    mot_sim: CommandLine, tree: Path, tmp_path: Path, text: str
) -> None:
    write(tmp_path / "out" / "run.json", text)
    for more in ("--resume", "--overwrite"):
        outcome = mot_sim("track", "--root", tree, "--out", tmp_path / "out", more)
        assert outcome.code == 2
        assert outcome.err.count("\n") == 1


def test_an_existing_run_is_replaced_only_when_asked(
    mot_sim: CommandLine, tree: Path, tmp_path: Path
) -> None:
    out = tmp_path / "out"
    mot_sim("track", "--root", tree, "--out", out)
    before = (out / "run.json").read_text()
    outcome = mot_sim("track", "--root", tree, "--out", out, "--ego", "none")
    assert outcome.code == 2
    assert "--resume" in outcome.err
    assert "--overwrite" in outcome.err
    assert (out / "run.json").read_text() == before
    only = ["--sequences", "0031", "--ego", "none", "--overwrite"]
    assert mot_sim("track", "--root", tree, "--out", out, *only).code == 0
    assert files(out) == run_of("0031")


def test_an_error_half_way_leaves_finished_sequences_and_one_line(
    mot_sim: CommandLine, tree: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:

    replace = os.replace

    def full_disk(source: Path, target: Path) -> None:
        if target.name == "0031.txt":
            raise OSError(28, "No space left on device")
        replace(source, target)

    monkeypatch.setattr(os, "replace", full_disk)
    outcome = mot_sim("track", "--root", tree, "--out", tmp_path / "out")
    assert outcome.code == 2
    assert "No space left" in outcome.err
    assert files(tmp_path / "out") == run_of("0030")


@pytest.mark.slow
def test_ctrl_c_on_a_real_process_leaves_a_run_that_can_go_on(tree: Path, tmp_path: Path) -> None:
    out, long = tmp_path / "out", 600
    for name in NAMES:
        write(tree / "training/oxts" / f"{name}.txt", OXTS_ROW * long)
        rows = (f"{frame},500,200,560,240,0.9\n" for frame in range(long))
        write(tree / "detections/rrc" / f"{name}.txt", "".join(rows))
        (tree / "training/label_02" / f"{name}.txt").unlink(missing_ok=True)
    arguments = ["track", "--root", str(tree), "--out", str(out)]
    command = [sys.executable, "-m", "mot_sim", *arguments]
    with subprocess.Popen(command, stderr=subprocess.PIPE, text=True) as process:
        deadline = time.monotonic() + 120.0
        while not (out / "0030.txt").is_file() and time.monotonic() < deadline:
            time.sleep(0.01)
        process.send_signal(signal.SIGINT)
        _, errors = process.communicate(timeout=60)
    assert process.returncode == 130
    assert errors.startswith("interrupted: 1 of 3")
    assert errors.count("\n") == 1
    assert files(out) == run_of("0030")
    assert subprocess.run([*command, "--resume"], check=False, timeout=60).returncode == 0
    assert files(out) == ALL_FILES


@pytest.mark.kitti
@pytest.mark.slow
def test_all_sequences_are_tracked_and_those_with_labels_scored(
    mot_sim: CommandLine, kitti_root: Path, tmp_path: Path
) -> None:
    out = tmp_path / "out"
    some = ["0004", "0012", "0014", "0017"]  # short ones; two have labels
    asked = mot_sim("track", "--root", kitti_root, "--out", out, "--sequences", ",".join(some))
    assert asked.code == 0
    assert files(out) == run_of(*some)
    counts = json.loads((out / "run.json").read_text())["sequences"]
    assert sum(part["frames"] for part in counts.values()) == 314 + 78 + 106 + 145
    scored = json.loads(mot_sim("evaluate", out, "--root", kitti_root, "--json", "-").out)
    assert sorted(scored["sequences"]) == ["0004", "0017"]
    assert scored["combined"]["MOTA"] > 0.85
    assert scored["combined"]["HOTA"] > 0.75
    arguments = ["--sequences", "0004", "--ego", "oxts", "--detections", "rrc", "--json", "-"]
    at_once = json.loads(mot_sim("kitti", "--root", kitti_root, *arguments).out)
    assert at_once["default"]["sequences"]["0004"]["IDSW"] == scored["sequences"]["0004"]["IDSW"]


def test_frames_that_nothing_looked_at_have_rows_and_the_run_file_says_so(
    mot_sim: CommandLine, tree: Path, tmp_path: Path
) -> None:
    """KITTI and boxes of one's own alike: two cars in every frame, boxes in every other one."""
    boxes = write(tmp_path / "boxes.csv", boxes_csv())
    camera = write(tmp_path / "camera.toml", CAMERA)
    for given in (["--root", tree], ["--boxes", boxes, "--camera", camera]):
        out = tmp_path / f"out{len(given)}"
        outcome = mot_sim("track", *given, "--out", out, "--every", "2")
        assert outcome.code == 0
        assert "boxes are left out" in outcome.err
        assert json.loads((out / "run.json").read_text())["settings"]["every"] == 2
        name = "0032" if "--root" in given else "boxes"
        tracks = read_results(out / f"{name}.txt")
        counts = np.bincount(tracks.frames)
        assert counts[: FRAMES - 1].tolist() == [2] * (FRAMES - 1)
        assert set(tracks.ids.tolist()) == {0, 1}
    assert mot_sim("track", "--root", tree, "--out", tmp_path / "no", "--every", "0").code == 2
