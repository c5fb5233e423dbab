"""Sources of the camera's motion: OXTS, files of poses, the images, or none; see `EGO`."""

from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Protocol, runtime_checkable

import numpy as np
from jaxtyping import Float
from numpy import ndarray as Array

from mot_sim.datasets.camera_files import read_poses, reject_leaps
from mot_sim.datasets.images import ImageFolder
from mot_sim.datasets.kitti.calibration import Calibration
from mot_sim.datasets.kitti.places import beside_the_splits, require_file, split_folder
from mot_sim.datasets.recorded import DetectionLog, Motion
from mot_sim.files.text import read_table
from tracker.ego import VisualOdometry, prefetch
from tracker.errors import BadCalibration, BadFile
from tracker.geometry import invert
from tracker.types import Camera

EARTH_RADIUS = 6_378_137.0  # metres, as in the KITTI devkit
MAX_LATITUDE_DEG = 89.0  # the map goes to infinity at the poles

STEP_SECONDS = 0.1  # KITTI's frame rate is 10 Hz

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
# Standard deviations of ORB-SLAM3 over one frame in camera 2: x, y, z in metres, rotations in
# radians. Root mean squares of its difference from OXTS on the ten sequences 0, 2, 3, 4, 5, 7,
# 9, 11, 17, 20: .0174, .0129, .0662 m; 3.7e-4, 7.0e-4, 4.7e-4 rad (.04 of the forward .066 is
# OXTS's own). Its path is 2.6 to 6.5 % too long, on 20 4.9 % too short: errors of scale, alike
# from frame to frame, which no covariance of one frame can say.
ORBSLAM3_MOTION_STD = (0.018, 0.013, 0.066, 4e-4, 7e-4, 5e-4)


@dataclass(frozen=True, eq=False)
class Oxts:
    """Motion from `<root>/<split>/oxts/SSSS.txt`."""

    motion_cov: Float[Array, "6 6"] = field(default_factory=lambda: np.diag(OXTS_MOTION_STD) ** 2)
    """Covariance of the motion over one frame, see `RecordedSequence.motion_cov`."""

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
        Ts_world_imu = read_oxts(path, STEP_SECONDS)
        if len(Ts_world_imu) != frame_count:
            raise BadFile(f"{path}: {len(Ts_world_imu)} lines for {frame_count} frames")
        return Ts_world_imu @ invert(calibration.T_cam_imu)


def oxts_path(root: Path, split: str, name: str) -> Path:
    """Where the OXTS file of a sequence lies."""
    return split_folder(root, split) / "oxts" / f"{name}.txt"


def read_oxts(path: Path, step: float | None = None) -> Float[Array, "n 4 4"]:
    """Ts_world_imu: east, north, up in metres from the first frame (Mercator, KITTI devkit).

    BadFile for values that are none, for blank lines between the others (there is a line per
    frame) and, given the step from frame to frame in seconds, for leaps that no car makes.
    """
    table = read_table(path, OXTS_COLUMNS, line_of_frame=True)
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
    if step is not None:
        reject_leaps(table, Ts_world_imu, step, ("lat", "lon", "alt"))
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


@dataclass(frozen=True, eq=False)
class PoseFiles:
    """Motion from `<root>/odometry/<folder>/SSSS.txt`, its camera taken for camera 2."""

    folder: str
    """Name of the folder in `<root>/odometry`."""
    motion_cov: Float[Array, "6 6"]
    """Covariance of the motion over one frame, see `RecordedSequence.motion_cov`."""
    metric: bool = True
    """Whether positions are in metres, so that leaps are refused."""

    def poses(
        self, root: Path, split: str, name: str, calibration: Calibration, frame_count: int
    ) -> Float[Array, "n 4 4"]:
        """Ts_world_cam; raises DatasetNotFound without the file and BadFile for a bad one."""
        path = beside_the_splits(root, "odometry", self.folder, split) / f"{name}.txt"
        require_file(path, "pose file", "give it, or take another ego-motion: oxts, none")
        return read_poses(path, frame_count, STEP_SECONDS if self.metric else None)


