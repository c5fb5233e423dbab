"""Boxes of cuboids, by hand and near the camera."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from mot_sim.simulation.renderers.triangles import NEAR_METRES
from mot_sim.simulation.rig import KITTI_K, Rig
from mot_sim.simulation.truth import boxes_around, boxes_in_image, project_edges, truncation_of
from tests.mot_sim.simulation.truth.states import RIG, state_of
from tracker.geometry import transform

F, CX, CY = KITTI_K[0][0], KITTI_K[0][2], KITTI_K[1][2]
SIZE = (4.0, 1.5, 1.8)


def box_of(x: float, y: float, heading: float, rig: Rig = RIG) -> np.ndarray:
    cuboids = rig.cuboids(state_of((x, y, heading), size=SIZE))
    return boxes_around(project_edges(cuboids, rig.camera))[0]


def test_the_box_of_a_cuboid_straight_ahead_is_that_of_its_rear() -> None:
    scale = F / 18.0
    # The roof of the front end is nearer to the horizon than that of the rear, hence higher up.
    expected = [CX - 0.9 * scale, CY + 0.15 * F / 22.0, CX + 0.9 * scale, CY + 1.65 * scale]
    np.testing.assert_allclose(box_of(20.0, 0.0, 0.0), expected)


def test_a_cuboid_behind_the_camera_has_an_inverted_box_and_is_all_cut() -> None:
    boxes = box_of(-20.0, 0.0, 0.0)[None]
    assert boxes[0, 0] > boxes[0, 2]
    assert truncation_of(boxes, RIG.camera).tolist() == [1.0]
    behind = RIG.cuboids(state_of((-20.0, 0.0, 0.0), size=SIZE))
    assert np.isinf(boxes_in_image(behind, RIG.camera)).all()


def test_what_reaches_behind_the_camera_is_cut_at_the_near_plane() -> None:
    # Its front end, 3 m ahead, is the leftmost: the inner side is 2.1 m to the right.
    np.testing.assert_allclose(box_of(1.0, 3.0, 0.0)[0], CX + F * 2.1 / 3.0)


def test_beside_the_camera_only_what_is_inside_the_image_counts() -> None:
    cuboid = RIG.cuboids(state_of((1.0, 3.0, 0.0), size=SIZE))
    # Its front end, 3 m ahead and 2.1 m to the right, is the leftmost part, and the highest: the
    # roof is 0.15 m below the camera. From there on it leaves the image to the right and below.
    left, top, right, bottom = boxes_in_image(cuboid, RIG.camera)[0]
    assert (right, bottom) == (1241.0, 374.0)
    np.testing.assert_allclose(left, CX + F * 2.1 / 3.0)
    np.testing.assert_allclose(top, CY + 0.15 * F / 3.0)


def test_the_box_inside_the_image_is_the_whole_one_of_a_cuboid_in_it() -> None:
    cuboids = RIG.cuboids(state_of((20.0, 1.0, 0.4), (12.0, -3.0, 2.0), size=SIZE))
    whole = boxes_around(project_edges(cuboids, RIG.camera))
    np.testing.assert_allclose(boxes_in_image(cuboids, RIG.camera), whole)
    assert truncation_of(whole, RIG.camera).tolist() == [0.0, 0.0]


@given(
    st.floats(-3, 60),
    st.floats(-20, 20),
    st.floats(-3.1, 3.1),
    st.floats(-0.05, 0.05),
    st.integers(0, 1000),
)
def test_boxes_hold_every_point_of_the_cuboid_before_the_camera(x, y, heading, pitch, seed) -> None:
    rig = Rig.kitti(pitch=pitch, roll=0.02)
    cuboid = rig.cuboids(state_of((x, y, heading), size=SIZE))
    inside = (np.random.default_rng(seed).random((50, 3)) - (0.5, 1.0, 0.5)) * SIZE
    c, s = np.cos(cuboid.yaw[0]), np.sin(cuboid.yaw[0])
    R_road_object = np.array([[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]])
    points_cam = transform(rig.camera.T_cam_road, inside @ R_road_object.T + cuboid.base[0])
    pixels = rig.camera.project(points_cam[points_cam[:, 2] > NEAR_METRES])
    box = box_of(x, y, heading, rig)
    assert (pixels >= box[:2] - 1e-6).all()
    assert (pixels <= box[2:] + 1e-6).all()


def test_no_cuboid_has_no_box() -> None:
    cuboids = RIG.cuboids(state_of())
    assert boxes_around(project_edges(cuboids, RIG.camera)).shape == (0, 4)
    assert boxes_in_image(cuboids, RIG.camera).shape == (0, 4)
