"""`mot-sim show`."""

import sys
from pathlib import Path

import cv2
import numpy as np
import pytest

from mot_sim.plotting.video import count_frames
from mot_sim.report import film as film_module
from mot_sim.simulation import registry
from tests.mot_sim.cli.conftest import FRAMES as KITTI_FRAMES
from tests.mot_sim.cli.conftest import CommandLine
from tests.mot_sim.report.small import FRAMES


@pytest.fixture(autouse=True)
def near_scene(monkeypatch: pytest.MonkeyPatch) -> None:
    """A scene that is quick to draw, by name."""
    monkeypatch.setitem(registry.SCENES, "near", "tests.mot_sim.report.small:near")


@pytest.fixture
def out(tmp_path: Path) -> Path:
    return tmp_path / "out"


def test_a_scene_is_run_tracked_and_drawn_on_the_way(mot_sim: CommandLine, out: Path) -> None:
    path = out / "film.mp4"
    layers = ["--search-areas", "--true-wireframes"]
    outcome = mot_sim("show", "near", "--out", path, *layers)
    assert (outcome.code, outcome.err) == (0, "")
    assert outcome.out == f"{path}: {FRAMES} frames\n"
    assert count_frames(path) == FRAMES
    assert [each.name for each in out.iterdir()] == ["film.mp4"]


def test_a_recorded_episode_with_the_tracks_of_a_run(
    mot_sim: CommandLine, out: Path, tmp_path: Path
) -> None:
    tree, run = tmp_path / "tree", tmp_path / "run"
    assert mot_sim("record", "near", "--out", tree).code == 0
    assert mot_sim("track", "--root", tree, "--detections", "simulated", "--out", run).code == 0
    given = mot_sim("show", tree, "--tracks", run, "--out", out / "given")
    tracked = mot_sim("show", tree, "--out", out / "tracked")
    assert (given.code, tracked.code, given.err) == (0, 0, "")
    names = sorted(each.name for each in (out / "given").iterdir())
    assert names == [f"{number:06d}.png" for number in range(FRAMES)]
    for name in names:  # but for the title, which names the run
        one, two = (cv2.imread(str(out / place / name)) for place in ("given", "tracked"))
        assert (one[32:] != two[32:]).any(axis=2).mean() < 0.01  # files round to six decimals


def test_a_kitti_tree_without_images_is_drawn_on_plain_ground(
    mot_sim: CommandLine, out: Path, tree: Path
) -> None:
    outcome = mot_sim(
        "show", tree, "--sequence", "0030", "--out", out / "a.gif", "--scale", "0.25", "--frames",
        "1:",
    )  # fmt: skip
    assert (outcome.code, outcome.err) == (0, "")
    assert count_frames(out / "a.gif") == KITTI_FRAMES - 1
    capture = cv2.VideoCapture(str(out / "a.gif"))
    assert capture.read()[1].shape == (203, 310, 3)
    unlabelled = mot_sim("show", tree, "--sequence", "0032", "--out", out / "b.mp4")
    assert unlabelled.code == 0


def test_frames_outside_the_span_are_left_out(mot_sim: CommandLine, out: Path) -> None:
    assert mot_sim("show", "near", "--out", out, "--frames", "2:4", "--no-top-view").code == 0
    assert sorted(each.name for each in out.iterdir()) == ["000002.png", "000003.png"]


