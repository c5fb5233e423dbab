"""The camera: where it stands above the road, what it sees, and what cannot be a camera."""

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from tests.tracker.samples import HEIGHT, IMAGE, LEVEL, PITCHED, K
from tracker.errors import BadCalibration
from tracker.geometry import homogeneous, transform
from tracker.types import Camera

angles = st.floats(-0.2, 0.2)


def test_a_level_camera_hangs_above_the_road_with_the_axes_of_the_road() -> None:
    np.testing.assert_allclose(LEVEL.T_cam_road[:3, :3], np.eye(3), atol=1e-15)
    np.testing.assert_allclose(LEVEL.T_cam_road[:3, 3], [0.0, HEIGHT, 0.0], atol=1e-15)
    np.testing.assert_allclose(LEVEL.road_normal, [0.0, 1.0, 0.0], atol=1e-15)
    assert LEVEL.height == pytest.approx(HEIGHT)


def test_a_camera_that_looks_up_sees_the_horizon_lower() -> None:
    far_road = np.array([[0.0, 0.0, 1e6]])
    horizon = {}
    for pitch in (-0.1, 0.0, 0.1):
        camera = Camera.mounted(K, IMAGE, HEIGHT, pitch=pitch)
        horizon[pitch] = camera.project(transform(camera.T_cam_road, far_road))[0, 1]
    assert horizon[0.0] == pytest.approx(187.0, abs=0.01)
    assert horizon[0.1] == pytest.approx(187.0 + 710.0 * np.tan(0.1), abs=0.01)
    assert horizon[-0.1] == pytest.approx(187.0 - 710.0 * np.tan(0.1), abs=0.01)


def test_a_camera_that_leans_right_sees_the_road_rise_on_its_right() -> None:
    camera = Camera.mounted(K, IMAGE, HEIGHT, roll=0.1)
    sides = np.array([[-5.0, 0.0, 20.0], [5.0, 0.0, 20.0]])
    left, right = camera.project(transform(camera.T_cam_road, sides))
    assert right[1] < left[1]
    assert camera.road_normal[0] == pytest.approx(np.sin(0.1))


def test_a_roll_turns_the_image_and_not_where_the_camera_looks() -> None:
    camera = Camera.mounted(K, IMAGE, HEIGHT, pitch=0.1, roll=0.3)
    axis_road = camera.T_road_cam[:3, :3] @ [0.0, 0.0, 1.0]
    np.testing.assert_allclose(axis_road, [0.0, -np.sin(0.1), np.cos(0.1)], atol=1e-12)


@given(st.floats(0.3, 4.0), angles, angles)
def test_height_and_normal_do_not_depend_on_where_the_camera_looks(height, pitch, roll) -> None:
    camera = Camera.mounted(K, IMAGE, height, pitch, roll)
    assert camera.height == pytest.approx(height)
    assert np.linalg.norm(camera.road_normal) == pytest.approx(1.0)
    on_the_road = transform(camera.T_cam_road, np.array([[3.0, 0.0, 7.0], [-2.0, 0.0, 30.0]]))
    np.testing.assert_allclose(on_the_road @ camera.road_normal, height, rtol=1e-9)


def test_points_behind_the_camera_project_to_nan() -> None:
    points_cam = np.array([[1.0, 1.0, -5.0], [1.0, 1.0, 0.0], [1.0, 1.0, 10.0]])
    pixels = LEVEL.project(points_cam)
    assert np.isnan(pixels[:2]).all()
    np.testing.assert_allclose(pixels[2], [620.0 + 70.0, 187.0 + 71.0])


@given(st.tuples(st.floats(0, 1241), st.floats(0, 374)), st.floats(0.5, 100.0), angles, angles)
def test_a_ray_at_any_depth_projects_back_to_its_pixel(pixel, depth, pitch, roll) -> None:
    camera = Camera.mounted(K, IMAGE, HEIGHT, pitch, roll)
    rays_cam = camera.rays(np.array([pixel]))
    np.testing.assert_allclose(camera.project(rays_cam * depth), [pixel], atol=1e-8)
    rays_road = camera.rays_road(np.array([pixel]))
    np.testing.assert_allclose(rays_road @ camera.T_cam_road[:3, :3].T, rays_cam, atol=1e-12)


