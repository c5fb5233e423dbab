"""Camera poses: in files, a 3x4 camera-to-world matrix a frame, row by row; and on the road."""

from pathlib import Path

import numpy as np
from jaxtyping import Float
from numpy import ndarray as Array

from mot_sim.files.text import read_table
from mot_sim.files.writing import write_lines
from tracker.errors import BadFile
from tracker.geometry import invert

COLUMNS = tuple(f"{name}{row}" for row in "123" for name in ("r1", "r2", "r3", "t"))

# Largest entry of R R^T - 1 that passes for a rotation printed with a few digits.
ROTATION_TOLERANCE = 1e-3


def read_poses(path: Path, frame_count: int | None = None) -> Float[Array, "n 4 4"]:
    """Ts_world_cam of a file with 12 numbers a line, as in KITTI's odometry benchmark.

    The rotations are made orthonormal, which mends what printing cut off. Raises BadFile for
    another number of lines than frames and for what is no rotation.
    """
    table = read_table(path, COLUMNS)
    Ts_world_cam = np.zeros((len(table), 4, 4))
    Ts_world_cam[:, :3] = table.finite(COLUMNS).reshape(-1, 3, 4)
    Ts_world_cam[:, 3, 3] = 1.0
    if frame_count is not None and len(table) != frame_count:
        raise BadFile(f"{path}: {len(table)} poses for {frame_count} frames; give one a frame")
    Rs = Ts_world_cam[:, :3, :3]
    off = np.abs(Rs @ np.swapaxes(Rs, 1, 2) - np.eye(3)).max(axis=(1, 2), initial=0.0)
    bad = (off > ROTATION_TOLERANCE) | (np.linalg.det(Rs) < 0.0)
    table.reject(bad, "the first three columns are no rotation", COLUMNS[:3])
    U, _, Vt = np.linalg.svd(Rs)
    Ts_world_cam[:, :3, :3] = U @ Vt
    return Ts_world_cam


def write_poses(Ts_world_cam: Float[Array, "n 4 4"], path: Path) -> None:
    """Write poses as `read_poses` reads them."""
    rows = Ts_world_cam[:, :3].reshape(-1, 12)
    write_lines(path, (" ".join(f"{value:.9f}" for value in row) for row in rows.tolist()))


def planar_poses(Ts_world_road: Float[Array, "t 4 4"]) -> Float[Array, "t 3"]:
    """x, y, heading in the road plane of the first pose: x its forward, y its right."""
    Ts_first_road = invert(Ts_world_road[0]) @ Ts_world_road
    right, _, forward = Ts_first_road[:, :3, 3].T
    heading = np.unwrap(np.arctan2(Ts_first_road[:, 0, 2], Ts_first_road[:, 2, 2]))
    return np.stack((forward, right, heading), axis=1)
