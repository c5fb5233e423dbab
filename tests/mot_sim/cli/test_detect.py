"""`mot-sim detect`: from images to boxes that the other commands track."""

import json
from collections.abc import Callable
from pathlib import Path

import cv2
import numpy as np
import pytest

from mot_sim.datasets import ImageFolder, tracks_of_boxes
from mot_sim.evaluation.detectors import OnnxDetector
from tests.mot_sim.cli.conftest import CAMERA, CommandLine, write
from tests.mot_sim.evaluation.detectors.networks_made_here import image_with, write_network
from tracker import Detections


@pytest.fixture
def model(tmp_path: Path) -> Path:
    return write_network(tmp_path / "net.onnx", "v8", {0: "car"})


@pytest.fixture
def images(tmp_path: Path) -> Path:
    """Two drives of three frames: a square that moves, and nothing."""
    home = tmp_path / "tree" / "training" / "image_02"
    for name, squares in (("0000", [[(2, 3)], [(3, 3)], []]), ("0001", [[], [], []])):
        (home / name).mkdir(parents=True)
        for frame, each in enumerate(squares):
            cv2.imwrite(str(home / name / f"{frame:06d}.png"), image_with(each)[:, :, ::-1])
    return tmp_path / "tree"


def test_boxes_are_written_drive_by_drive_and_read_by_the_tracker(
    mot_sim: CommandLine, images: Path, model: Path, tmp_path: Path
) -> None:
    out = tmp_path / "boxes"
    outcome = mot_sim("detect", images, "--model", model, "--out", out)
    assert outcome.code == 0
    assert outcome.out == f"{out}: 2 drives, 6 frames, 2 boxes (head yolo, 160x96, letterbox)\n"
    assert "0001: no box" in outcome.err
    rows = tracks_of_boxes(out / "0000.txt")
    assert rows.frames.tolist() == [0, 1]
    np.testing.assert_allclose(rows.boxes, [[32, 48, 48, 64], [48, 48, 64, 64]], atol=1e-3)
    camera = write(tmp_path / "camera.toml", CAMERA)
    track = ("track", "--boxes", out / "0000.txt", "--camera", camera, "--out", tmp_path / "tracks")
    assert mot_sim(*track).code == 0
    alone = mot_sim("detect", images / "training/image_02/0000", "--model", model, "--json",
                    "--out", tmp_path / "alone")  # fmt: skip
    assert json.loads(alone.out)["drives"] == {"0000": 2}


def test_an_interrupted_run_goes_on(
    mot_sim: CommandLine, images: Path, model: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    seen: list[int] = []
    look: Callable[..., Detections] = OnnxDetector.__call__

    def interrupted(detector: OnnxDetector, image: np.ndarray) -> Detections:
        seen.append(len(seen))
        if len(seen) == 5:
            raise KeyboardInterrupt
        return look(detector, image)

    monkeypatch.setattr(OnnxDetector, "__call__", interrupted)
    out = tmp_path / "boxes"
    command = ("detect", images, "--model", model, "--out", out)
    outcome = mot_sim(*command)
    assert outcome.code == 130
    assert "1 of 2 drives are finished" in outcome.err
    assert "--resume" in mot_sim(*command).err  # it stands there
    other = mot_sim(*command, "--resume", "--min-score", ".5")
    assert (other.code, "min_score" in other.err) == (2, True)
    assert mot_sim(*command, "--resume").code == 0
    assert len(seen) == 5 + 3
    assert json.loads((out / "detect.json").read_text())["complete"]


def test_what_cannot_be_is_named_and_nothing_is_left(
    mot_sim: CommandLine, images: Path, model: Path, tmp_path: Path
) -> None:
    out, words = tmp_path / "boxes", {}
    words["no drive of that name"] = ("--drives", "0009"), "unknown drive '0009'; known: 0000, 0001"
    words["a size that is none"] = ("--size", "640"), "--size 640: write width x height"
    words["an empty name"] = ("--names", "car,,van"), "a class without a name"
    words["no such class"] = ("--classes", "lorry"), "unknown class"
    for arguments, said in words.values():
        outcome = mot_sim("detect", images, "--model", model, "--out", out, *arguments)
        assert (outcome.code, out.exists()) == (2, False)
        assert said in outcome.err
    empty = tmp_path / "empty"
    empty.mkdir()
    for folder, said in ((empty, "no numbered images"), (tmp_path / "none", "no such folder")):
        outcome = mot_sim("detect", folder, "--model", model, "--out", out)
        assert (outcome.code, said in outcome.err) == (2, True), outcome.err
    broken = ImageFolder.require(images / "training/image_02/0000").paths[1]
    broken.write_bytes(b"no image")
    outcome = mot_sim("detect", images, "--model", model, "--out", out)
    assert (outcome.code, str(broken) in outcome.err, out.exists()) == (2, True, False)