@given(st.tuples(st.floats(0, 1241), st.floats(0, 374)), angles, angles)
def test_a_pixel_touches_the_road_where_the_road_projects_to_it(pixel, pitch, roll) -> None:
    camera = Camera.mounted(K, IMAGE, HEIGHT, pitch, roll)
    touched_cam = camera.touch_road(np.array([pixel]))
    assume(np.isfinite(touched_cam).all())
    assert transform(camera.T_road_cam, touched_cam)[0, 1] == pytest.approx(0.0, abs=1e-8)
    np.testing.assert_allclose(camera.project(touched_cam), [pixel], atol=1e-6)


def test_pixels_counted_from_the_principal_point_are_the_projected_ones() -> None:
    points_road = np.array([[2.0, 0.0, 12.0], [-3.0, -1.5, 30.0]])
    P = PITCHED.P_road_centred
    centred = points_road @ P[:, :3].T + P[:, 3]
    pixels = centred[:, :2] / centred[:, 2:] + K[:2, 2]
    seen = PITCHED.project(transform(PITCHED.T_cam_road, points_road))
    np.testing.assert_allclose(pixels, seen, atol=1e-10)


@pytest.mark.parametrize("camera", [LEVEL, PITCHED], ids=["level", "pitched"])
def test_road_shift_equals_central_differences_of_small_motions(camera: Camera) -> None:
    point_road = np.array([3.0, -0.4, 17.0])
    point_cam = transform(camera.T_cam_road, point_road)
    jacobian = (np.append(point_road, 1.0) @ camera.road_shift).reshape(2, 6)
    step = 1e-6
    for column, twist in enumerate(np.eye(6) * step):
        ends = []
        for sign in (1.0, -1.0):
            R = Rotation.from_rotvec(sign * twist[3:]).as_matrix()
            moved_cam = transform(homogeneous(R, sign * twist[:3]), point_cam)
            ends.append(transform(camera.T_road_cam, moved_cam)[::2])
        numeric = (ends[0] - ends[1]) / (2 * step)
        np.testing.assert_allclose(jacobian[:, column], numeric, atol=1e-7)


def test_boxes_are_clipped_to_the_centres_of_the_border_pixels() -> None:
    boxes = np.array([[-5.0, -5.0, 2000.0, 2000.0], [10.0, 20.0, 30.0, 40.0]])
    np.testing.assert_array_equal(LEVEL.clip_boxes(boxes), [[0, 0, 1241, 374], [10, 20, 30, 40]])
    np.testing.assert_array_equal(boxes[0], [-5.0, -5.0, 2000.0, 2000.0])


def test_boxes_outside_the_image_keep_no_area() -> None:
    outside = np.array([[-50.0, 10, -20, 60], [1300, 10, 1400, 60], [10, 400, 60, 500]])
    sides = np.diff(LEVEL.clip_boxes(outside).reshape(-1, 2, 2), axis=1)[:, 0]
    assert (sides.min(axis=1) == 0.0).all()


def test_no_points_project_to_no_pixels() -> None:
    assert LEVEL.project(np.zeros((0, 3))).shape == (0, 2)
    assert LEVEL.rays(np.zeros((0, 2))).shape == (0, 3)
    assert LEVEL.touch_road(np.zeros((0, 2))).shape == (0, 3)
    assert LEVEL.clip_boxes(np.zeros((0, 4))).shape == (0, 4)


