"""`mot-sim calibrate-camera`: the door to the estimate."""

import re
from pathlib import Path

import numpy as np
import pytest

from mot_sim.__main__ import main
from mot_sim.datasets import read_camera
from tests.mot_sim.datasets.conftest import write
from tests.mot_sim.datasets.test_camera_estimate import SIZE, K, cars_seen
from tracker.types import Camera

LENS = "fx = 700\nfy = 700\ncx = 640\ncy = 360\nimage_width = 1280\nimage_height = 720\n"


def test_the_file_that_it_writes_is_a_camera_file(tmp_path: Path) -> None:
    log = cars_seen(Camera.mounted(K, SIZE, 1.3), 20, (30.0, 10.0), trucks=1)
    rows = np.column_stack([log.frames, log.detections.boxes])
    lines = [",".join(f"{value:.6g}" for value in row) for row in rows.tolist()]
    boxes = write(tmp_path / "b.csv", "\n".join(["frame,x_min,y_min,x_max,y_max", *lines]))
    given = write(tmp_path / "lens.toml", LENS + "frame_rate = 12\n")
    out = tmp_path / "camera.toml"
    options = ["--boxes", str(boxes), "--camera", str(given), "--out", str(out)]
    assert main(["calibrate-camera", *options]) == 0
    described = read_camera(out)
    assert described.camera.height == pytest.approx(1.3, abs=0.08)
    assert described.camera.K.tolist() == K.tolist()
    assert described.frame_rate == 12.0
    assert out.read_text().startswith("# by 80 boxes of ")


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ([], "give --camera FILE, or --focal PIXELS with --image-size WxH"),
        (["--focal", "700", "--image-size", "1280"], "--image-size 1280: write WxH"),
        (
            ["--focal", "700", "--image-size", "1280x720"],
            "1 car of which .* 12 are needed",
        ),
    ],
)
def test_what_is_missing_is_one_line(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], options: list[str], message: str
) -> None:
    boxes = write(tmp_path / "b.csv", "frame,x_min,y_min,x_max,y_max\n0,500,380,580,440\n")
    assert main(["calibrate-camera", "--boxes", str(boxes), *options]) == 2
    errors = capsys.readouterr().err
    assert errors.count("\n") == 1
    assert re.search(message, errors)
