"""Carrying beliefs to the camera of now: g(xi, .) of eqs. 3-4."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.tracker.samples import (
    AWAY,
    CAR,
    LEVEL,
    PITCHED,
    Car,
    beliefs_at,
    drive,
    locked,
)
from tracker import Tracker
from tracker.beliefs import Beliefs
from tracker.ego_motion import (
    MIN_SCALE,
    UNKNOWN_MOTION_COV,
    CameraMotion,
    compensate_ego_motion,
)
from tracker.errors import BadMotion
from tracker.geometry import homogeneous, invert, rotation_x, rotation_y, transform, wrap_angle
from tracker.lifecycle import in_view
from tracker.types import Camera, Detections, Frame

NO_DOUBT = np.zeros((6, 6))
ego_steps = st.tuples(st.floats(-2, 2), st.floats(-2, 3), st.floats(-0.2, 0.2))
cameras = pytest.mark.parametrize("camera", [LEVEL, PITCHED], ids=["level", "pitched"])


def step_of(camera: Camera, x: float = 0.0, z: float = 0.0, turn: float = 0.0) -> np.ndarray:
    """T_now_before of a camera whose car moves over the road to (x, z) and turns right."""
    T_before_now = homogeneous(rotation_y(turn), np.array([x, 0.0, z]))
    return camera.T_cam_road @ invert(T_before_now) @ camera.T_road_cam


def some_beliefs(camera: Camera = LEVEL) -> Beliefs:
    return beliefs_at((-4.0, 12.0), (0.0, 25.0), (6.0, 40.0), camera=camera, yaw=-1.2)


@cameras
def test_standing_still_leaves_everything(camera: Camera) -> None:
    before = some_beliefs(camera)
    now = compensate_ego_motion(before, camera, np.eye(4), NO_DOUBT)
    np.testing.assert_allclose(now.cuboids.base, before.cuboids.base, atol=1e-12)
    np.testing.assert_allclose(now.cuboids.yaw, before.cuboids.yaw, atol=1e-12)
    np.testing.assert_allclose(now.boxes, before.boxes, atol=1e-9)
    np.testing.assert_allclose(now.cov, before.cov, atol=1e-12)
    np.testing.assert_allclose(now.velocity, before.velocity, atol=1e-12)


@cameras
@given(ego_steps, ego_steps)
def test_two_steps_equal_the_step_that_they_make(camera: Camera, first, second) -> None:
    T_b_a, T_c_b = step_of(camera, *first), step_of(camera, *second)
    before = some_beliefs(camera)
    before.velocity[:] = [1.0, 5.0]
    before.cov[:, 0, 1] = before.cov[:, 1, 0] = 0.1
    twice = compensate_ego_motion(
        compensate_ego_motion(before, camera, T_b_a, NO_DOUBT), camera, T_c_b, NO_DOUBT
    )
    once = compensate_ego_motion(before, camera, T_c_b @ T_b_a, NO_DOUBT)
    np.testing.assert_allclose(twice.cuboids.base, once.cuboids.base, atol=1e-9)
    turned = wrap_angle(twice.cuboids.yaw - once.cuboids.yaw)
    np.testing.assert_allclose(turned, 0.0, atol=1e-9)
    np.testing.assert_allclose(twice.velocity, once.velocity, atol=1e-9)
    np.testing.assert_allclose(twice.cov, once.cov, atol=1e-9)


@cameras
@given(ego_steps)
def test_a_cuboid_stays_where_it_is_in_the_world(camera: Camera, step) -> None:
    """Corners in the road frame of before, seen from now, are the corners of the carried one."""
    before = some_beliefs(camera)
    now = compensate_ego_motion(before, camera, step_of(camera, *step), NO_DOUBT)
    T_before_now = homogeneous(rotation_y(step[2]), np.array([step[0], 0.0, step[1]]))
    seen_from_now = transform(invert(T_before_now), before.cuboids.corners())
    np.testing.assert_allclose(now.cuboids.corners(), seen_from_now, atol=1e-9)


def test_a_nod_of_the_camera_moves_cars_off_the_road_plane_and_keeps_their_yaw() -> None:
    nod = homogeneous(rotation_x(0.01))
    now = compensate_ego_motion(some_beliefs(), LEVEL, nod, NO_DOUBT)
    assert (np.abs(now.cuboids.base[:, 1]) > 0.05).all()
    np.testing.assert_allclose(now.cuboids.yaw, -1.2, atol=1e-9)


def test_velocity_and_doubt_turn_with_the_road_frame() -> None:
    before = beliefs_at((0.0, 20.0))
    before.velocity[0] = [0.0, 10.0]
    before.cov[0, :2, :2] = np.diag([1.0, 9.0])
    now = compensate_ego_motion(
        before, LEVEL, step_of(LEVEL, turn=np.pi / 2), NO_DOUBT
    )  # to the right
    np.testing.assert_allclose(now.velocity, [[-10.0, 0.0]], atol=1e-12)
    np.testing.assert_allclose(now.cov[0, :2, :2], np.diag([9.0, 1.0]), atol=1e-12)
    np.testing.assert_allclose(now.cuboids.base, [[-20.0, 0.0, 0.0]], atol=1e-12)
    assert now.cuboids.yaw[0] == pytest.approx(AWAY - np.pi / 2)


def test_doubt_along_a_ray_stays_along_it_when_the_camera_turns_to_it() -> None:
    """A car 30 degrees to the right, uncertain in depth only; then it is straight ahead."""
    angle = np.pi / 6
    ray = np.array([np.sin(angle), np.cos(angle)])
    before = beliefs_at(tuple(20.0 * ray))
    before.cov[0, :2, :2] = 9.0 * np.outer(ray, ray)
    before.cov[0, 2:, 2:] = 4.0 * np.outer(ray, ray)
    now = compensate_ego_motion(before, LEVEL, step_of(LEVEL, turn=angle), NO_DOUBT)
    np.testing.assert_allclose(now.cuboids.base, [[0.0, 0.0, 20.0]], atol=1e-12)
    np.testing.assert_allclose(now.cov[0], np.diag([0.0, 9.0, 0.0, 4.0]), atol=1e-12)


def test_the_motions_doubt_is_added_by_hand() -> None:
    """Translation adds itself; a doubt of yaw moves a car at 20 m across by 20 m a radian."""
    before = beliefs_at((0.0, 20.0))
    motion_cov = np.diag([0.01, 7.0, 0.04, 0.0, 0.001, 0.0])
    now = compensate_ego_motion(before, LEVEL, np.eye(4), motion_cov)
    added = now.cov[0] - before.cov[0]
    by_hand = np.zeros((4, 4))
    by_hand[0, 0], by_hand[1, 1] = 0.01 + 20.0**2 * 0.001, 0.04
    np.testing.assert_allclose(added, by_hand, atol=1e-9)


@given(ego_steps, st.integers(0, 99))
def test_the_motions_doubt_only_ever_adds(step, seed) -> None:
    A = np.random.default_rng(seed).normal(0.0, 0.05, (6, 6))
    T = step_of(PITCHED, *step)
    sure = compensate_ego_motion(some_beliefs(PITCHED), PITCHED, T, NO_DOUBT)
    unsure = compensate_ego_motion(some_beliefs(PITCHED), PITCHED, T, A @ A.T)
    assert np.linalg.eigvalsh(unsure.cov - sure.cov).min() > -1e-9
    np.testing.assert_array_equal(sure.cuboids.base, unsure.cuboids.base)


@given(st.floats(-0.1, 0.1), st.floats(-0.02, 0.02))
def test_a_turning_camera_carries_boxes_like_windows_in_a_far_wall(turn, nod) -> None:
    R = rotation_x(nod) @ rotation_y(turn)
    before = some_beliefs()
    corners = before.boxes.reshape(-1, 2)
    wall_cam = LEVEL.rays(corners) * 1e5
    by_homography = LEVEL.project(wall_cam @ R.T).reshape(-1, 4)
    now = compensate_ego_motion(before, LEVEL, homogeneous(R), NO_DOUBT)
    np.testing.assert_allclose(now.boxes, by_homography, atol=1e-6)


def test_driving_towards_a_car_widens_its_box_about_the_point_driven_to() -> None:
    """The window stands a quarter of the length before the centre: at 20 - 0.975 m."""
    before = beliefs_at((2.0, 20.0))
    now = compensate_ego_motion(before, LEVEL, step_of(LEVEL, z=5.0), NO_DOUBT)
    centre = LEVEL.K[[0, 1, 0, 1], [2, 2, 2, 2]]
    depth = 20.0 - 0.25 * CAR[0]
    by_hand = centre + (before.boxes - centre) * depth / (depth - 5.0)
    np.testing.assert_allclose(now.boxes, by_hand, atol=1e-9)


@cameras
def test_expected_boxes_of_static_cars_are_near_the_seen_ones(camera: Camera) -> None:
    parked = [Car(-4.0, 18.0), Car(3.0, 25.0), Car(8.0, 40.0, yaw=0.0)]
    path = drive(parked, lambda t: (0.2 * t, 10.0 * t, 0.3 * t), count=2, camera=camera)
    first, second = path.frames
    before = beliefs_at((-4.0, 18.0), (3.0, 25.0), (8.0, 40.0), camera=camera)
    before.boxes[:] = first.detections.boxes
    now = compensate_ego_motion(before, camera, second.T_now_before, second.motion_cov)
    assert path.cars[1] == [0, 1, 2]
    np.testing.assert_allclose(now.boxes, second.detections.boxes, atol=2.5)


def test_a_car_that_moves_two_metres_is_like_a_camera_that_moves_back_two() -> None:
    before = some_beliefs()
    moved = np.tile([0.5, 2.0], (3, 1))
    by_car = compensate_ego_motion(before, LEVEL, np.eye(4), NO_DOUBT, moved)
    by_camera = compensate_ego_motion(before, LEVEL, step_of(LEVEL, x=-0.5, z=-2.0), NO_DOUBT)
    np.testing.assert_allclose(by_car.cuboids.base, by_camera.cuboids.base, atol=1e-12)
    np.testing.assert_allclose(by_car.boxes, by_camera.boxes, atol=1e-9)


@cameras
@given(ego_steps)
def test_a_cars_own_way_is_measured_in_the_road_frame_of_before(camera: Camera, step) -> None:
    T, moved = step_of(camera, *step), np.array([[1.0, 3.0]])
    carried = compensate_ego_motion(
        beliefs_at((0.0, 20.0), camera=camera), camera, T, NO_DOUBT, moved
    )
    stood = compensate_ego_motion(beliefs_at((1.0, 23.0), camera=camera), camera, T, NO_DOUBT)
    np.testing.assert_allclose(carried.cuboids.base, stood.cuboids.base, atol=1e-9)


@cameras
def test_a_cars_way_and_the_cameras_turn_may_come_one_after_the_other(camera: Camera) -> None:
    before, turn = some_beliefs(camera), step_of(camera, turn=0.2)
    moved = np.tile([1.0, 3.0], (3, 1))
    once = compensate_ego_motion(before, camera, turn, NO_DOUBT, moved)
    gone = compensate_ego_motion(before, camera, np.eye(4), NO_DOUBT, moved)
    twice = compensate_ego_motion(gone, camera, turn, NO_DOUBT)
    np.testing.assert_allclose(once.boxes, twice.boxes, atol=1e-6)
    np.testing.assert_allclose(once.cuboids.base, twice.cuboids.base, atol=1e-9)


def test_a_car_that_falls_behind_the_camera_is_finite_and_out_of_view() -> None:
    before = beliefs_at((1.5, 6.0), (1.5, 30.0))
    now = compensate_ego_motion(before, LEVEL, step_of(LEVEL, z=10.0), NO_DOUBT)
    np.testing.assert_allclose(now.cuboids.base[:, 2], [-4.0, 20.0])
    assert np.isfinite(now.boxes).all()
    width = np.diff(now.boxes[:, ::2])[0] / np.diff(before.boxes[:, ::2])[0]
    assert width <= 1.0 / MIN_SCALE + 1e-9
    assert in_view(now, LEVEL).tolist() == [False, True]


def test_transport_leaves_its_inputs_as_they_were() -> None:
    before, moved = locked(some_beliefs()), np.ones((3, 2))
    T, motion_cov = step_of(LEVEL, 1.0, 1.0, 0.1), np.eye(6)
    compensate_ego_motion(before, LEVEL, *locked((T, motion_cov, moved)))


def test_nothing_is_carried_to_nothing() -> None:
    assert len(compensate_ego_motion(Beliefs.empty(), LEVEL, step_of(LEVEL, z=1.0), np.eye(6))) == 0


@pytest.mark.parametrize("preset", [Tracker.paper, Tracker.default])
def test_a_motion_faster_than_any_car_is_refused(preset) -> None:
    boxes = Detections.of([[600.0, 180.0, 660.0, 220.0]])
    tracker = preset(LEVEL)
    for index, metres in enumerate((0.0, -0.8, -20.0)):
        tracker.step(Frame(index, 0.1 * index, boxes, homogeneous(t=np.array([0, 0, metres]))))
    far = homogeneous(t=np.array([0.0, 0.0, -80.0]))  # 0.8 m in centimetres
    with pytest.raises(BadMotion, match=r"frame 3: T_now_before moves the camera by 80 m in 0\.1"):
        tracker.step(Frame(3, 0.3, boxes, far))
    tracker.step(Frame(3, 0.9, boxes, far))  # after a gap it may be


def test_motions_in_turn_are_one_motion() -> None:
    """Covariances live in the camera of now; the unknown grows with its time, not its frames."""
    turn, ahead = rotation_y(0.1), np.array([0.0, 0.0, -2.0])
    first = CameraMotion.of(Frame(1, 0.1, None, homogeneous(turn, ahead), np.eye(6) * 1e-4), 0.1)
    second = CameraMotion.of(Frame(2, 0.2, None, homogeneous(turn, ahead), np.eye(6) * 1e-4), 0.1)
    both = second.after(first)
    expected = homogeneous(turn, ahead) @ homogeneous(turn, ahead)
    np.testing.assert_allclose(both.T_now_before, expected)
    assert both.is_known
    assert np.trace(both.covariance) > np.trace(first.covariance) + np.trace(second.covariance)
    unknown = CameraMotion.of(Frame(3, 0.3, None), 0.1)
    half_known = unknown.after(both)
    assert not half_known.is_known
    np.testing.assert_allclose(half_known.T_now_before, expected)
    np.testing.assert_allclose(unknown.covariance, UNKNOWN_MOTION_COV)
    twice = CameraMotion.of(Frame(4, 0.4, None), 0.1).after(unknown)
    np.testing.assert_allclose(twice.covariance, 4.0 * UNKNOWN_MOTION_COV)
