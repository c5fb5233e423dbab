"""Files of a camera: camera.toml, and its poses as one 3x4 camera-to-world matrix per line."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from jaxtyping import Float
from numpy import ndarray as Array

from mot_sim.files.documents import read_toml
from mot_sim.files.text import read_table
from mot_sim.files.writing import write_lines
from tracker.errors import BadCalibration, BadConfig, BadFile, DatasetNotFound, UnknownName
from tracker.geometry import invert
from tracker.types import Camera

INTRINSIC_KEYS = ("fx", "fy", "cx", "cy")
REQUIRED_KEYS = ("image_width", "image_height", "camera_height")
OPTIONAL_KEYS = {"pitch_deg": 0.0, "roll_deg": 0.0, "frame_rate": 10.0}
# Above all numbers of a camera file; NaN and infinity are not smaller either.
MAX_CAMERA_NUMBER = 1e12
CAMERA_KEYS_HELP = (
    "K = [[fx, 0, cx], [0, fy, cy], [0, 0, 1]] or fx, fy, cx, cy; image_width and image_height "
    "in pixels; camera_height in metres"
)
POSE_COLUMNS = tuple(f"{name}{row}" for row in "123" for name in ("r1", "r2", "r3", "t"))
# Largest entry of R R^T - 1 that passes for a rotation printed with a few digits.
ROTATION_TOLERANCE = 1e-3


@dataclass(frozen=True, eq=False)
class CameraFile:
    """The content of a camera.toml: the camera, and the frame rate in Hz."""

    camera: Camera
    frame_rate: float


def read_camera(path: Path) -> CameraFile:
    """The camera in a TOML file.

    Keys: `K` (3x3) or `fx fy cx cy`; `image_width`, `image_height` in pixels; `camera_height`
    above the road in metres; and, if they are not 0, 0 and 10, `pitch_deg` (positive looks
    up), `roll_deg` (positive leans right), `frame_rate` in Hz. Raises DatasetNotFound without
    the file, BadFile for what is not TOML, BadConfig for missing, unknown and wrong values,
    BadCalibration for a camera that cannot be.
    """
    if not path.is_file():
        raise DatasetNotFound(f"{path}: no camera file; write one with {CAMERA_KEYS_HELP}")
    values = read_toml(path)
    known = ("K", *INTRINSIC_KEYS, *REQUIRED_KEYS, *OPTIONAL_KEYS)
    for key in values:
        if key not in known:
            raise BadConfig(f"{path}: {UnknownName.of('key', key, known)}")
    K = _intrinsics(path, values)
    width, height = (_number(path, values, key) for key in REQUIRED_KEYS[:2])
    if width % 1.0 or height % 1.0:
        raise BadConfig(f"{path}: image_width {width} and image_height {height} are whole pixels")
    pitch, roll, frame_rate = (_number(path, OPTIONAL_KEYS | values, key) for key in OPTIONAL_KEYS)
    if not frame_rate > 0.0:
        raise BadConfig(f"{path}: frame_rate is {frame_rate:g}; give frames a second above 0")
    try:
        camera = Camera.mounted(
            K,
            (int(width), int(height)),
            _number(path, values, "camera_height"),
            float(np.radians(pitch)),
            float(np.radians(roll)),
        )
    except BadCalibration as error:
        raise BadCalibration(f"{path}: {error}") from None
    return CameraFile(camera, frame_rate)


def _intrinsics(path: Path, values: Mapping[str, object]) -> Float[Array, "3 3"]:
    given = [key for key in INTRINSIC_KEYS if key in values]
    if "K" in values:
        if given:
            raise BadConfig(f"{path}: K and {given[0]} both say the intrinsics; keep one of them")
        rows = values["K"]
        if (
            not isinstance(rows, list)
            or [len(r) if isinstance(r, list) else 0 for r in rows] != [3] * 3
        ):
            raise BadConfig(f"{path}: K is {rows!r}; give three rows of three numbers")
        entries = {
            f"K[{i}][{j}]": value for i, row in enumerate(rows) for j, value in enumerate(row)
        }
        return np.array([_number(path, entries, key) for key in entries]).reshape(3, 3)
    fx, fy, cx, cy = (_number(path, values, key) for key in INTRINSIC_KEYS)
    return np.array([[fx, 0.0, cx], [0.0, fy, cy], [0.0, 0.0, 1.0]])


def _number(path: Path, values: Mapping[str, object], key: str) -> float:
    if key not in values:
        raise BadConfig(f"{path}: no {key}; a camera file holds {CAMERA_KEYS_HELP}")
    value = values[key]
    if (
        isinstance(value, bool)
        or not isinstance(value, int | float)
        or not abs(value) < MAX_CAMERA_NUMBER
    ):
        raise BadConfig(f"{path}: {key} is {value!r}; give a finite number")
    return float(value)


def read_poses(path: Path, frame_count: int | None = None) -> Float[Array, "n 4 4"]:
    """Ts_world_cam of a file with 12 numbers a line, as in KITTI's odometry benchmark.

    The rotations are made orthonormal, which mends what printing cut off. Raises BadFile for
    another number of lines than frames and for what is no rotation.
    """
    table = read_table(path, POSE_COLUMNS)
    Ts_world_cam = np.zeros((len(table), 4, 4))
    Ts_world_cam[:, :3] = table.finite(POSE_COLUMNS).reshape(-1, 3, 4)
    Ts_world_cam[:, 3, 3] = 1.0
    if frame_count is not None and len(table) != frame_count:
        raise BadFile(f"{path}: {len(table)} poses for {frame_count} frames; give one a frame")
    Rs = Ts_world_cam[:, :3, :3]
    off = np.abs(Rs @ np.swapaxes(Rs, 1, 2) - np.eye(3)).max(axis=(1, 2), initial=0.0)
    bad = (off > ROTATION_TOLERANCE) | (np.linalg.det(Rs) < 0.0)
    table.reject(bad, "the first three columns are no rotation", POSE_COLUMNS[:3])
    U, _, Vt = np.linalg.svd(Rs)
    Ts_world_cam[:, :3, :3] = U @ Vt
    return Ts_world_cam


def planar_poses(Ts_world_road: Float[Array, "t 4 4"]) -> Float[Array, "t 3"]:
    """x, y, heading in the road plane of the first pose: x its forward, y its right."""
    Ts_first_road = invert(Ts_world_road[0]) @ Ts_world_road
    right, _, forward = Ts_first_road[:, :3, 3].T
    heading = np.unwrap(np.arctan2(Ts_first_road[:, 0, 2], Ts_first_road[:, 2, 2]))
    return np.stack((forward, right, heading), axis=1)


def write_poses(Ts_world_cam: Float[Array, "n 4 4"], path: Path) -> None:
    """Write poses as `read_poses` reads them."""
    rows = Ts_world_cam[:, :3].reshape(-1, 12)
    write_lines(path, (" ".join(f"{value:.9f}" for value in row) for row in rows.tolist()))
