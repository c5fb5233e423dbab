"""Files of a camera: camera.toml, and its poses as one 3x4 camera-to-world matrix per line."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from jaxtyping import Float
from numpy import ndarray as Array

from mot_sim.datasets.distortion import COUNTS, Distortion
from mot_sim.files.documents import read_toml
from mot_sim.files.text import TextTable, read_table
from mot_sim.files.writing import write_lines
from tracker.errors import BadCalibration, BadConfig, BadFile, DatasetNotFound, UnknownName
from tracker.geometry import invert, rigid_fault
from tracker.types import Camera, max_step

INTRINSIC_KEYS = ("fx", "fy", "cx", "cy")
REQUIRED_KEYS = ("image_width", "image_height", "camera_height")
OPTIONAL_KEYS = {"pitch_deg": 0.0, "roll_deg": 0.0, "frame_rate": 10.0}
DISTORTION_KEY = "distortion"
# Above all numbers of a camera file; NaN and infinity are not smaller either.
MAX_CAMERA_NUMBER = 1e12
CAMERA_KEYS_HELP = (
    "K = [[fx, 0, cx], [0, fy, cy], [0, 0, 1]] or fx, fy, cx, cy; image_width and image_height "
    "in pixels; camera_height in metres"
)
# As they stand in a line: the matrix row by row.
POSE_COLUMNS = (
    *("r11", "r12", "r13", "tx"),
    *("r21", "r22", "r23", "ty"),
    *("r31", "r32", "r33", "tz"),
)
# For positions in units of their own.
SCALE_CURE = "Of a scale that is not known: --ego-scale auto"


@dataclass(frozen=True, eq=False)
class CameraFile:
    """The content of a camera.toml."""

    camera: Camera
    """The camera: intrinsics, and where it stands above the road."""
    frame_rate: float
    """Frames per second, Hz, > 0."""
    distortion: Distortion | None = None
    """The lens; None: none, the camera is a pinhole."""


def read_camera(path: Path, height: float | None = None) -> CameraFile:
    """The camera in a TOML file.

    height: metres, where the file states none; None: it must.

    Keys: `K` (3x3) or `fx fy cx cy`; `image_width`, `image_height` in pixels; `camera_height`
    above the road in metres; and, if they are not 0, 0 and 10, `pitch_deg` (positive looks
    up), `roll_deg` (positive leans right), `frame_rate` in Hz; and `distortion`, OpenCV's k1, k2,
    p1, p2, k3 (or 8 numbers), which bends the pixels of boxes. Raises DatasetNotFound without
    the file, BadFile for what is not TOML, BadConfig for missing, unknown and wrong values,
    BadCalibration for a camera that cannot be.
    """
    if not path.is_file():
        raise DatasetNotFound(f"{path}: no camera file; write one with {CAMERA_KEYS_HELP}")
    values = read_toml(path)
    default = {} if height is None else {"camera_height": height}
    known = ("K", *INTRINSIC_KEYS, *REQUIRED_KEYS, *OPTIONAL_KEYS, DISTORTION_KEY)
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
            _number(path, default | values, "camera_height"),
            float(np.radians(pitch)),
            float(np.radians(roll)),
        )
        bent = _coefficients(path, values)
        distortion = None if bent is None else Distortion(camera, bent)
    except BadCalibration as error:
        raise BadCalibration(f"{path}: {error}") from None
    return CameraFile(camera, frame_rate, distortion)


def camera_lines(described: CameraFile) -> list[str]:
    """The lines of a camera file, as `read_camera` reads them; T_cam_road is one of a mount."""
    camera = described.camera
    R_road_cam = camera.T_road_cam[:3, :3]
    pitch = np.degrees(np.arctan2(-R_road_cam[1, 2], R_road_cam[2, 2]))
    roll = np.degrees(np.arctan2(-R_road_cam[0, 1], R_road_cam[0, 0]))
    values = {
        "K": camera.K.tolist(),
        "image_width": camera.image_size[0],
        "image_height": camera.image_size[1],
        "camera_height": camera.height,
        "pitch_deg": float(pitch),
        "roll_deg": float(roll),
        "frame_rate": described.frame_rate,
    }
    if described.distortion is not None:
        values[DISTORTION_KEY] = described.distortion.coefficients.tolist()
    return [f"{key} = {value!r}" for key, value in values.items()]


def _coefficients(path: Path, values: Mapping[str, object]) -> Float[Array, " c"] | None:
    """The coefficients of the lens; None without, and where all are 0."""
    given = values.get(DISTORTION_KEY, [])
    if not isinstance(given, list) or (given and len(given) not in COUNTS):
        raise BadConfig(
            f"{path}: {DISTORTION_KEY} is {given!r}; give a list of {', '.join(map(str, COUNTS))} "
            "numbers in OpenCV's order, k1, k2, p1, p2, k3, k4, k5, k6"
        )
    entries = {f"{DISTORTION_KEY}[{index}]": value for index, value in enumerate(given)}
    numbers = np.array([_number(path, entries, key) for key in entries])
    return numbers if numbers.any() else None


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


def read_poses(
    path: Path, frame_count: int | None = None, step: float | None = None
) -> Float[Array, "n 4 4"]:
    """Ts_world_cam of a file with 12 numbers a line, as in KITTI's odometry benchmark.

    The rotations are made orthonormal, which mends what printing cut off. Raises BadFile for
    another number of lines than frames, for blank lines between them, for what is no rotation
    and, given the step from frame to frame in seconds, for leaps that no camera makes.
    """
    table = read_table(path, lambda fields: _pose_columns(path, fields), line_of_frame=True)
    if frame_count is not None and len(table) != frame_count:
        raise BadFile(f"{path}: {len(table)} poses for {frame_count} frames; give one a frame")
    Ts_world_cam = rigid_poses(table)
    if step is not None:
        reject_leaps(table, Ts_world_cam, step, ("tx", "ty", "tz"))
    return Ts_world_cam


def rigid_poses(table: TextTable) -> Float[Array, "n 4 4"]:
    """The poses in POSE_COLUMNS, their rotations made orthonormal; BadFile for what is none."""
    Ts_world_cam = np.zeros((len(table), 4, 4))
    Ts_world_cam[:, :3] = table.finite(POSE_COLUMNS).reshape(-1, 3, 4)
    Ts_world_cam[:, 3, 3] = 1.0
    for row, pose in enumerate(Ts_world_cam):
        fault = rigid_fault(pose)
        if fault is not None:
            raise BadFile(
                f"{table.place(row)}: {fault}; a line is a camera-to-world matrix, "
                f"{' '.join(POSE_COLUMNS)}"
            )
    U, _, Vt = np.linalg.svd(Ts_world_cam[:, :3, :3])
    Ts_world_cam[:, :3, :3] = U @ Vt
    return Ts_world_cam


def _pose_columns(path: Path, fields: list[str]) -> tuple[str, ...]:
    """The columns of a file of poses; BadFile for other formats that are known."""
    others = {
        8: "a trajectory of TUM's (time, tx ty tz, quaternion)?",
        16: "4x4 matrices? Leave out their last row, 0 0 0 1.",
        7: "positions and quaternions?",
    }
    if len(fields) in others:
        raise BadFile(
            f"{path}:1: {len(fields)} values: {others[len(fields)]} A line is the camera-to-world "
            f"matrix of a frame, row by row: {' '.join(POSE_COLUMNS)}"
        )
    return POSE_COLUMNS


def reject_leaps(
    table: TextTable, Ts_world: Float[Array, "n 4 4"], step: float, columns: tuple[str, ...]
) -> None:
    """BadFile for a pose that is farther from the one before than any camera moves in a step."""
    metres = np.zeros(len(table))
    metres[1:] = np.linalg.norm(np.diff(Ts_world[:, :3, 3], axis=0), axis=1)
    leaps = metres > max_step(step)
    if leaps.any():
        first = int(np.flatnonzero(leaps)[0])
        what = f"a leap of {metres[first]:.4g} m from the frame before, {step:.3g} s earlier"
        cure = (
            "are the positions in metres, one line per frame, all of one map without a jump? "
            + SCALE_CURE
        )
        table.reject(leaps, what, columns, cure)


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
