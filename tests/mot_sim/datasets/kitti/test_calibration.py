"""Calibration files in both dialects."""

import re
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from mot_sim.datasets.kitti.calibration import Calibration, read_calibration, write_calibration
from tests.mot_sim.datasets.conftest import CALIBRATION, write
from tracker.errors import BadCalibration, BadFile, DatasetNotFound
from tracker.geometry import homogeneous, transform

LATER_DIALECT = (
    CALIBRATION.replace("R_rect", "R0_rect:")
    .replace("Tr_velo_cam", "Tr_velo_to_cam:")
    .replace("Tr_imu_velo", "Tr_imu_to_velo:")
)


@pytest.mark.parametrize("text", [CALIBRATION, LATER_DIALECT])
def test_both_dialects_say_the_same(tmp_path: Path, text: str) -> None:
    calibration = read_calibration(write(tmp_path / "0000.txt", text))
    assert calibration.K.tolist() == [[100, 0, 50], [0, 100, 20], [0, 0, 1]]
    assert calibration.T_cam_imu is not None
    ahead_of_the_car = transform(calibration.T_cam_imu, np.array([[10.0, 0, 0]]))
    np.testing.assert_allclose(ahead_of_the_car, [[0.06, 0, 10]])
    left_of_the_car = transform(calibration.T_cam_imu, np.array([[10.0, 3, 0]]))
    np.testing.assert_allclose(left_of_the_car, [[-2.94, 0, 10]])


def test_labels_move_by_the_fourth_column_of_p2(tmp_path: Path) -> None:
    calibration = read_calibration(write(tmp_path / "0000.txt", CALIBRATION))
    label = np.array([[1.0, 2.0, 10.0]])
    P2 = np.array([[100.0, 0, 50, 6], [0, 100, 20, 0], [0, 0, 1, 0]])
    by_kitti = P2 @ np.append(label[0], 1.0)
    camera = calibration.camera((100, 40))
    ours = camera.project(transform(calibration.T_cam_label, label))
    np.testing.assert_allclose(ours[0], by_kitti[:2] / by_kitti[2])
    assert camera.height == 1.65


def test_without_the_other_sensors_there_is_no_imu(tmp_path: Path) -> None:
    calibration = read_calibration(write(tmp_path / "0000.txt", CALIBRATION.split("R_rect")[0]))
    assert calibration.T_cam_imu is None


@pytest.mark.parametrize(
    ("text", "error", "message"),
    [
        ("P0: 1 2 3\n", BadFile, r": no P2 .*; found: none"),
        ("P2: 1 2 3\n", BadFile, r":1: P2: has 3 values, 3 of them finite; 12 finite ones"),
        ("\nP2: " + "x " * 12, BadFile, r":2: P2:: could not convert string to float: 'x'"),
        ("P2: " + "nan " * 12, BadFile, r":1: P2: has 12 values, 0 of them finite"),
        (
            "P2: 700 0 600 0 0 0 170 0 0 0 1 0",
            BadCalibration,
            r": K = P2\[:, :3\] is singular: .*; mend P2",
        ),
        (
            "P2: 700 0 0 0 0 700 0 0 600 170 1 0",
            BadCalibration,
            r": K = P2\[:, :3\] is transposed: .*; mend P2",
        ),
        (
            CALIBRATION.replace("R_rect 1", "R_rect -1"),
            BadCalibration,
            ": R_rect: its determinant is -1: mirrored",
        ),
        (
            CALIBRATION.replace("Tr_velo_cam 0 -1", "Tr_velo_cam 0 -2"),
            BadCalibration,
            ": Tr_velo_cam: its rotation is not orthonormal",
        ),
        (CALIBRATION + "R0_rect: 1 0\n", BadFile, r":6: R0_rect: has 2 values"),
    ],
)
def test_bad_calibrations_are_refused(
    tmp_path: Path, text: str, error: type[Exception], message: str
) -> None:
    path = write(tmp_path / "0000.txt", text)
    with pytest.raises(error, match=re.escape(str(path)) + message):
        read_calibration(path)


def test_a_missing_calibration_is_named(tmp_path: Path) -> None:
    with pytest.raises(DatasetNotFound, match=r"0000.txt: no calibration"):
        read_calibration(tmp_path / "0000.txt")


@given(st.lists(st.floats(-2, 2), min_size=9, max_size=9))
def test_written_calibrations_are_read_back(
    tmp_path_factory: pytest.TempPathFactory, values: list[float]
) -> None:
    path = tmp_path_factory.mktemp("calib") / "0000.txt"
    K = np.array([[700.0, 0, 600], [0, 710, 170], [0, 0, 1]])
    T_cam_label = homogeneous(None, np.array(values[:3]))
    R = Rotation.from_rotvec(values[3:6]).as_matrix()
    T_cam_imu = homogeneous(R, np.array(values[6:]))
    write_calibration(Calibration(K, T_cam_label, T_cam_imu), path)
    read = read_calibration(path)
    np.testing.assert_allclose(read.K, K)
    np.testing.assert_allclose(read.T_cam_label, T_cam_label, atol=1e-9)
    np.testing.assert_allclose(read.T_cam_imu, T_cam_imu, atol=1e-9)
    write_calibration(Calibration(K), path)
    assert read_calibration(path).T_cam_imu is None
