"""Transforms: the convention `X_a = T_a_b @ X_b`, inverses, and wrapping."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from tracker.geometry import (
    homogeneous,
    invert,
    propagate_covariance,
    rotation_x,
    rotation_y,
    rotation_z,
    transform,
    wrap_angle,
)

angles = st.floats(-20.0, 20.0)


def test_neighbouring_transforms_chain() -> None:
    T_a_b = homogeneous(rotation_y(0.3), np.array([1.0, 2.0, 3.0]))
    T_b_c = homogeneous(rotation_x(-0.2), np.array([0.5, 0.0, -1.0]))
    points_c = np.array([[1.0, 0.0, 2.0], [0.0, 3.0, 1.0]])
    by_steps = transform(T_a_b, transform(T_b_c, points_c))
    np.testing.assert_allclose(transform(T_a_b @ T_b_c, points_c), by_steps, atol=1e-14)


def test_yaw_of_a_quarter_turn_faces_away_from_the_camera_at_minus_90_degrees() -> None:
    facing = rotation_y(-np.pi / 2) @ np.array([1.0, 0.0, 0.0])
    np.testing.assert_allclose(facing, [0.0, 0.0, 1.0], atol=1e-15)


@pytest.mark.parametrize(
    ("axis", "ours"), [("x", rotation_x), ("y", rotation_y), ("z", rotation_z)]
)
def test_rotations_equal_scipys(axis: str, ours) -> None:
    np.testing.assert_allclose(ours(0.7), Rotation.from_euler(axis, 0.7).as_matrix(), atol=1e-15)


@given(angles, angles, st.floats(-100, 100), st.floats(-100, 100))
def test_a_transform_and_its_inverse_cancel(yaw: float, pitch: float, x: float, z: float) -> None:
    T = homogeneous(rotation_y(yaw) @ rotation_x(pitch), np.array([x, 1.0, z]))
    np.testing.assert_allclose(invert(T) @ T, np.eye(4), atol=1e-11)


def test_inverting_many_transforms_inverts_each() -> None:
    Ts = np.stack([homogeneous(rotation_y(a), np.array([a, 0.0, 1.0])) for a in (0.1, 0.2, 0.3)])
    np.testing.assert_allclose(invert(Ts) @ Ts, np.tile(np.eye(4), (3, 1, 1)), atol=1e-14)


@given(angles)
def test_wrapped_angles_are_the_same_direction_within_a_turn(angle: float) -> None:
    wrapped = wrap_angle(angle)
    assert -np.pi <= wrapped < np.pi
    assert np.cos(wrapped) == pytest.approx(np.cos(angle), abs=1e-9)
    assert np.sin(wrapped) == pytest.approx(np.sin(angle), abs=1e-9)


def test_pi_wraps_to_minus_pi() -> None:
    assert wrap_angle(np.pi) == -np.pi


def test_no_points_transform_to_no_points() -> None:
    assert transform(np.eye(4), np.zeros((0, 3))).shape == (0, 3)


@pytest.mark.parametrize(("n", "k"), [(0, 4), (1, 4), (5, 4), (3, 2)])
def test_covariances_are_spread_as_by_products_of_three(n: int, k: int) -> None:
    rng = np.random.default_rng(n)
    A, half = rng.normal(size=(k, k)), rng.normal(size=(n, k, k))
    covariances = half @ half.transpose(0, 2, 1)
    np.testing.assert_allclose(
        propagate_covariance(A, covariances), A @ covariances @ A.T, atol=1e-12
    )
