"""KITTI's `h w l x y z rotation_y` and our cuboids in the road frame; the only place of both.

The frame of the labels is camera 0. T_road_label carries its points to the road frame. In a
pitched or rolled camera KITTI's rotation_y is the yaw projected on the camera's +y.
"""

import numpy as np
from jaxtyping import Bool, Float
from numpy import ndarray as Array

from tracker.geometry import invert, transform, wrap_angle
from tracker.types import Cuboids

# What KITTI writes where there is no cuboid: in results, and in DontCare labels.
NO_CUBOID = (-1.0, -1.0, -1.0, -1000.0, -1000.0, -1000.0, -10.0)
NO_CUBOID_DONT_CARE = (-1000.0, -1000.0, -1000.0, -10.0, -1.0, -1.0, -1.0)
NO_ALPHA = -10.0


def cuboids_of_rows(
    rows: Float[Array, "n 7"], T_road_label: Float[Array, "4 4"]
) -> tuple[Cuboids, Bool[Array, " n"]]:
    """The cuboids of `h w l x y z rotation_y`, and which rows have one.

    Rows without a positive size have none; their cuboids are NaN.
    """
    known = np.asarray((rows[:, :3] > 0.0).all(axis=1))
    base = transform(T_road_label, rows[:, 3:6])
    rotation_y = rows[:, 6]
    facing = np.linalg.solve(_plane_turn(T_road_label), _facing(rotation_y)).T
    yaw = rotation_y + wrap_angle(np.arctan2(-facing[:, 1], facing[:, 0]) - rotation_y)
    size = rows[:, [2, 0, 1]]
    absent = ~known
    base[absent], size[absent], yaw[absent] = np.nan, np.nan, np.nan
    return Cuboids(base, yaw, size), known


def rows_of_cuboids(cuboids: Cuboids, T_road_label: Float[Array, "4 4"]) -> Float[Array, "n 7"]:
    """`h w l x y z rotation_y` of cuboids: the inverse of `cuboids_of_rows`. NaN stays NaN."""
    facing = (_plane_turn(T_road_label) @ _facing(cuboids.yaw)).T
    rotation_y = cuboids.yaw + wrap_angle(np.arctan2(-facing[:, 1], facing[:, 0]) - cuboids.yaw)
    base_label = transform(invert(T_road_label), cuboids.base)
    return np.column_stack([cuboids.size[:, [1, 2, 0]], base_label, rotation_y])


def alpha_of(rows: Float[Array, "n 7"]) -> Float[Array, " n"]:
    """The observation angle of `h w l x y z rotation_y`: rotation_y less the viewing azimuth."""
    return np.asarray(wrap_angle(rows[:, 6] - np.arctan2(rows[:, 3], rows[:, 5])))


def _facing(yaw: Float[Array, " n"]) -> Float[Array, "2 n"]:
    """x and z of where a car of this yaw faces."""
    return np.stack([np.cos(yaw), -np.sin(yaw)])


def _plane_turn(T_road_label: Float[Array, "4 4"]) -> Float[Array, "2 2"]:
    """x and z of a road direction, seen in the labels' frame."""
    R_label_road = T_road_label[:3, :3].T
    return R_label_road[np.ix_([0, 2], [0, 2])]
