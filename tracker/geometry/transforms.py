"""Rigid transforms: `T_a_b` moves points from frame b to frame a, `X_a = T_a_b @ X_b`.

(What runs in every frame writes A.dot(B) for A @ B: for a few rows it takes a third of the time.)
"""

import numpy as np
from jaxtyping import Float
from numpy import ndarray as Array

TWO_PI = 2.0 * np.pi


def wrap_angle(angle: Float[Array, "*n"] | float) -> Float[Array, "*n"] | float:
    """The same angle in [-pi, pi)."""
    return (angle + np.pi) % TWO_PI - np.pi


def rotation_x(angle: float) -> Float[Array, "3 3"]:
    """Rotation about +x; of a camera: positive looks up (x right, y down, z forward)."""
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[1.0, 0.0, 0.0], [0.0, c, -s], [0.0, s, c]])


def rotation_y(angle: float) -> Float[Array, "3 3"]:
    """Rotation about +y (down); of a car: its yaw, 0 = along +x."""
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]])


def rotation_z(angle: float) -> Float[Array, "3 3"]:
    """Rotation about +z; of a camera: its roll, positive turns the right side down."""
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])


def homogeneous(
    R: Float[Array, "3 3"] | None = None, t: Float[Array, "3"] | None = None
) -> Float[Array, "4 4"]:
    """The (4, 4) transform of a rotation and a translation, either of them optional."""
    T = np.eye(4)
    if R is not None:
        T[:3, :3] = R
    if t is not None:
        T[:3, 3] = t
    return T


def invert(T: Float[Array, "*n 4 4"]) -> Float[Array, "*n 4 4"]:
    """T_b_a of T_a_b, for rigid transforms (the rotation is transposed, not inverted)."""
    R_inverse = np.swapaxes(T[..., :3, :3], -1, -2)
    inverse = np.zeros_like(T)
    inverse[..., :3, :3] = R_inverse
    inverse[..., :3, 3] = -(R_inverse @ T[..., :3, 3, None])[..., 0]
    inverse[..., 3, 3] = 1.0
    return inverse


def transform(T: Float[Array, "4 4"], points: Float[Array, "*n 3"]) -> Float[Array, "*n 3"]:
    """The points of frame b in frame a, by T_a_b."""
    return points @ T[:3, :3].T + T[:3, 3]


def cross_matrix(vector: Float[Array, "3"]) -> Float[Array, "3 3"]:
    """[v]x, with [v]x w = v x w."""
    x, y, z = vector
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])


def adjoint_of(T: Float[Array, "4 4"]) -> Float[Array, "6 6"]:
    """What carries a small motion (translation, rotation vector) of frame b to frame a."""
    R = T[:3, :3]
    return np.block([[R, cross_matrix(T[:3, 3]) @ R], [np.zeros((3, 3)), R]])


def propagate_covariance(
    A: Float[Array, "k k"], covariances: Float[Array, "n k k"]
) -> Float[Array, "n k k"]:
    """A C A' of symmetric C, for one A: two products of plain matrices, not of n small ones."""
    k = len(A)
    half = covariances.reshape(-1, k).dot(A.T).reshape(-1, k, k)
    return half.transpose(0, 2, 1).reshape(-1, k).dot(A.T).reshape(-1, k, k)
