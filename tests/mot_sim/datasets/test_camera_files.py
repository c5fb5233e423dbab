"""camera.toml: what it may hold, and what is said when it does not."""

import re
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from mot_sim.datasets.camera_files import camera_lines, read_camera, read_poses, write_poses
from tests.mot_sim.datasets.conftest import write
from tracker.errors import BadCalibration, BadConfig, BadFile, DatasetNotFound

PLACE = "image_width = 100\nimage_height = 40\ncamera_height = 1.65\n"
GOOD = "fx = 90.0\nfy = 80\ncx = 50\ncy = 20\n" + PLACE


def test_focal_lengths_and_centre_make_the_camera(tmp_path: Path) -> None:
    described = read_camera(write(tmp_path / "camera.toml", GOOD))
    assert described.camera.K.tolist() == [[90, 0, 50], [0, 80, 20], [0, 0, 1]]
    assert described.camera.image_size == (100, 40)
    assert described.camera.height == pytest.approx(1.65)
    assert described.camera.road_normal.tolist() == [0, 1, 0]
    assert described.frame_rate == 10.0


def test_k_pitch_roll_and_frame_rate_are_read(tmp_path: Path) -> None:
    text = "K = [[90, 1, 50], [0, 80, 20], [0, 0, 1]]\npitch_deg = 90\nframe_rate = 25\n" + PLACE
    described = read_camera(write(tmp_path / "camera.toml", text))
    assert described.camera.K[0, 1] == 1.0
    np.testing.assert_allclose(described.camera.road_normal, [0, 0, -1], atol=1e-12)
    assert described.frame_rate == 25.0


def test_a_camera_is_written_as_it_is_read(tmp_path: Path) -> None:
    lens = "pitch_deg = -30\nroll_deg = 2\nframe_rate = 25\ndistortion = [0.01, 0, 0.001, 0]\n"
    described = read_camera(write(tmp_path / "camera.toml", GOOD + lens))
    again = read_camera(write(tmp_path / "again.toml", "\n".join(camera_lines(described))))
    np.testing.assert_allclose(again.camera.T_cam_road, described.camera.T_cam_road, atol=1e-12)
    assert again.camera.K.tolist() == described.camera.K.tolist()
    assert (again.camera.image_size, again.frame_rate) == ((100, 40), 25.0)
    assert again.distortion is not None
    assert again.distortion.coefficients.tolist() == [0.01, 0.0, 0.001, 0.0]


def test_a_height_that_is_not_stated_may_be_given(tmp_path: Path) -> None:
    path = write(tmp_path / "camera.toml", GOOD.replace("camera_height = 1.65", ""))
    assert read_camera(path, 2.0).camera.height == pytest.approx(2.0)


@pytest.mark.parametrize(
    ("text", "error", "message"),
    [
        (
            GOOD + "pitch = 1\n",
            BadConfig,
            "unknown key 'pitch'; known: .* Did you mean 'pitch_deg'",
        ),
        (GOOD.replace("fx", "f_x"), BadConfig, "unknown key 'f_x'.* Did you mean 'fx'"),
        (PLACE, BadConfig, "no fx; a camera file holds K ="),
        (GOOD.replace("camera_height = 1.65", ""), BadConfig, "no camera_height; "),
        (GOOD + "K = [[1, 0, 0], [0, 1, 0], [0, 0, 1]]\n", BadConfig, "K and fx both say"),
        ("K = [[1, 0, 0], [0, 1]]\n" + PLACE, BadConfig, "give three rows of three numbers"),
        ("K = 3\n" + PLACE, BadConfig, "K is 3; give three rows"),
        ("K = [[1, 0, 0], [0, 'a', 0], [0, 0, 1]]\n" + PLACE, BadConfig, r"K\[1\]\[1\] is 'a'"),
        (GOOD.replace("90.0", "true"), BadConfig, "fx is True; give a finite number"),
        (GOOD.replace("90.0", "nan"), BadConfig, "fx is nan; give a finite number"),
        (GOOD.replace("90.0", "1" + "0" * 400), BadFile, "10+... is no number of 64 bits"),
        (GOOD.replace("= 100", "= 100.5"), BadConfig, "are whole pixels"),
        (GOOD + "frame_rate = 0\n", BadConfig, "frame_rate is 0; give frames a second"),
        (GOOD.replace("90.0", "0"), BadCalibration, "K is singular"),
        (GOOD.replace("1.65", "-1"), BadCalibration, "camera height -1 m"),
        (GOOD.replace("= 40", "= 0"), BadCalibration, "give width and height in pixels"),
        ("fx = \n", BadFile, r"not TOML: .*line 1"),
    ],
)
def test_bad_camera_files_are_refused(
    tmp_path: Path, text: str, error: type[Exception], message: str
) -> None:
    path = write(tmp_path / "camera.toml", text)
    with pytest.raises(error, match=re.escape(str(path)) + ".*" + message) as caught:
        read_camera(path)
    assert "\n" not in str(caught.value)


