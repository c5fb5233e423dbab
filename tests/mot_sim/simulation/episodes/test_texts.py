"""The text files of an episode: what they hold, and OXTS rows."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mot_sim.datasets import DETECTORS, EGO, DetectionLog, kitti_sequence
from mot_sim.datasets.kitti.ego import OXTS_COLUMNS, read_oxts
from mot_sim.files.writing import write_lines
from mot_sim.simulation.episode import record
from mot_sim.simulation.episodes import EpisodeFiles, PictureOptions, record_episode
from mot_sim.simulation.episodes.texts import (
    calibration_of,
    detection_lines,
    exact_detections,
    noisy_poses,
    oxts_lines,
)
from tests.mot_sim.simulation.episodes.conftest import SEED
from tests.mot_sim.simulation.episodes.small import FRAMES, rig, small
from tracker.geometry import invert, transform
from tracker.types import Detections


def printed(values: np.ndarray, digits: int = 6) -> np.ndarray:
    """The numbers that stand in a file."""
    texts = [f"{value:.{digits}f}" for value in np.ravel(values).tolist()]
    return np.array([float(text) for text in texts]).reshape(np.shape(values))


def test_kittis_reader_gives_back_the_camera_and_the_poses(recorded: Path) -> None:
    live = record(small(), SEED)
    read = kitti_sequence(recorded, "0000", "simulated", "oxts", images=True)
    assert read.frame_count == FRAMES
    assert read.camera.image_size == live.camera.image_size
    np.testing.assert_allclose(read.camera.K, live.camera.K, rtol=1e-12)
    np.testing.assert_array_equal(read.camera.T_cam_road, live.camera.T_cam_road)
    assert read.Ts_world_cam is not None
    assert live.Ts_world_cam is not None
    mine, theirs = (invert(Ts[:1]) @ Ts for Ts in (live.Ts_world_cam, read.Ts_world_cam))
    np.testing.assert_allclose(theirs, mine, atol=1e-6)
    assert abs(theirs[-1, 0, 3]) > 0.01  # we did turn
    assert all(frame.image is not None for frame in read)


def test_labels_are_equal_to_the_last_printed_digit(recorded: Path) -> None:
    live = record(small(), SEED).truth
    read = kitti_sequence(recorded, "0000", "simulated", "oxts", images=True).truth
    assert read is not None
    for column in ("frames", "ids", "kinds", "truncation", "occlusion"):
        assert getattr(read, column).tolist() == getattr(live, column).tolist()
    np.testing.assert_array_equal(read.boxes, printed(live.boxes))
    assert read.cuboids is not None
    assert live.cuboids is not None
    np.testing.assert_array_equal(read.cuboids.size, printed(live.cuboids.size))
    np.testing.assert_allclose(read.cuboids.base, live.cuboids.base, atol=1e-6)
    np.testing.assert_allclose(read.cuboids.yaw, live.cuboids.yaw, atol=1e-6)


@pytest.mark.parametrize("name", ["simulated", "exact"])
def test_detections_are_equal_to_the_last_printed_digit(recorded: Path, name: str) -> None:
    live = record(small(), SEED)
    log = live.log if name == "simulated" else exact_detections(live.exact)
    read = kitti_sequence(recorded, "0000", name, "oxts", images=True).log
    assert len(read.frames) > 0
    assert read.frames.tolist() == log.frames.tolist()
    np.testing.assert_array_equal(read.detections.boxes, printed(log.detections.boxes))
    np.testing.assert_array_equal(read.detections.scores, printed(log.detections.scores))
    assert DETECTORS[name].score_map is None  # probabilities already


def test_a_pitched_and_rolled_camera_keeps_its_labels_and_poses(tmp_path: Path) -> None:
    scene = small(pitch=0.05, roll=0.03)
    record_episode(scene, SEED, EpisodeFiles(tmp_path, "0030"), PictureOptions(("images",)))
    live = record(scene, SEED)
    read = kitti_sequence(tmp_path, "0030", "exact", "oxts", images=True, pitch=0.05)
    assert read.Ts_world_cam is not None
    assert live.Ts_world_cam is not None
    mine, theirs = (invert(Ts[:1]) @ Ts for Ts in (live.Ts_world_cam, read.Ts_world_cam))
    np.testing.assert_allclose(theirs, mine, atol=1e-6)
    truth = read.truth
    assert truth is not None
    assert truth.cuboids is not None
    assert live.truth.cuboids is not None
    # The reader knows the pitch, not the roll: cuboids differ by that turn about the view alone.
    distance = np.linalg.norm(live.truth.cuboids.base - (0.0, -1.65, 0.0), axis=1)
    seen = np.linalg.norm(truth.cuboids.base - (0.0, -1.65, 0.0), axis=1)
    np.testing.assert_allclose(seen, distance, atol=1e-5)


def test_noisy_odometry_is_read_and_has_the_promised_covariance(recorded: Path) -> None:
    read = kitti_sequence(recorded, "0000", "exact", "noisy", images=True)
    exact = record(small(), SEED).Ts_world_cam
    assert exact is not None
    assert read.Ts_world_cam is not None
    np.testing.assert_allclose(read.Ts_world_cam, noisy_poses(exact, SEED), atol=1e-8)
    still = np.tile(np.eye(4), (4000, 1, 1))
    noisy = noisy_poses(still, 1)
    steps = invert(noisy[1:]) @ noisy[:-1]  # T_now_before of a camera that stands
    turns = np.stack((steps[:, 2, 1], steps[:, 0, 2], steps[:, 1, 0]), axis=1)
    found = np.cov(np.concatenate((steps[:, :3, 3], turns), axis=1).T)
    promised = EGO["noisy"].motion_cov
    assert promised is not None
    np.testing.assert_allclose(np.diag(found), np.diag(promised), rtol=0.1)


def test_the_noise_of_a_frame_hangs_on_seed_and_frame_alone() -> None:
    short, long = np.tile(np.eye(4), (5, 1, 1)), np.tile(np.eye(4), (9, 1, 1))
    np.testing.assert_array_equal(noisy_poses(long, 7)[:5], noisy_poses(short, 7))
    assert not np.array_equal(noisy_poses(short, 7), noisy_poses(short, 8))


def test_boxes_that_have_no_area_in_print_are_left_out() -> None:
    boxes = np.array([[1.0, 2.0, 1.0000004, 5.0], [1.0, 2.0, 3.0, 5.0]])
    log = DetectionLog(np.array([0, 0]), Detections(boxes, np.array([0.5, 0.25])))
    assert list(detection_lines(log)) == ["0,1.000000,2.000000,3.000000,5.000000,0.250000"]
    nothing = DetectionLog(np.zeros(0, np.int64), Detections.empty())
    assert list(detection_lines(nothing)) == []


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


def test_pitch_and_roll_of_the_body_come_back(tmp_path: Path) -> None:
    ego = np.array([[5.0, 2.0, 0.3], [5.8, 2.2, 0.35], [6.6, 2.5, 0.4]])
    tilt = np.array([[0.01, -0.02], [-0.015, 0.0], [0.02, 0.03]])
    write_lines(tmp_path / "0000.txt", oxts_lines(ego, tilt))
    mounted = rig(pitch=0.05)
    T_cam_imu = calibration_of(mounted.camera).T_cam_imu
    assert T_cam_imu is not None
    read = read_oxts(tmp_path / "0000.txt") @ invert(T_cam_imu)
    true = np.array([mounted.T_world_cam(*pair) for pair in zip(ego, tilt, strict=True)])
    for frame in (1, 2):
        np.testing.assert_allclose(
            invert(read[frame]) @ read[0], invert(true[frame]) @ true[0], atol=1e-6
        )


def test_the_inertial_unit_stands_level_below_the_camera() -> None:
    calibration = calibration_of(rig(pitch=0.1, roll=0.02).camera)
    assert calibration.T_cam_imu is not None
    camera = rig(pitch=0.1, roll=0.02).camera
    ahead_left_up = np.array([[10.0, 2.0, 1.0]])
    in_cam = transform(calibration.T_cam_imu, ahead_left_up)
    in_road = transform(camera.T_road_cam, in_cam)
    np.testing.assert_allclose(in_road, [[-2.0, -1.93, 10.0]], atol=1e-12)
