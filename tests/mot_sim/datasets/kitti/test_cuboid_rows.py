"""KITTI's `h w l x y z rotation_y` against our cuboids."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from mot_sim.datasets.kitti.cuboid_rows import (
    NO_CUBOID,
    NO_CUBOID_DONT_CARE,
    alpha_of,
    cuboids_of_rows,
    rows_of_cuboids,
)
from tracker.geometry import homogeneous, wrap_angle
from tracker.types import Camera

K = np.array([[100.0, 0, 50], [0, 100, 20], [0, 0, 1]])
LEVEL = Camera.mounted(K, (100, 40), 1.65)
ROW = np.array([[1.5, 1.6, 4.0, 1.0, 1.65, 20.0, -1.55]])


def test_a_label_on_the_road_becomes_a_cuboid_on_the_road() -> None:
    T_road_label = LEVEL.T_road_cam @ homogeneous(None, np.array([0.06, 0.0, 0.0]))
    cuboids, known = cuboids_of_rows(ROW, T_road_label)
    assert known.tolist() == [True]
    np.testing.assert_allclose(cuboids.base, [[1.06, 0.0, 20.0]], atol=1e-12)
    assert cuboids.size.tolist() == [[4.0, 1.5, 1.6]]
    assert cuboids.yaw.tolist() == [-1.55]
    np.testing.assert_allclose(rows_of_cuboids(cuboids, T_road_label), ROW, atol=1e-12)


def test_alpha_is_the_yaw_seen_from_the_camera() -> None:
    row = np.array([[1.0, 1, 1, 10.0, 0, 10.0, 1.0]])
    np.testing.assert_allclose(alpha_of(row), [1.0 - np.pi / 4])


def test_a_car_driving_away_from_a_pitched_camera_still_drives_away() -> None:
    pitched = Camera.mounted(K, (100, 40), 1.65, pitch=0.3)
    away = np.array([[1.5, 1.6, 4.0, 0.0, 1.65, 20.0, -np.pi / 2]])
    cuboids, _ = cuboids_of_rows(away, pitched.T_road_cam)
    np.testing.assert_allclose(cuboids.yaw, [-np.pi / 2], atol=1e-12)
    # A camera that looks up sees road points lower than a level one does.
    level, _ = cuboids_of_rows(away, LEVEL.T_road_cam)
    assert cuboids.base[0, 1] < level.base[0, 1]


def test_rows_without_a_size_have_no_cuboid() -> None:
    rows = np.array([NO_CUBOID, NO_CUBOID_DONT_CARE, ROW[0]])
    cuboids, known = cuboids_of_rows(rows, LEVEL.T_road_cam)
    assert known.tolist() == [False, False, True]
    assert np.isnan(cuboids.base[:2]).all()
    assert np.isnan(cuboids.yaw[:2]).all()
    assert np.isnan(rows_of_cuboids(cuboids, LEVEL.T_road_cam)[:2]).all()


def test_no_rows_are_no_cuboids() -> None:
    cuboids, known = cuboids_of_rows(np.zeros((0, 7)), LEVEL.T_road_cam)
    assert len(cuboids) == len(known) == 0
    assert rows_of_cuboids(cuboids, LEVEL.T_road_cam).shape == (0, 7)


@given(
    st.floats(-0.5, 0.5), st.floats(-0.5, 0.5), st.floats(-10.0, 10.0), st.floats(-30, 30),
    st.floats(1, 80),
)  # fmt: skip
def test_reading_inverts_writing_for_every_mounting(
    pitch: float, roll: float, yaw: float, x: float, z: float
) -> None:
    T_road_label = Camera.mounted(K, (100, 40), 1.65, pitch, roll).T_road_cam
    row = np.array([[1.5, 1.6, 4.0, x, 1.65, z, yaw]])
    again = rows_of_cuboids(cuboids_of_rows(row, T_road_label)[0], T_road_label)
    np.testing.assert_allclose(again[:, :6], row[:, :6], atol=1e-9)
    assert abs(wrap_angle(float(again[0, 6] - yaw))) < 1e-9
