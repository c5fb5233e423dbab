"""Cuboids: corners and footprints of cars on the road."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tracker.geometry import polygon_area, rotation_y
from tracker.types import Cuboids

SIZE = np.array([[4.0, 1.5, 2.0]])
places = st.floats(-50, 50)
sides = st.floats(0.1, 12.0)


def cuboid(yaw: float, x: float = 0.0, z: float = 0.0, size: np.ndarray = SIZE) -> Cuboids:
    return Cuboids(np.array([[x, 0.0, z]]), np.array([yaw]), size)


def test_a_car_along_road_x_has_its_left_side_away_from_the_camera() -> None:
    corners = cuboid(0.0, x=10.0, z=20.0).corners()[0]
    bottom = [[12, 0, 21], [8, 0, 21], [8, 0, 19], [12, 0, 19]]
    np.testing.assert_allclose(corners[:4], bottom, atol=1e-14)


def test_a_car_that_drives_away_has_its_left_side_on_the_left() -> None:
    corners = cuboid(-np.pi / 2, x=10.0, z=20.0).corners()[0]
    front_left, rear_left, rear_right, front_right = corners[:4]
    np.testing.assert_allclose(front_left, [9, 0, 22], atol=1e-14)
    np.testing.assert_allclose(rear_left, [9, 0, 18], atol=1e-14)
    np.testing.assert_allclose(rear_right, [11, 0, 18], atol=1e-14)
    np.testing.assert_allclose(front_right, [11, 0, 22], atol=1e-14)


def test_the_roof_is_one_height_above_the_bottom_which_is_up_and_so_minus_y() -> None:
    corners = cuboid(0.7, 3.0, 9.0).corners()[0]
    np.testing.assert_allclose(corners[4:], corners[:4] - [0.0, 1.5, 0.0], atol=1e-14)


@given(st.floats(-7, 7), places, places, sides, sides)
def test_the_footprint_has_the_area_of_length_times_width(yaw, x, z, length, width) -> None:
    footprint = cuboid(yaw, x, z, np.array([[length, 1.5, width]])).footprint()
    assert polygon_area(footprint)[0] == pytest.approx(length * width, rel=1e-6)
    np.testing.assert_allclose(footprint.mean(axis=1), [[x, z]], atol=1e-9)


@given(st.floats(-7, 7), places, places)
def test_corners_are_the_rotated_corners_of_the_object_frame(yaw, x, z) -> None:
    object_corners = np.array([[sx * 2.0, 0.0, sz * 1.0] for sx in (1, -1) for sz in (1, -1)])
    expected = object_corners @ rotation_y(yaw).T + [x, 0.0, z]
    ours = cuboid(yaw, x, z).corners()[0, :4]
    for corner in expected:
        assert np.abs(ours - corner).max(axis=1).min() < 1e-9


@given(st.floats(-7, 7))
def test_footprints_turn_in_one_sense(yaw) -> None:
    polygon = cuboid(yaw).footprint()[0]
    edges = np.roll(polygon, -1, axis=0) - polygon
    following = np.roll(edges, -1, axis=0)
    turns = edges[:, 0] * following[:, 1] - edges[:, 1] * following[:, 0]
    assert (turns > 0).all()


def test_no_cuboid_has_no_corner() -> None:
    assert Cuboids.empty().corners().shape == (0, 8, 3)
    assert Cuboids.empty().footprint().shape == (0, 4, 2)
