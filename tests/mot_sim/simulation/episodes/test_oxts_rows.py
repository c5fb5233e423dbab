"""OXTS rows: what KITTI's reader makes of them is where the car was."""

from pathlib import Path

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from mot_sim.datasets.kitti.ego import OXTS_COLUMNS, read_oxts
from mot_sim.files.writing import write_lines
from mot_sim.simulation.episodes.oxts_rows import calibration_of, oxts_lines
from tests.mot_sim.simulation.episodes.small import rig
from tracker.geometry import transform


def rows(ego: list[tuple[float, float, float]]) -> dict[str, np.ndarray]:
    """The columns by name."""
    table = np.array([line.split() for line in oxts_lines(np.array(ego))], dtype=float)
    return dict(zip(OXTS_COLUMNS, table.T, strict=True))


def test_a_car_that_drives_along_x_drives_east() -> None:
    found = rows([(10.0 + 0.5 * step, 3.0, 0.0) for step in range(3)])
    np.testing.assert_allclose(found["ve"], 5.0, atol=1e-6)
    np.testing.assert_allclose(found["vf"], 5.0, atol=1e-6)
    for still in ("vn", "vl", "vu", "yaw", "wz", "ax"):
        np.testing.assert_allclose(found[still], 0.0, atol=1e-6)
    assert (np.diff(found["lon"]) > 0).all()


def test_a_car_that_turns_right_turns_clockwise_seen_from_above() -> None:
    turn = [(0.5 * np.sin(a), 0.5 * (1 - np.cos(a)), a) for a in (0.0, 0.1, 0.2)]
    found = rows(turn)
    np.testing.assert_allclose(found["wz"], -1.0, atol=1e-6)
    np.testing.assert_allclose(found["yaw"], [0.0, -0.1, -0.2], atol=1e-9)
    assert found["lat"][-1] < found["lat"][0]  # to the south


def test_one_frame_stands_and_none_has_no_rows() -> None:
    assert rows([(1.0, 2.0, 3.0)])["vf"].tolist() == [0.0]
    assert oxts_lines(np.zeros((0, 3))) == []


places = st.tuples(st.floats(-500, 500), st.floats(-500, 500), st.floats(-7, 7))


@given(st.lists(places, min_size=1, max_size=5))
def test_positions_and_headings_come_back(tmp_path_factory, ego) -> None:
    path = Path(tmp_path_factory.mktemp("oxts")) / "0000.txt"
    write_lines(path, oxts_lines(np.array(ego)))
    read, given_ego = read_oxts(path), np.array(ego)
    moved = (given_ego - given_ego[:1])[:, :2] * (1.0, -1.0)
    np.testing.assert_allclose(read[:, :2, 3], moved, atol=1e-6)
    np.testing.assert_allclose(read[:, 0, 0], np.cos(given_ego[:, 2]), atol=1e-9)
    np.testing.assert_allclose(read[:, 1, 0], -np.sin(given_ego[:, 2]), atol=1e-9)


def test_the_inertial_unit_stands_level_below_the_camera() -> None:
    calibration = calibration_of(rig(pitch=0.1, roll=0.02).camera)
    assert calibration.T_cam_imu is not None
    camera = rig(pitch=0.1, roll=0.02).camera
    ahead_left_up = np.array([[10.0, 2.0, 1.0]])
    in_cam = transform(calibration.T_cam_imu, ahead_left_up)
    in_road = transform(camera.T_road_cam, in_cam)
    np.testing.assert_allclose(in_road, [[-2.0, -1.93, 10.0]], atol=1e-12)
