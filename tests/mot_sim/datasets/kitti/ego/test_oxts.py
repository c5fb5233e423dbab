"""OXTS lines as poses of the IMU and of the camera."""

from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from mot_sim.datasets.kitti.calibration import read_calibration
from mot_sim.datasets.kitti.ego import Oxts, read_oxts
from mot_sim.datasets.kitti.sequence import kitti_sequence
from tests.mot_sim.datasets.conftest import CALIBRATION, STEP, write
from tracker.errors import BadFile
from tracker.geometry import invert

REST = " 0" * 24


def test_longitude_is_east_latitude_is_north_and_altitude_is_up(tmp_path: Path) -> None:
    rows = ["49 8 100 0 0 0", "49 8.00001 100 0 0 0", "49.00001 8 100 0 0 0", "49 8 101 0 0 0"]
    poses = read_oxts(write(tmp_path / "0.txt", "".join(row + REST + "\n" for row in rows)))
    # Mercator with the scale of the first latitude: a degree is equally long both ways there.
    north = np.radians(1e-5) * 6_378_137.0
    np.testing.assert_allclose(
        poses[:, :3, 3], [[0, 0, 0], [STEP, 0, 0], [0, north, 0], [0, 0, 1]], atol=1e-5
    )
    np.testing.assert_array_equal(poses[:, :3, :3], np.tile(np.eye(3), (4, 1, 1)))


def test_attitude_is_yaw_after_pitch_after_roll(tmp_path: Path) -> None:
    pose = read_oxts(write(tmp_path / "0.txt", "49 8 100 0.1 0.2 0.3" + REST))[0]
    expected = Rotation.from_euler("ZYX", [0.3, 0.2, 0.1]).as_matrix()
    np.testing.assert_allclose(pose[:3, :3], expected, atol=1e-12)


def test_an_empty_file_holds_no_pose(tmp_path: Path) -> None:
    assert read_oxts(write(tmp_path / "0.txt", "")).shape == (0, 4, 4)


def test_turning_left_on_the_spot_moves_the_world_right_in_the_camera(tiny_tree: Path) -> None:
    write(
        tiny_tree / "training" / "oxts" / "0030.txt",
        f"49 8 100 0 0 0{REST}\n49 8 100 0 0 0.1{REST}\n",
    )
    calibration = read_calibration(tiny_tree / "training" / "calib" / "0030.txt")
    before, now = Oxts().poses(tiny_tree, "training", "0030", calibration, 2)
    ahead_now = invert(now) @ before @ np.array([0.0, 0, 10, 1])
    assert ahead_now[0] == pytest.approx(0.06 + 10 * np.sin(0.1) - 0.06 * np.cos(0.1))


def test_bad_oxts_files_are_refused(tiny_tree: Path) -> None:
    path = tiny_tree / "training" / "oxts" / "0030.txt"
    calibration = read_calibration(tiny_tree / "training" / "calib" / "0030.txt")
    with pytest.raises(BadFile, match=r"0030.txt: 3 lines for 5 frames"):
        Oxts().poses(tiny_tree, "training", "0030", calibration, 5)
    write(path, f"49 8 100 0 0 0{REST}\n49 8 100\n")
    with pytest.raises(BadFile, match=r"0030.txt:2: 3 values where 30 belong"):
        read_oxts(path)
    write(path, f"49 8 100 0 0 nan{REST}\n")
    with pytest.raises(BadFile, match=r"0030.txt:1: yaw is not finite"):
        read_oxts(path)


def test_a_calibration_without_the_imu_cannot_use_oxts(tiny_tree: Path) -> None:
    path = write(tiny_tree / "training" / "calib" / "0030.txt", CALIBRATION.split("R_rect")[0])
    with pytest.raises(BadFile, match=r"calib/0030.txt: lacks R_rect.*take another ego-motion"):
        Oxts().poses(tiny_tree, "training", "0030", read_calibration(path), 3)


@pytest.mark.parametrize("lost", ["", "   "])
def test_a_blank_line_for_a_lost_sample_is_refused_with_its_line(tiny_tree: Path, lost) -> None:
    path = tiny_tree / "training" / "oxts" / "0030.txt"
    rows = path.read_text().splitlines()
    write(path, "\n".join([rows[0], lost, rows[2]]) + "\n\n")
    for ego in ("oxts", "orbslam3"):
        with pytest.raises(BadFile, match=r"oxts/0030.txt:2: a blank line where frame 1 belongs"):
            kitti_sequence(tiny_tree, "0030", ego=ego)
    with pytest.raises(BadFile, match="2 of 3 lines hold values"):
        read_oxts(path)


def test_a_missing_line_is_noticed_by_kittis_own_count(tiny_tree: Path) -> None:
    training = tiny_tree / "training"
    (training / "calib" / "0030.txt").rename(training / "calib" / "0012.txt")
    write(tiny_tree / "detections/rrc/0012.txt", "")
    row = "49 8 100 0 0 0" + REST + "\n"
    path = write(training / "oxts" / "0012.txt", row * 77)
    with pytest.raises(BadFile, match=r"oxts/0012.txt: 77 lines where KITTI's .* 0012 has 78"):
        kitti_sequence(tiny_tree, "0012")
    for count in (78, 40):  # 40: a drive of one's own
        write(path, row * count)
        assert len(kitti_sequence(tiny_tree, "0012")) == count


def test_detections_beyond_the_lines_of_oxts_name_both(tiny_tree: Path) -> None:
    rows = (tiny_tree / "training/oxts/0030.txt").read_text().splitlines()
    write(tiny_tree / "training/oxts/0030.txt", "\n".join(rows[:2]))
    told = r"rrc/0030.txt:2: frame beyond .*does \S*oxts/0030.txt, with one line per frame, lack"
    with pytest.raises(BadFile, match=told):
        kitti_sequence(tiny_tree, "0030")


def test_a_leap_of_the_positions_is_refused(tiny_tree: Path) -> None:
    path = tiny_tree / "training" / "oxts" / "0030.txt"
    write(path, "".join(f"{49 + d} 8 100 0 0 0{REST}\n" for d in (0, 0, 0.01)))
    assert len(read_oxts(path)) == 3
    with pytest.raises(BadFile, match=r"oxts/0030.txt:3: a leap of 1113 m"):
        kitti_sequence(tiny_tree, "0030")
