"""Lenses: boxes to a pinhole and back, and lenses that no pinhole stands in for."""

from pathlib import Path

import cv2
import numpy as np
import pytest

from mot_sim.datasets.boxes import box_sequence
from mot_sim.datasets.camera_files import read_camera
from mot_sim.datasets.distortion import Distortion
from mot_sim.evaluation.runs import track_sequences
from tests.mot_sim.datasets.conftest import write
from tests.mot_sim.datasets.test_boxes import CAMERA
from tests.mot_sim.datasets.test_images import paint
from tracker import Tracker
from tracker.errors import BadCalibration, BadConfig
from tracker.types import Camera

K = np.array([[700.0, 0.0, 640.0], [0.0, 700.0, 360.0], [0.0, 0.0, 1.0]])
REAL = Camera.mounted(K, (1280, 720), 1.4)
LENSES = (
    [-0.3, 0.1, 0.0, 0.0, 0.0], [-0.25, 0.08, 0.001, -0.0005, -0.01], [0.1, 0.02, 0.0, 0.0],
    [-0.3, 0.1, 0.0, 0.0, 0.02, 0.01, 0.0, 0.0],
)  # fmt: skip


@pytest.mark.parametrize("coefficients", LENSES)
def test_boxes_come_back(coefficients: list[float]) -> None:
    lens = Distortion(REAL, np.array(coefficients))
    rng = np.random.default_rng(0)
    corner = rng.uniform([0, 0], [1180, 620], (200, 2))
    boxes = np.hstack([corner, corner + rng.uniform(10, 99, (200, 2))])
    straight = lens.undistort_boxes(boxes)
    np.testing.assert_allclose(lens.distort_boxes(straight), boxes, atol=0.05)
    width, height = lens.pinhole.image_size
    assert (straight.min(axis=0) >= -0.5).all()
    assert (straight.max(axis=0) <= np.array([width, height] * 2) - 0.5).all()


@pytest.mark.parametrize("coefficients", LENSES)
def test_the_pinhole_sees_what_opencv_projects(coefficients: list[float]) -> None:
    """A small object in space: its distorted box, straightened, is where the pinhole has it."""
    lens = Distortion(REAL, np.array(coefficients))
    place = np.array([[-3.0, 1.0, 9.0], [2.0, -1.0, 8.0], [0.2, 0.1, 20.0]])
    for point in place:
        cloud = point + np.array([[0, -0.1, 0], [0, 0.1, 0], [0.1, 0, 0], [-0.1, 0, 0]])
        seen, _ = cv2.projectPoints(cloud, np.zeros(3), np.zeros(3), K, lens.coefficients)
        seen = seen.reshape(-1, 2)
        box = np.array([[*seen.min(axis=0), *seen.max(axis=0)]])
        pixels = lens.pinhole.project(cloud)
        expected = [*pixels.min(axis=0), *pixels.max(axis=0)]
        np.testing.assert_allclose(lens.undistort_boxes(box)[0], expected, atol=0.3)


@pytest.mark.parametrize(
    ("coefficients", "message"),
    [
        ([-0.9, 0.1, 0.0, 0.0, 0.0], "folds the 1280x720 image over"),
        ([-0.5, 0.0, 0.0, 0.0], "folds the 1280x720 image over"),
        ([5.0, -90.0, 0.0, 0.0], "folds the 1280x720 image over"),
    ],
)
def test_lenses_that_no_pinhole_stands_in_for_are_refused(coefficients, message: str) -> None:
    with pytest.raises(BadCalibration, match=message):
        Distortion(REAL, np.array(coefficients))


def test_a_camera_file_states_the_lens_and_results_go_back(tmp_path: Path) -> None:
    """What is tracked in the pinhole's image is written in the camera's own."""
    path = write(tmp_path / "camera.toml", CAMERA + "distortion = [-0.3, 0.1, 0.0, 0.0, 0.0]\n")
    lens = read_camera(path).distortion
    assert lens is not None
    rows = [f"{frame},{10 + frame},5,{40 + frame},30,0.95\n" for frame in range(6)]
    write(tmp_path / "boxes.csv", "frame,x_min,y_min,x_max,y_max,score\n" + "".join(rows))
    drive = box_sequence(tmp_path / "boxes.csv", path)
    assert drive.camera.image_size == lens.pinhole.image_size
    run = track_sequences([drive], Tracker.default)
    tracks = run.tracks["boxes"]
    assert len(tracks) == 6
    expected = [[10 + frame, 5, 40 + frame, 30] for frame in range(6)]
    np.testing.assert_allclose(tracks.boxes, expected, atol=1.0)
    for frame in range(6):
        paint(tmp_path / "images" / f"{frame:06d}.png", (9, 9, 9), (100, 40))
    with pytest.raises(BadConfig, match="undistort them and the boxes"):
        box_sequence(tmp_path / "boxes.csv", path, tmp_path / "images")


@pytest.mark.parametrize("value", ["0.1", "[0.1, 0.2]", "[0.1, 0.2, 0, 0, 'k3']", "[nan, 0, 0, 0]"])
def test_what_is_no_lens_is_named(tmp_path: Path, value: str) -> None:
    with pytest.raises(BadConfig, match=r"camera\.toml: distortion"):
        read_camera(write(tmp_path / "camera.toml", CAMERA + f"distortion = {value}\n"))
    unbent = CAMERA + "distortion = [0, 0, 0, 0, 0]\n"
    assert read_camera(write(tmp_path / "camera.toml", unbent)).distortion is None
