"""The camera on the ego car: the conventions of frames, and clipping."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mot_sim.simulation.renderers.triangles import clip_polygon
from mot_sim.simulation.rig import KITTI_K, Rig
from mot_sim.simulation.traffic.traffic_state import TrafficState
from tracker.errors import BadCalibration
from tracker.geometry import invert, polygon_area, transform, wrap_angle
from tracker.types import Camera

SIZE = np.array([[4.0, 1.5, 1.8]])
F, CX, CY = KITTI_K[0][0], KITTI_K[0][2], KITTI_K[1][2]
coordinates, angles = st.floats(-80, 80), st.floats(-3.1, 3.1)


def state_of(x: float, y: float, heading: float, ego=(0.0, 0.0, 0.0)) -> TrafficState:
    one = np.array([1.0])
    return TrafficState(
        0.0, np.array([7]), x * one, y * one, heading * one, one, SIZE, np.array(ego), SIZE[0]
    )


def test_a_car_ahead_and_to_the_right_in_the_world_is_right_of_the_image_centre() -> None:
    rig = Rig.kitti()
    base = rig.cuboids(state_of(10.0, 2.0, 0.0)).base
    np.testing.assert_allclose(base, [[2.0, 0.0, 10.0]])
    pixel = rig.camera.project(transform(rig.camera.T_cam_road, base))[0]
    np.testing.assert_allclose(pixel, (CX + F * 2.0 / 10.0, CY + F * 1.65 / 10.0))


@pytest.mark.parametrize(
    ("heading", "yaw"), [(0.0, -np.pi / 2), (np.pi / 2, 0.0), (np.pi, np.pi / 2)]
)
def test_a_car_that_heads_as_we_do_has_yaw_minus_half_pi(heading, yaw) -> None:
    ego = (5.0, -3.0, 0.8)
    cuboids = Rig.kitti().cuboids(state_of(10.0, 2.0, 0.8 + heading, ego))
    np.testing.assert_allclose(wrap_angle(cuboids.yaw - yaw), 0.0, atol=1e-12)


def test_a_standing_point_moves_left_in_the_image_while_we_turn_right() -> None:
    rig = Rig.kitti(pitch=0.02, roll=0.01)
    before, now = (np.array(ego) for ego in ((0.0, 0.0, 0.0), (0.8, 0.02, 0.05)))
    T_now_before = invert(rig.T_world_cam(now)) @ rig.T_world_cam(before)
    point_world = np.array([[20.0, 1.0, -0.5]])
    point_before, point_now = (
        transform(invert(rig.T_world_cam(ego)), point_world) for ego in (before, now)
    )
    np.testing.assert_allclose(transform(T_now_before, point_before), point_now, atol=1e-12)
    u_before, u_now = (rig.camera.project(p)[0, 0] for p in (point_before, point_now))
    assert u_now < u_before


@given(coordinates, coordinates, angles, st.tuples(coordinates, coordinates, angles))
def test_cuboids_and_worlds_have_the_same_footprints(x, y, heading, ego) -> None:
    rig = Rig.kitti(pitch=0.03)
    state = state_of(x, y, heading, ego)
    footprint = rig.cuboids(state).footprint()[0]
    road = np.stack((footprint[:, 0], np.zeros(4), footprint[:, 1]), axis=1)
    back = transform(rig.T_world_road(state.ego), road)
    np.testing.assert_allclose(back[:, 2], 0.0, atol=1e-9)
    mine = sorted(map(tuple, np.round(back[:, :2], 6) + 0.0))
    theirs = sorted(map(tuple, np.round(state.footprint()[0], 6) + 0.0))
    np.testing.assert_allclose(mine, theirs, atol=2e-6)


@given(coordinates, coordinates, angles)
def test_ground_points_go_to_the_camera_as_the_transforms_say(x, y, heading) -> None:
    rig, ego = Rig.kitti(pitch=0.02, roll=-0.03), np.array([3.0, -2.0, heading])
    expected = transform(invert(rig.T_world_cam(ego)), np.array([[x, y, 0.0]]))
    np.testing.assert_allclose(rig.ground_cam(ego, np.array([[x, y]])), expected, atol=1e-9)


def test_an_empty_world_has_no_cuboids() -> None:
    state = state_of(1.0, 1.0, 0.0)
    none = np.zeros(0)
    empty = TrafficState(
        0.0, none.astype(int), none, none, none, none, SIZE[:0], state.ego, SIZE[0]
    )
    assert len(Rig.kitti().cuboids(empty)) == 0


def test_a_square_that_is_half_behind_loses_half() -> None:
    square = np.array([(0.0, -1.0), (1.0, -1.0), (1.0, 1.0), (0.0, 1.0)])
    clipped = clip_polygon(square, square[:, 1])
    assert sorted(map(tuple, clipped)) == [(0.0, 0), (0, 1), (1.0, 0), (1.0, 1)]


@given(st.floats(-1.2, 1.2), st.floats(-1.2, 1.2), st.floats(-1, 1))
def test_what_a_plane_cuts_off_and_what_it_leaves_is_the_whole(nx, ny, offset) -> None:
    turn = np.linspace(0.0, 2 * np.pi, 7, endpoint=False)
    polygon = np.stack((np.cos(turn), 2.0 * np.sin(turn)), axis=1)
    depth = polygon @ (nx, ny)
    parts = clip_polygon(polygon, depth, offset), clip_polygon(polygon, -depth, -offset)
    areas = [polygon_area(part[None])[0] for part in parts if len(part) >= 3]
    whole = polygon_area(polygon[None])[0]
    if np.abs(depth - offset).max() > 1e-6:
        np.testing.assert_allclose(sum(areas), whole, rtol=1e-6)


def test_nothing_is_left_of_what_lies_behind() -> None:
    square = np.array([(0.0, -1.0), (1.0, -1.0), (1.0, -2.0)])
    assert clip_polygon(square, square[:, 1]).shape == (0, 2)
    assert clip_polygon(square[:0], square[:0, 1]).shape == (0, 2)


@pytest.mark.parametrize(
    ("tilt", "told"),
    [
        ({"height": 0.0}, "camera height 0 m: the camera must stand above the road"),
        ({"height": -1.0}, "camera height -1 m"),
        ({"height": float("nan")}, "camera height is nan"),
        ({"pitch": 1.6}, "must look ahead and stand upright"),
        ({"roll": np.pi}, "must look ahead and stand upright"),
        ({"pitch": float("nan")}, "pitch is nan"),
    ],
)
def test_cameras_that_cannot_be_are_refused(tilt: dict[str, float], told: str) -> None:
    with pytest.raises(BadCalibration, match=told):
        Rig.kitti(**tilt)


def test_images_without_pixels_and_negative_focal_lengths_are_refused() -> None:
    K = np.array(KITTI_K)
    for size in ((0, 375), (1242, 0), (-5, 10)):
        with pytest.raises(BadCalibration, match=r"image size .*: give width and height"):
            Rig(Camera.mounted(K, size, 1.65))
    K[0, 0] = -700.0
    with pytest.raises(BadCalibration, match="focal length is negative"):
        Rig(Camera.mounted(K, (1242, 375), 1.65))


def test_cars_stand_on_the_same_ground_for_a_camera_that_tilts_with_the_body() -> None:
    rig, ego, tilt = Rig.kitti(pitch=0.01), np.array([3.0, -2.0, 0.4]), np.array([0.02, -0.03])
    level = state_of(30.0, 6.0, 0.8, ego)
    tilted = replace(level, tilt=tilt)
    ground = np.array([[30.0, 6.0, 0.0]])
    expected = transform(invert(rig.T_world_cam(ego, tilt)), ground)
    seen = transform(rig.camera.T_cam_road, rig.cuboids(tilted).base)
    np.testing.assert_allclose(seen, expected, atol=1e-12)
    by_camera = transform(rig.camera_in(tilted).T_cam_road, rig.cuboids(level).base)
    np.testing.assert_allclose(by_camera, expected, atol=1e-12)
    assert rig.camera_in(level) is rig.camera
    # It looks up and leans left: the ground ahead is seen lower, that on the right lower still.
    spots = np.array([[20.0, y, 0.0] for y in (-4.0, 0.0, 4.0)])
    flat, lower = (
        transform(invert(rig.T_world_cam(np.zeros(3), one)), spots)[:, 1] for one in (None, tilt)
    )
    np.testing.assert_allclose(lower - flat, 0.4 + 0.12 * np.array([-1.0, 0.0, 1.0]), atol=0.02)
