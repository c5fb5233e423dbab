"""KITTI's calibration files, in both dialects, and the frames between its sensors.

The colour images, and so the boxes and K, belong to camera 2; labels (x y z, rotation_y) belong
to camera 0, 6 cm to its right. Everything outside this folder lives in camera 2.
"""

from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from jaxtyping import Float
from numpy import ndarray as Array

from mot_sim.files.text import MAX_NUMBER, read_text
from mot_sim.files.writing import write_lines
from tracker.errors import BadCalibration, BadFile, DatasetNotFound
from tracker.geometry import homogeneous, intrinsics_fault, rigid_fault
from tracker.types import Camera

# Metres from the road to the cameras of KITTI's car (Geiger et al., "Vision meets robotics").
CAMERA_HEIGHT_METRES = 1.65

# The tracking devkit's names and the later ones, without the colon that only one dialect has.
KEY_ALIASES = {
    "R0_rect": "R_rect",
    "Tr_velo_to_cam": "Tr_velo_cam",
    "Tr_imu_to_velo": "Tr_imu_velo",
}
VALUE_COUNTS = {"P2": 12, "R_rect": 9, "Tr_velo_cam": 12, "Tr_imu_velo": 12}


@dataclass(frozen=True, eq=False)
class Calibration:
    """Camera 2 of a KITTI sequence and where the other sensors stand."""

    K: Float[Array, "3 3"]
    """Intrinsics, px: P2[:, :3]."""
    T_cam_label: Float[Array, "4 4"] = field(default_factory=lambda: np.eye(4))
    """From the frame of the labels (camera 0, rectified) to camera 2: a translation by inv(K) P2[:,
    3]."""
    T_cam_imu: Float[Array, "4 4"] | None = None
    """From the OXTS unit to camera 2; None where the file does not hold R_rect, Tr_velo_cam and
    Tr_imu_velo."""

    def camera(
        self,
        image_size: tuple[int, int],
        height: float = CAMERA_HEIGHT_METRES,
        pitch: float = 0.0,
        roll: float = 0.0,
    ) -> Camera:
        """Camera 2 above the road, level unless told; pitch > 0 looks up, radians."""
        return Camera.mounted(self.K, image_size, height, pitch, roll)


def read_calibration(path: Path) -> Calibration:
    """The calibration in `calib/SSSS.txt`, in either dialect.

    Raises DatasetNotFound without the file, BadFile for a line that is no row of numbers and
    for a missing P2, BadCalibration for a P2 without a K and for mounts that are not rigid.
    """
    if not path.is_file():
        raise DatasetNotFound(f"{path}: no calibration; a KITTI tree has <root>/training/calib")
    rows = _rows(path)
    if "P2" not in rows:
        raise BadFile(f"{path}: no P2 (the left colour camera); found: {', '.join(rows) or 'none'}")
    P2 = rows["P2"].reshape(3, 4)
    K = P2[:, :3]
    fault = intrinsics_fault(K)
    if fault is not None:
        raise BadCalibration(f"{path}: K = P2[:, :3] is {fault}: {K.tolist()}; mend P2")
    T_cam_label = homogeneous(None, np.linalg.solve(K, P2[:, 3]))
    if not {"R_rect", "Tr_velo_cam", "Tr_imu_velo"} <= rows.keys():
        return Calibration(K, T_cam_label)
    T_label_imu = homogeneous(rows["R_rect"].reshape(3, 3))
    _require_rigid(path, "R_rect", T_label_imu)
    for key in ("Tr_velo_cam", "Tr_imu_velo"):
        T = np.vstack([rows[key].reshape(3, 4), [0.0, 0.0, 0.0, 1.0]])
        _require_rigid(path, key, T)
        T_label_imu = T_label_imu @ T
    return Calibration(K, T_cam_label, T_cam_label @ T_label_imu)


def write_calibration(calibration: Calibration, path: Path) -> None:
    """Write a calibration file in the tracking devkit's dialect; reading gives the same back.

    T_cam_imu goes into Tr_velo_cam: as there is no laser scanner, it is put at the OXTS unit.
    """
    P2 = np.hstack([calibration.K, calibration.K @ calibration.T_cam_label[:3, 3:]])
    rows = {f"P{camera}:": P2 for camera in range(4)} | {"R_rect": np.eye(3)}
    if calibration.T_cam_imu is not None:
        T_label_imu = calibration.T_cam_imu.copy()
        T_label_imu[:3, 3] -= calibration.T_cam_label[:3, 3]
        rows |= {"Tr_velo_cam": T_label_imu[:3], "Tr_imu_velo": np.eye(4)[:3]}
    write_lines(
        path,
        [f"{key} {' '.join(f'{value:.12e}' for value in row.flat)}" for key, row in rows.items()],
    )


def _rows(path: Path) -> dict[str, Float[Array, " k"]]:
    rows = {}
    for number, line in enumerate(read_text(path).split("\n"), 1):
        key, *values = line.split() or [""]
        name = KEY_ALIASES.get(key.rstrip(":"), key.rstrip(":"))
        if name not in VALUE_COUNTS:
            continue
        try:
            row = np.array([float(value) for value in values])
        except ValueError as error:
            raise BadFile(f"{path}:{number}: {key}: {error}; mend the number") from None
        finite = np.abs(row) <= MAX_NUMBER
        if len(row) != VALUE_COUNTS[name] or not finite.all():
            raise BadFile(
                f"{path}:{number}: {key} has {len(row)} values, {finite.sum()} of them finite; "
                f"{VALUE_COUNTS[name]} finite ones belong here, below 1e18"
            )
        rows[name] = row
    return rows


def _require_rigid(path: Path, key: str, T: Float[Array, "4 4"]) -> None:
    fault = rigid_fault(T)
    if fault is not None:
        raise BadCalibration(f"{path}: {key}: {fault}")
