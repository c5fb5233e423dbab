"""Rotation vectors and small motions against OpenCV, and back."""

import cv2
import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from tracker.ego.rotations import motion_transform, rotation_of, rotation_vector
from tracker.geometry import adjoint_of, cross_matrix

VECTORS = arrays(float, 3, elements=st.floats(-1.7, 1.7))
TWISTS = arrays(float, 6, elements=st.floats(-1.0, 1.0))


def test_a_quarter_turn_about_down_takes_forward_to_the_right() -> None:
    R = rotation_of(np.array([0.0, np.pi / 2, 0.0]))
    np.testing.assert_allclose(R @ [0.0, 0.0, 1.0], [1.0, 0.0, 0.0], atol=1e-12)
    np.testing.assert_array_equal(rotation_of(np.zeros(3)), np.eye(3))
    np.testing.assert_array_equal(rotation_vector(np.eye(3)), np.zeros(3))


@given(VECTORS)
def test_a_rotation_vector_comes_back(vector: np.ndarray) -> None:
    np.testing.assert_allclose(rotation_of(vector), cv2.Rodrigues(vector)[0], atol=1e-9)
    np.testing.assert_allclose(rotation_vector(rotation_of(vector)), vector, atol=1e-7)


@given(VECTORS, VECTORS)
def test_the_cross_matrix_is_the_cross_product(v: np.ndarray, w: np.ndarray) -> None:
    np.testing.assert_allclose(cross_matrix(v) @ w, np.cross(v, w), atol=1e-12)


@given(TWISTS, TWISTS)
def test_the_adjoint_carries_a_small_motion_over(twist: np.ndarray, small: np.ndarray) -> None:
    T, eps = motion_transform(twist), 1e-6
    carried = T @ motion_transform(eps * small) @ np.linalg.inv(T)
    np.testing.assert_allclose(carried[:3, 3] / eps, (adjoint_of(T) @ small)[:3], atol=1e-4)
    np.testing.assert_allclose(
        rotation_vector(carried[:3, :3]) / eps, (adjoint_of(T) @ small)[3:], atol=1e-4
    )
