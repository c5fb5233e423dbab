"""Camera poses from the OXTS inertial unit: one line of 30 numbers a frame."""

from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from jaxtyping import Float
from numpy import ndarray as Array

from mot_sim.datasets.kitti.calibration import Calibration
from mot_sim.datasets.kitti.places import require_file, split_folder
from mot_sim.files.text import read_table
from tracker.errors import BadFile
from tracker.geometry import invert

EARTH_RADIUS = 6_378_137.0  # metres, as in the KITTI devkit
MAX_LATITUDE_DEG = 89.0  # degrees; the map goes to infinity at the poles

OXTS_COLUMNS = (
    "lat", "lon", "alt", "roll", "pitch", "yaw", "vn", "ve", "vf", "vl", "vu", "ax", "ay", "az",
    "af", "al", "au", "wx", "wy", "wz", "wf", "wl", "wu", "pos_accuracy", "vel_accuracy",
    "navstat", "numsats", "posmode", "velmode", "orimode",
)  # fmt: skip
OXTS_POSE_COLUMNS = OXTS_COLUMNS[:6]

# Standard deviations over one frame (0.1 s) in camera 2: x, y, z in metres, rotations in radians.
# Measured on the 21 training sequences as positions against integrated velocities and attitudes
# against integrated rates: left-right and up-down .009 to .02 m, rotation 2e-4 to 8e-4 rad, and
# forward .042 m, because OXTS gives the nearest of its 100 Hz samples: +-5 ms at driving speed.
# Standing (12, 16, 17) it is below .003 m and 1e-4 rad.
OXTS_MOTION_STD = (0.015, 0.015, 0.04, 5e-4, 5e-4, 5e-4)


@dataclass(frozen=True, eq=False)
class Oxts:
    """Motion from `<root>/<split>/oxts/SSSS.txt`."""

    motion_cov: Float[Array, "6 6"] = field(default_factory=lambda: np.diag(OXTS_MOTION_STD) ** 2)

    def poses(
        self, root: Path, split: str, name: str, calibration: Calibration, frame_count: int
    ) -> Float[Array, "n 4 4"]:
        """Ts_world_cam of camera 2; the world is (east, north, up) from the first frame.

        Raises DatasetNotFound without the file, BadFile for a bad one, for another number of
        lines than frames and for a calibration that does not say where the OXTS unit stands.
        """
        path = oxts_path(root, split, name)
        require_file(path, "OXTS file", "give oxts/, or take another ego-motion: orbslam3, none")
        if calibration.T_cam_imu is None:
            raise BadFile(
                f"{split_folder(root, split) / 'calib' / name}.txt: lacks R_rect, Tr_velo_cam or "
                "Tr_imu_velo, so OXTS cannot be carried to the camera; take another ego-motion"
            )
        Ts_world_imu = read_oxts(path)
        if len(Ts_world_imu) != frame_count:
            raise BadFile(f"{path}: {len(Ts_world_imu)} lines for {frame_count} frames")
        return Ts_world_imu @ invert(calibration.T_cam_imu)


def oxts_path(root: Path, split: str, name: str) -> Path:
    """Where the OXTS file of a sequence lies."""
    return split_folder(root, split) / "oxts" / f"{name}.txt"


def read_oxts(path: Path) -> Float[Array, "n 4 4"]:
    """Ts_world_imu: east, north, up in metres from the first frame (Mercator, KITTI devkit)."""
    table = read_table(path, OXTS_COLUMNS)
    lat, lon, alt, roll, pitch, yaw = table.finite(OXTS_POSE_COLUMNS).T
    table.reject(np.abs(lat) > MAX_LATITUDE_DEG, "no latitude", ["lat"], "degrees, -89 to 89")
    Ts_world_imu = np.zeros((len(lat), 4, 4))
    Ts_world_imu[:, 3, 3] = 1.0
    if not len(lat):
        return Ts_world_imu
    scale = np.cos(np.radians(lat[0]))
    Ts_world_imu[:, 0, 3] = scale * EARTH_RADIUS * np.radians(lon)
    Ts_world_imu[:, 1, 3] = scale * EARTH_RADIUS * np.log(np.tan(np.radians(90.0 + lat) / 2.0))
    Ts_world_imu[:, 2, 3] = alt
    Ts_world_imu[:, :3, 3] -= Ts_world_imu[0, :3, 3].copy()
    Ts_world_imu[:, :3, :3] = _rotations(roll, pitch, yaw)
    return Ts_world_imu


def _rotations(
    roll: Float[Array, " n"], pitch: Float[Array, " n"], yaw: Float[Array, " n"]
) -> Float[Array, "n 3 3"]:
    """Rz(yaw) Ry(pitch) Rx(roll), element by element."""
    cr, sr = np.cos(roll), np.sin(roll)
    cp, sp = np.cos(pitch), np.sin(pitch)
    cy, sy = np.cos(yaw), np.sin(yaw)
    elements = (
        cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr,
        sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr,
        -sp, cp * sr, cp * cr,
    )  # fmt: skip
    return np.stack(elements, axis=-1).reshape(-1, 3, 3)