@dataclass(frozen=True, eq=False)
class UnknownEgo:
    """Frames whose T_now_before is None."""

    motion_cov: None = None
    """None, since there is no motion."""

    def poses(
        self, root: Path, split: str, name: str, calibration: Calibration, frame_count: int
    ) -> None:
        """No poses."""
        return


@dataclass(frozen=True, eq=False)
class ImageMotion:
    """Measures the motion in a folder of images while the drive is played.

    Frames without an image coast for a second, see `VisualOdometry.step`; after that, and before
    the first two images, the motion is unknown.
    """

    images: ImageFolder
    """The images of the drive."""
    threaded: bool = True
    """Whether it works one frame ahead, on a thread of its own; the results are the same."""

    def motions(
        self, camera: Camera, log: DetectionLog, frame_count: int, frame_rate: float
    ) -> Iterator[Motion]:
        """T_now_before and its covariance, of every frame of the recording in turn."""
        seen = self._seen(camera, log, frame_count, frame_rate)
        return prefetch(seen) if self.threaded else seen

    def _seen(
        self, camera: Camera, log: DetectionLog, frame_count: int, frame_rate: float
    ) -> Iterator[Motion]:
        odometry = VisualOdometry(camera)
        for frame in range(frame_count):
            image, boxes = self.images.load(frame), log.at(frame).boxes
            yield odometry.step(image, boxes, 1.0 / frame_rate)


@dataclass(frozen=True, eq=False)
class VisualEgo:
    """Motion seen in the images of `<root>/<split>/image_02/SSSS` (visual odometry)."""

    motion_cov: None = None
    """None, since each frame states its own."""

    def poses(
        self, root: Path, split: str, name: str, calibration: Calibration, frame_count: int
    ) -> None:
        """No poses beforehand: see `image_motion`."""
        return

    def image_motion(
        self, images: ImageFolder, image_size: tuple[int, int] | None, frame_count: int
    ) -> ImageMotion:
        """The motion in these images; image_size: what the calibration is for, where known.

        Raises BadCalibration for another size, BadFile for images of more frames than there are.
        """
        folder = images.paths[min(images.paths)].parent
        if image_size is not None and images.image_size != image_size:
            width, height = images.image_size
            raise BadCalibration(
                f"{folder}: images of {width}x{height} pixels, the sequence's calibration is for "
                f"{image_size[0]}x{image_size[1]}; give them at their full size"
            )
        beyond = max(images.paths)
        if beyond >= frame_count:
            raise BadFile(
                f"{images.paths[beyond]}: the sequence has {frame_count} frames, counted from 0; "
                "leave the image out, or number the images from 000000"
            )
        images.warn_of_gaps(frame_count)
        return ImageMotion(images)


@runtime_checkable
class EgoSource(Protocol):
    """What gives the camera's poses; motion_cov is None exactly when `poses` gives None.

    One that sees the motion while the drive is played gives None here, and has an `image_motion`.
    """

    @property
    def motion_cov(self) -> Float[Array, "6 6"] | None:
        """Covariance of the left perturbation of the motion over one frame, see `Frame`."""
        ...

    def poses(
        self, root: Path, split: str, name: str, calibration: Calibration, frame_count: int
    ) -> Float[Array, "n 4 4"] | None:
        """Ts_world_cam of camera 2, in any fixed world."""
        ...


EGO: dict[str, EgoSource] = {
    "oxts": Oxts(),
    "orbslam3": PoseFiles("orbslam3", np.diag(ORBSLAM3_MOTION_STD) ** 2),
    "noisy": PoseFiles("noisy", np.diag(ORBSLAM3_MOTION_STD) ** 2),  # of an episode
    "visual": VisualEgo(),
    "none": UnknownEgo(),
}