def test_a_missing_camera_file_is_named(tmp_path: Path) -> None:
    with pytest.raises(DatasetNotFound, match=r"camera.toml: no camera file; write one with K ="):
        read_camera(tmp_path / "camera.toml")


LEVEL = "1 0 0 5 0 1 0 6 0 0 1 7\n"


def test_a_line_is_a_matrix_row_by_row(tmp_path: Path) -> None:
    poses = read_poses(write(tmp_path / "p.txt", "0 0 1 5 0 1 0 6 -1 0 0 7\n"), 1)
    expected = [[0, 0, 1, 5], [0, 1, 0, 6], [-1, 0, 0, 7], [0, 0, 0, 1]]
    np.testing.assert_allclose(poses, [expected], atol=1e-12)


def test_an_empty_file_holds_no_pose(tmp_path: Path) -> None:
    assert read_poses(write(tmp_path / "p.txt", "")).shape == (0, 4, 4)


@given(st.lists(st.tuples(*[st.floats(-3, 3)] * 6), max_size=4))
def test_written_poses_are_read_back(
    tmp_path_factory: pytest.TempPathFactory, twists: list[tuple[float, ...]]
) -> None:
    path = tmp_path_factory.mktemp("poses") / "p.txt"
    poses = np.tile(np.eye(4), (len(twists), 1, 1))
    for pose, twist in zip(poses, twists, strict=True):
        pose[:3, :3] = Rotation.from_rotvec(twist[:3]).as_matrix()
        pose[:3, 3] = twist[3:]
    write_poses(poses, path)
    np.testing.assert_allclose(read_poses(path, len(twists)), poses, atol=2e-9)


def test_printed_rotations_become_orthonormal(tmp_path: Path) -> None:
    R = Rotation.from_rotvec([0.1, 0.2, 0.3]).as_matrix().round(4)
    row = " ".join(f"{value:.4f}" for value in np.column_stack([R, [0, 0, 0]]).flat)
    pose = read_poses(write(tmp_path / "p.txt", row))[0]
    np.testing.assert_allclose(pose[:3, :3] @ pose[:3, :3].T, np.eye(3), atol=1e-12)
    np.testing.assert_allclose(pose[:3, :3], R, atol=1e-4)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (LEVEL, r"p.txt: 1 poses for 2 frames"),
        (LEVEL + "2 0 0 0 0 1 0 0 0 0 1 0\n", r"p.txt:2: its rotation is not orthonormal"),
        (LEVEL + "1 0 0 0 0 1 0 0 0 0 -1 0\n", r"p.txt:2: its determinant is -1: mirrored"),
        (LEVEL + "1 0 0 nan 0 1 0 0 0 0 1 0\n", r"p.txt:2: tx is not finite"),
        ("\n" + LEVEL, r"p.txt:1: a blank line where frame 0 belongs, 1 of 2 lines"),
        (LEVEL + "\n" + LEVEL, r"p.txt:2: a blank line where frame 1 belongs, 2 of 3 lines"),
        ("0.1 0 0 0 0 0 0 1\n", r"p.txt:1: 8 values: .*TUM.* r11 r12 r13 tx r21 r22 r23 ty r31"),
        (LEVEL[:-1] + " 0 0 0 1\n", r"p.txt:1: 16 values: 4x4 matrices\? Leave out their last"),
        (LEVEL + "1 0 0 0 0 1 0 0 0 0 1\n", r"p.txt:2: 11 values where 12 belong"),
    ],
)
def test_bad_poses_are_refused(tmp_path: Path, text: str, message: str) -> None:
    with pytest.raises(BadFile, match=message):
        read_poses(write(tmp_path / "p.txt", text), 2)


def test_blank_lines_at_the_end_of_poses_are_no_frames(tmp_path: Path) -> None:
    assert len(read_poses(write(tmp_path / "p.txt", LEVEL * 2 + "\n \n"), 2)) == 2


def test_a_leap_between_two_poses_is_refused_with_its_line(tmp_path: Path) -> None:
    drives = "".join(f"1 0 0 0 0 1 0 0 0 0 1 {z}\n" for z in (0.0, 2.0, 4.0, 304.0, 306.0))
    path = write(tmp_path / "p.txt", drives)
    assert len(read_poses(path)) == 5
    with pytest.raises(BadFile, match=r"p.txt:4: a leap of 300 m .* 0\.1 s earlier: .*tz 304"):
        read_poses(path, step=0.1)
    assert len(read_poses(path, step=2.0)) == 5
