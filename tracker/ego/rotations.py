"""Rotation vectors and small motions, in plain numpy."""

import numpy as np
from jaxtyping import Float
from numpy import ndarray as Array

from tracker.geometry import cross_matrix, homogeneous


def rotation_of(vector: Float[Array, "3"]) -> Float[Array, "3 3"]:
    """The rotation by a rotation vector (Rodrigues)."""
    angle = float(np.linalg.norm(vector))
    cross = cross_matrix(vector)
    # sin(a) / a and (1 - cos(a)) / a^2, both finite at 0
    first = float(np.sinc(angle / np.pi))
    second = 0.5 * float(np.sinc(0.5 * angle / np.pi)) ** 2
    return np.eye(3) + first * cross + second * (cross @ cross)


def rotation_vector(R: Float[Array, "3 3"]) -> Float[Array, "3"]:
    """The rotation vector of a rotation by less than half a turn."""
    axis = 0.5 * np.array([R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]])
    sine = float(np.linalg.norm(axis))
    angle = float(np.arctan2(sine, 0.5 * (np.trace(R) - 1.0)))
    return axis * (angle / sine if sine > 1e-12 else 1.0)


def motion_transform(twist: Float[Array, "6"]) -> Float[Array, "4 4"]:
    """The transform with a translation and a rotation vector, each as it is."""
    return homogeneous(rotation_of(twist[3:]), twist[:3])