@pytest.mark.parametrize(
    ("bad", "told"),
    [
        ({"K": K.T}, "transposed: the principal point stands in the last row"),
        ({"K": 2.0 * K}, r"scaled: K\[2, 2\] must be 1 and is 2"),
        ({"K": K * [[-1.0], [1.0], [1.0]]}, "mirrored: a focal length is negative"),
        ({"K": np.column_stack((K, [45.0, 0.2, 0.003]))}, r"of shape \(3, 4\).*P\[:, :3\]"),
        ({"K": np.array([[0.56, 0.0, 0.5], [0.0, 1.9, 0.46], [0.0, 0.0, 1.0]])}, "normalised"),
        ({"K": K + np.tri(3, k=-1)}, "not upper triangular"),
        ({"K": [["f", 0, 0]] * 3}, "K: values of type"),
        ({"K": [[700.0, 0.0], [0.0]]}, "K: .*give an array of numbers"),
        ({"image_size": (float("nan"), 375)}, "image width is nan"),
        ({"image_size": (1242.5, 375)}, "image width is 1242.5; give a whole number"),
        ({"image_size": 1242}, "image size 1242: give width and height"),
        ({"image_size": (1242, 375, 3)}, r"\(1242, 375, 3\): give width and height"),
        ({"height": 165.0}, "height 165 m.*at most 100 m; give metres"),
        ({"pitch": -5.0}, "pitch -5, roll 0: give radians"),
        ({"roll": float("inf")}, "roll is inf"),
        ({"K": np.diag([700.0, 0.0, 1.0])}, r"singular.*\[0\.0, 0\.0, 0\.0\]"),
        ({"K": np.full((3, 3), np.nan)}, r"not finite.*nan"),
        ({"height": -0.5}, r"height -0\.5 m"),
        ({"height": 0.0}, r"height 0 m"),
        ({"height": float("nan")}, r"height is nan"),
        ({"image_size": (0, 375)}, r"\(0, 375\)"),
        ({"image_size": (1242, -1)}, r"\(1242, -1\)"),
    ],
)
@pytest.mark.unchecked
def test_what_cannot_be_a_camera_is_refused_with_its_value(bad: dict, told: str) -> None:
    with pytest.raises(BadCalibration, match=told):
        Camera.mounted(**{"K": K, "image_size": IMAGE, "height": HEIGHT, **bad})


@pytest.mark.parametrize(
    ("T_cam_road", "told"),
    [
        (LEVEL.T_cam_road * 2.0, "its last row is 0, 0, 0, 2"),
        (LEVEL.T_cam_road * [[2.0], [2.0], [2.0], [1.0]], "its rotation is scaled by 2"),
        (LEVEL.T_cam_road @ np.diag([1.0, -1.0, 1.0, 1.0]), "mirrored"),
        (LEVEL.T_cam_road.T, "transposed: the translation stands in the last row"),
        (LEVEL.T_road_cam, r"height -1\.65 m.*is it T_road_cam\? Give its inverse"),
        (np.full((4, 4), np.nan), r"entry \[0, 0\] is nan"),
        (np.zeros((4, 4)), "its last row"),
        (np.eye(3), r"its shape is \(3, 3\)"),
    ],
)
@pytest.mark.unchecked
def test_a_mount_that_is_not_rigid_is_named_with_what_is_wrong(T_cam_road, told: str) -> None:
    with pytest.raises(BadCalibration, match=told):
        Camera(K, IMAGE, T_cam_road)


@pytest.mark.unchecked
def test_what_is_like_an_array_becomes_one() -> None:
    """Lists, whole numbers, float32, a mount without its last row."""
    for T in (LEVEL.T_cam_road.tolist(), LEVEL.T_cam_road[:3], LEVEL.T_cam_road.astype("f4")):
        camera = Camera(K.astype(int).tolist(), np.array([1242.0, 375.0]), T)
        assert camera.K.dtype == camera.T_cam_road.dtype == np.float64
        assert camera.image_size == (1242, 375)
        assert camera.height == pytest.approx(HEIGHT)
        np.testing.assert_array_equal(camera.K, K)
        assert camera.clip_boxes(np.zeros((1, 4))).shape == (1, 4)
