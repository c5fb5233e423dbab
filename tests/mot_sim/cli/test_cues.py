"""`--cues`: what is measured in images on the way to the tracker."""

import json
from pathlib import Path

import cv2
import numpy as np
import pytest

from tests.mot_sim.cli.conftest import CAMERA, FRAMES, CommandLine, boxes, boxes_csv, files, write

TRACK = ("track", "--sequences", "0030", "--out")


def draw(folder: Path, frames: int = FRAMES) -> Path:
    """The two cars of the boxes as blocks of colour, a picture a frame."""
    folder.mkdir(parents=True)
    for frame in range(frames):
        image = np.full((375, 1242, 3), 110, np.uint8)
        for box, paint in zip(boxes(frame), ((30, 30, 190), (200, 80, 20)), strict=True):
            left, top, right, bottom = (int(side) for side in box)
            image[top : bottom + 1, left : right + 1] = paint
        cv2.imwrite(str(folder / f"{frame:06d}.png"), image)
    return folder


@pytest.fixture
def pictured(tree: Path) -> Path:
    """The tree, with images of 0030."""
    draw(tree / "training/image_02/0030")
    return tree


@pytest.mark.parametrize(
    ("cues", "stages"),
    [
        ("all", ["keypoints", "fit", "descriptor"]),
        ("classical", ["descriptor"]),
        ("pose", ["keypoints", "fit"]),
        ("none", []),
    ],
)
def test_cues_are_measured_in_the_images_of_kitti_and_every_stage_is_timed(
    mot_sim: CommandLine, pictured: Path, tmp_path: Path, cues: str, stages: list[str]
) -> None:
    out = tmp_path / "out"
    outcome = mot_sim(*TRACK, out, "--root", pictured, "--cues", cues)
    assert (outcome.code, outcome.err) == (0, "")
    told = outcome.out.partition("; ms a frame: ")[2]
    assert [part.split()[0] for part in told.split(", ") if part] == stages
    run = json.loads((out / "run.json").read_text())
    assert run["settings"]["cues"] == (None if cues == "none" else cues)
    assert list(run["sequences"]["0030"]["stages"]) == stages
    assert len((out / "0030.txt").read_text().splitlines()) == 2 * FRAMES


def test_the_summary_and_the_table_tell_the_times_too(
    mot_sim: CommandLine, pictured: Path, tmp_path: Path
) -> None:
    more = ("--root", pictured, "--cues", "classical")
    summary = json.loads(mot_sim(*TRACK, tmp_path / "out", *more, "--json").out)
    assert summary["stages_ms"]["descriptor"] > 0.0
    outcome = mot_sim("kitti", "--sequences", "0030", *more)
    assert outcome.code == 0
    assert outcome.err.startswith("default; ms a frame: descriptor ")


def test_boxes_of_ones_own_get_cues_from_their_images(mot_sim: CommandLine, tmp_path: Path) -> None:
    own = ["--boxes", write(tmp_path / "drive.csv", boxes_csv())]
    own += ["--camera", write(tmp_path / "camera.toml", CAMERA), "--cues", "pose,classical"]
    refused = mot_sim("track", *own, "--out", tmp_path / "out")
    assert refused.code == 2
    assert "--cues pose,classical needs images: give --images DIR too" in refused.err
    own += ["--images", draw(tmp_path / "images")]
    outcome = mot_sim("track", *own, "--out", tmp_path / "out")
    assert (outcome.code, outcome.err) == (0, "")
    assert files(tmp_path / "out") == ["drive.estimates.csv", "drive.txt", "run.json"]
    assert "; ms a frame: keypoints " in outcome.out


def test_frames_without_an_image_are_tracked_without_their_cue(
    mot_sim: CommandLine, tree: Path, tmp_path: Path
) -> None:
    draw(tree / "training/image_02/0030", FRAMES - 1)
    outcome = mot_sim(*TRACK, tmp_path / "out", "--root", tree, "--cues", "classical")
    assert outcome.code == 0
    assert f"images for {FRAMES - 1} of {FRAMES} frames only" in outcome.err
    assert "costs had no cue" in outcome.out


@pytest.mark.parametrize(
    ("more", "told"),
    [
        (["--cues", "apearance"], "unknown cue 'apearance'; known: all, appearance, classical"),
        (["--cues", "all,classical"], "appearance and classical fill one column"),
        (["--sequences", "0031", "--cues", "all"], "0031: no such folder; give images named"),
        (["--costs", "appearance"], "--cues appearance or --cues classical"),
        (["--costs", "apearance"], "Did you mean 'appearance'?"),
    ],
)
def test_what_is_wrong_is_one_line_and_nothing_is_left_behind(
    mot_sim: CommandLine, pictured: Path, tmp_path: Path, more: list[str], told: str
) -> None:
    outcome = mot_sim(*TRACK, tmp_path / "out", "--root", pictured, *more)
    assert outcome.code == 2
    assert outcome.err.count("\n") == 1
    assert told in outcome.err
    assert not (tmp_path / "out").exists()


def test_a_missing_model_is_one_line_before_anything_is_done(
    mot_sim: CommandLine, pictured: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    gone = tmp_path / "gone.npz"
    monkeypatch.setattr("tracker.descriptors.learned.SHIPPED_WEIGHTS", gone)
    outcome = mot_sim(*TRACK, tmp_path / "out", "--root", pictured, "--cues", "appearance")
    assert outcome.code == 2
    assert outcome.err.startswith(f"error: {gone}: no weights of the appearance descriptor")
    assert outcome.err.count("\n") == 1
    assert not (tmp_path / "out").exists()


def test_a_run_goes_on_only_with_the_same_cues(
    mot_sim: CommandLine, pictured: Path, tmp_path: Path
) -> None:
    out = tmp_path / "out"
    assert mot_sim(*TRACK, out, "--root", pictured, "--cues", "classical").code == 0
    outcome = mot_sim(*TRACK, out, "--root", pictured, "--resume")
    assert outcome.code == 2
    assert "cues was 'classical' and is None" in outcome.err


def test_weights_are_learned_from_the_command_line_and_not_over_a_file_that_is_there(
    mot_sim: CommandLine, tmp_path: Path
) -> None:
    path = write(tmp_path / "w.npz", "precious")
    outcome = mot_sim("train-appearance", "--out", path)
    assert outcome.code == 2
    assert "--overwrite replaces it" in outcome.err
    assert path.read_text() == "precious"
    outcome = mot_sim("train-appearance", "--out", tmp_path / "new.npz", "--drives", "0")
    assert (outcome.code, outcome.err) == (2, "error: --drives 0: give 1 or more\n")
    outcome = mot_sim("train-appearance", "--out", path, "--overwrite", "--hourglass", path)
    assert outcome.code == 2
    assert path.read_text() == "precious"
