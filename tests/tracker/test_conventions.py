"""The conventions of frames, axes and signs: the one place that settles every ambiguity."""

import numpy as np
import pytest

from tests.tracker.samples import AWAY, CAR, LEVEL, beliefs_at, cars, drive, outlines
from tracker.ego_motion import compensate_ego_motion
from tracker.geometry import homogeneous, invert, rotation_y, transform
from tracker.types import Cuboids

# From `world` (x forward, y right, z down) to `cam` (x right, y down, z forward).
R_cam_world = np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]])
NO_DOUBT = np.zeros((6, 6))


def ego_step(x: float = 0.0, z: float = 0.0, turn: float = 0.0) -> np.ndarray:
    """T_now_before of a level camera that moves to (x, z) and turns right by `turn`."""
    return invert(homogeneous(rotation_y(turn), np.array([x, 0.0, z])))


def test_cam_is_y_z_x_of_world_a_rotation_and_no_mirror() -> None:
    np.testing.assert_array_equal(R_cam_world @ [1.0, 2.0, 3.0], [2.0, 3.0, 1.0])
    assert np.linalg.det(R_cam_world) == pytest.approx(1.0)


@pytest.mark.parametrize("heading", [-2.5, -0.4, 0.0, 0.3, 1.7])
def test_yaw_is_heading_minus_a_quarter_turn(heading: float) -> None:
    """Heading is about world z (down): 0 along world x, positive towards world y, the right."""
    along_world = np.array([np.cos(heading), np.sin(heading), 0.0])
    along_road = rotation_y(heading - np.pi / 2) @ [1.0, 0.0, 0.0]
    np.testing.assert_allclose(R_cam_world @ along_world, along_road, atol=1e-15)
    front_left, rear_left, *_ = cars((0.0, 20.0), yaw=heading - np.pi / 2).corners()[0]
    forward = (front_left - rear_left) / CAR[0]
    np.testing.assert_allclose(forward, R_cam_world @ along_world, atol=1e-14)


def test_a_car_ahead_to_the_right_appears_right_of_the_centre() -> None:
    box = outlines(cars((4.0, 20.0)))[0]
    assert box[0] > LEVEL.K[0, 2]


def test_road_y_points_down_so_the_road_lies_below_the_camera_and_the_roof_is_negative() -> None:
    assert LEVEL.T_cam_road[1, 3] == pytest.approx(LEVEL.height)
    assert transform(LEVEL.T_cam_road, np.zeros((1, 3)))[0, 1] > 0
    assert cars((0.0, 20.0)).corners()[0, 4:, 1] == pytest.approx(-CAR[1])
    top, bottom = outlines(cars((0.0, 20.0)))[0, 1::2]
    assert top < bottom


def test_positive_yaw_turns_the_front_from_the_right_towards_the_camera() -> None:
    front = rotation_y(0.3) @ [1.0, 0.0, 0.0]
    assert front[2] < 0
    facing_us = Cuboids(np.array([[0.0, 0.0, 20.0]]), np.array([np.pi / 2]), CAR[None])
    assert facing_us.corners()[0, 0, 2] < 20.0


def test_an_ego_car_that_drives_a_metre_forward_finds_static_points_a_metre_nearer() -> None:
    T_now_before = ego_step(z=1.0)
    np.testing.assert_allclose(transform(T_now_before, np.array([2.0, 1.0, 10.0])), [2, 1, 9])
    near = compensate_ego_motion(beliefs_at((2.0, 10.0)), LEVEL, T_now_before, NO_DOUBT)
    np.testing.assert_allclose(near.cuboids.base, [[2.0, 0.0, 9.0]], atol=1e-12)
    before = beliefs_at((2.0, 10.0)).boxes[0]
    assert near.boxes[0, 2] - near.boxes[0, 0] > before[2] - before[0]


def test_an_ego_car_that_turns_left_finds_static_points_further_right() -> None:
    T_now_before = ego_step(turn=-0.1)
    belief = beliefs_at((0.0, 20.0))
    now = compensate_ego_motion(belief, LEVEL, T_now_before, NO_DOUBT)
    assert now.cuboids.base[0, 0] == pytest.approx(20.0 * np.sin(0.1))
    assert (now.boxes[0, ::2] > belief.boxes[0, ::2] + 50.0).all()
    assert now.cuboids.yaw[0] == pytest.approx(AWAY + 0.1)


def test_t_now_before_is_the_pose_of_before_seen_from_now() -> None:
    T_world_before = homogeneous(rotation_y(0.2), np.array([5.0, 0.0, 3.0]))
    T_world_now = homogeneous(rotation_y(0.3), np.array([6.0, 0.0, 8.0]))
    point_before = np.array([1.0, 1.0, 12.0])
    via_world = transform(invert(T_world_now), transform(T_world_before, point_before))
    T_now_before = invert(T_world_now) @ T_world_before
    np.testing.assert_allclose(transform(T_now_before, point_before), via_world, atol=1e-12)


def test_the_frames_of_a_drive_chain_to_its_poses() -> None:
    """T_now_before of a turning drive, chained, leads from the first camera to the last."""
    path = drive([], lambda t: (0.3 * t, 4.0 * t, 0.5 * t), count=6)
    chained = np.eye(4)
    for frame in path.frames[1:]:
        chained = frame.T_now_before @ chained
    last = homogeneous(rotation_y(0.25), np.array([0.15, 0.0, 2.0]))
    of_the_road = LEVEL.T_road_cam @ chained @ LEVEL.T_cam_road
    np.testing.assert_allclose(of_the_road, invert(last), atol=1e-12)
