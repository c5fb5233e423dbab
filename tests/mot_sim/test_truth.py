"""Exact boxes, truncation and occlusion."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mot_sim.rig import KITTI_K, Rig
from mot_sim.traffic.world import World
from mot_sim.truth import NEAR, exact_truth, frame_truth, occlusion_level
from tracker.geometry import transform

F, CX, CY = KITTI_K[0][0], KITTI_K[0][2], KITTI_K[1][2]
RIG = Rig.kitti()
CAR = (4.0, 1.5, 1.8)
EGO = np.zeros(3)


def world_of(*cars: tuple[float, float, float], size=CAR) -> World:
    """Cars at (x, y, heading); we stand at the origin."""
    poses = np.array(cars, dtype=float).reshape(-1, 3)
    n = len(poses)
    return World(
        0.0, np.arange(n), poses[:, 0], poses[:, 1], poses[:, 2], np.zeros(n),
        np.tile(np.array(size), (n, 1)), EGO, np.array(CAR),
    )  # fmt: skip


def test_the_box_of_a_car_straight_ahead_is_that_of_its_rear() -> None:
    truth = frame_truth(world_of((20.0, 0.0, 0.0)), RIG, 3)
    scale = F / 18.0
    expected = [CX - 0.9 * scale, CY + 0.15 * scale, CX + 0.9 * scale, CY + 1.65 * scale]
    # The roof of the front end is nearer to the horizon than that of the rear, hence higher up.
    expected[1] = CY + 0.15 * F / 22.0
    np.testing.assert_allclose(truth.tracks.boxes, [expected])
    assert truth.tracks.frames.tolist() == [3]
    assert truth.tracks.kinds is not None
    assert truth.tracks.kinds.tolist() == ["Car"]
    assert (truth.visible[0], truth.cut[0]) == (1.0, 0.0)


def test_a_car_behind_us_is_not_in_the_truth() -> None:
    assert len(frame_truth(world_of((-20.0, 0.0, 0.0)), RIG, 0)) == 0


def test_an_empty_world_has_an_empty_truth() -> None:
    truth = exact_truth([world_of(), world_of()], RIG)
    assert len(truth) == 0
    assert truth.tracks.boxes.shape == (0, 4)


def test_a_car_wholly_behind_a_wider_and_nearer_one_is_invisible_but_in_the_truth() -> None:
    tall = (4.0, 1.8, 1.8)  # higher than the camera: nobody is seen over the roof
    truth = frame_truth(world_of((40.0, 0.0, 0.0), (15.0, 0.0, np.pi / 2), size=tall), RIG, 0)
    assert truth.visible.tolist() == [0.0, 1.0]
    assert truth.tracks.occlusion is not None
    assert truth.tracks.occlusion.tolist() == [3, 0]


def test_a_car_half_behind_another_is_half_visible() -> None:
    # Rears at 13 m and 26 m; the nearer's right edge is at .9 / 13, the farther's centre there.
    truth = frame_truth(world_of((28.0, 1.8, 0.0), (15.0, 0.0, 0.0)), RIG, 0)
    assert truth.visible[1] == 1.0
    assert 0.42 < truth.visible[0] < 0.58


@pytest.mark.parametrize(
    ("visible", "level"), [(1.0, 0), (0.8, 0), (0.79, 1), (0.5, 1), (0.49, 2), (0.2, 2), (0.1, 3)]
)
def test_visible_fractions_have_kittis_levels(visible, level) -> None:
    assert occlusion_level(np.array([visible])).tolist() == [level]


def test_a_car_that_leaves_the_image_is_truncated_and_its_box_ends_at_the_border() -> None:
    truth = frame_truth(world_of((10.0, 7.2, 0.0), (30.0, 0.0, 0.0)), RIG, 0)
    assert truth.tracks.boxes[0, 2] == 1241.0
    assert truth.full_boxes[0, 2] > 1241.0
    assert 0.05 < truth.cut[0] < 0.95
    assert truth.tracks.truncation is not None
    assert truth.tracks.truncation.tolist() == [1, 0]


def test_a_car_that_reaches_behind_the_camera_keeps_the_part_before_it() -> None:
    truth = frame_truth(world_of((1.0, 3.0, 0.0)), RIG, 0)
    assert len(truth) == 1
    # Its front end, 3 m ahead, is the leftmost: the inner side is 2.1 m to the right.
    np.testing.assert_allclose(truth.tracks.boxes[0, 0], CX + F * 2.1 / 3.0)
    assert truth.tracks.boxes[0, 2:].tolist() == [1241.0, 374.0]
    assert truth.cut[0] > 0.5


@given(
    st.floats(-3, 60), st.floats(-20, 20), st.floats(-3.1, 3.1), st.floats(-0.05, 0.05),
    st.integers(0, 1000),
)  # fmt: skip
def test_boxes_hold_every_point_of_the_car_before_the_camera(x, y, heading, pitch, seed) -> None:
    rig = Rig.kitti(pitch=pitch, roll=0.02)
    world = world_of((x, y, heading))
    truth = frame_truth(world, rig, 0)
    rng = np.random.default_rng(seed)
    inside = (rng.random((50, 3)) - (0.5, 1.0, 0.5)) * CAR
    cuboid = rig.cuboids(world)
    c, s = np.cos(cuboid.yaw[0]), np.sin(cuboid.yaw[0])
    R_road_object = np.array([[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]])
    points_cam = transform(rig.camera.T_cam_road, inside @ R_road_object.T + cuboid.base[0])
    pixels = rig.camera.project(points_cam[points_cam[:, 2] > NEAR])
    width, height = rig.camera.image_size
    seen = pixels[((pixels > 0.5) & (pixels < (width - 1.5, height - 1.5))).all(axis=1)]
    if len(seen):
        assert len(truth) == 1
        assert (seen >= truth.tracks.boxes[0, :2] - 1e-6).all()
        assert (seen <= truth.tracks.boxes[0, 2:] + 1e-6).all()
    assert ((truth.visible >= 0.0) & (truth.visible <= 1.0)).all()
    assert ((truth.cut >= 0.0) & (truth.cut <= 1.0)).all()


@given(st.lists(st.tuples(st.floats(5, 60), st.floats(-20, 20), st.floats(-3, 3)), max_size=5))
def test_one_more_car_behind_all_others_hides_nobody(cars) -> None:
    without = frame_truth(world_of(*cars), RIG, 0)
    with_one = frame_truth(world_of(*cars, (120.0, 0.0, 0.0)), RIG, 0)
    others = with_one.tracks.ids < len(cars)
    np.testing.assert_array_equal(with_one.visible[others], without.visible)