def test_an_older_film_stays_unless_it_may_be_overwritten(mot_sim: CommandLine, out: Path) -> None:
    command = ["show", "near", "--out", out / "film.mp4", "--frames", ":2"]
    assert mot_sim(*command).code == 0
    before = (out / "film.mp4").read_bytes()
    outcome = mot_sim(*command)
    assert outcome.code == 2
    assert "--overwrite" in outcome.err
    assert (out / "film.mp4").read_bytes() == before
    assert mot_sim(*command, "--no-truth", "--overwrite").code == 0
    assert (out / "film.mp4").read_bytes() != before


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        (["near"], "give --out FILE.mp4, FILE.gif or a folder, or --rerun FILE.rrd"),
        (["near", "--out", "OUT/a.avi"], "OUT/a.avi: no film ends in '.avi'"),
        (["neer", "--out", "OUT"], "unknown folder or scene 'neer'"),
        (["near", "--out", "OUT", "--frames", "3"], "--frames 3: write A:B"),
        (["near", "--out", "OUT", "--frames", "3:3"], "--frames 3:3: no frame lies in it"),
        (["near", "--out", "OUT", "--frames", "99:"], "--frames 99:...: 'near' has the frames"),
        (["near", "--out", "OUT", "--scale", "9"], "--scale 9: give a factor from 0.1 to 4"),
        (["near", "--out", "OUT", "--knobs", "sped=1"], "unknown knob of scene near"),
        (["near", "--out", "OUT", "--tracks", "OUT/x"], "OUT/x: no such file"),
        (["near", "--out", "OUT", "--tracker", "sort"], "unknown tracker 'sort'"),
        (["near", "--out", "/proc/x/a.mp4"], "/proc/x/a.mp4: cannot be written"),
        (["TREE", "--out", "OUT"], "TREE holds 0030, 0031, 0032: choose with --sequence"),
        (["TREE", "--out", "OUT", "--knobs", "a=1"], "--knobs a=1: 'TREE' is no scene"),
        (["TREE", "--sequence", "0030", "--out", "OUT", "--wireframes"], "--wireframes needs im"),
        (["TREE", "--sequence", "0030", "--out", "OUT", "--cues", "pose"], "--cues pose needs im"),
        (["TREE", "--sequence", "0030", "--out", "OUT", "--true-wireframes"],
         "--true-wireframes: '0030' is a real drive"),
        (["TREE", "--sequence", "0030", "--out", "OUT", "--detections", "rcc"],
         "unknown detector 'rcc'"),
    ],
)  # fmt: skip
def test_wrong_input_is_one_line_and_leaves_nothing(
    mot_sim: CommandLine, out: Path, tree: Path, arguments: list[str], told: str
) -> None:
    named = [each.replace("OUT", str(out)).replace("TREE", str(tree)) for each in arguments]
    outcome = mot_sim("show", *named)
    assert (outcome.code, outcome.out) == (2, "")
    expected = told.replace("OUT", str(out)).replace("TREE", str(tree))
    assert outcome.err.startswith(f"error: {expected}")
    assert outcome.err.count("\n") == 1
    assert not out.exists()


def test_missing_packages_are_told_before_any_work(
    mot_sim: CommandLine, out: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "imageio_ffmpeg", None)
    monkeypatch.setitem(sys.modules, "rerun", None)
    outcome = mot_sim("show", "near", "--out", out / "film.mp4")
    assert outcome.code == 2
    assert "pip install imageio-ffmpeg" in outcome.err
    outcome = mot_sim("show", "near", "--rerun", out / "film.rrd")
    assert outcome.code == 2
    assert "pip install 'mot-sim[view]'" in outcome.err


@pytest.mark.parametrize(("finished", "left"), [(3, ["film.mp4"]), (0, [])])
def test_ctrl_c_keeps_the_frames_so_far(
    mot_sim: CommandLine, out: Path, monkeypatch: pytest.MonkeyPatch, finished: int, left: list
) -> None:
    draw, drawn = film_module.Film._view, [0]

    def interrupted(*arguments: object) -> np.ndarray:
        if drawn[0] == finished:
            raise KeyboardInterrupt
        drawn[0] += 1
        return draw(*arguments)

    monkeypatch.setattr(film_module.Film, "_view", interrupted)
    outcome = mot_sim("show", "near", "--out", out / "film.mp4")
    assert outcome.code == 130
    stands = f"{out / 'film.mp4'} stands with 3 frames" if finished else "no frame was finished"
    assert stands in outcome.err
    assert sorted(each.name for each in out.iterdir()) == left
    if finished:
        assert count_frames(out / "film.mp4") == finished


@pytest.mark.kitti
def test_real_frames_with_fitted_wireframes(
    mot_sim: CommandLine, out: Path, kitti_root: Path
) -> None:
    command = ["show", kitti_root, "--sequence", "0005", "--frames", "10:11", "--no-truth"]
    assert mot_sim(*command, "--out", out / "wired", "--wireframes").code == 0
    assert mot_sim(*command, "--out", out / "plain").code == 0
    wired, plain = (cv2.imread(str(out / name / "000010.png")) for name in ("wired", "plain"))
    assert wired.shape == plain.shape == (720, 1242, 3)
    changed = (wired != plain).any(axis=2)[32 : 32 + 375]
    assert changed[160:260, 20:160].any()  # the car on the left
    assert not changed[:150].any()
