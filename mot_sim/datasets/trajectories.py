"""Trajectories of a camera: a pose a frame, or poses with times, between which is interpolated."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from jaxtyping import Float
from numpy import ndarray as Array

from mot_sim.datasets.camera_files import (
    POSE_COLUMNS,
    SCALE_CURE,
    read_poses,
    rigid_poses,
    write_poses,
)
from mot_sim.files.text import read_table, read_text
from mot_sim.files.writing import write_lines
from tracker.errors import BadFile
from tracker.types import max_step

TUM_COLUMNS = ("time", "tx", "ty", "tz", "qx", "qy", "qz", "qw")
TIMED_COLUMNS = ("time", *POSE_COLUMNS)
# A quaternion may be off unit length by this much: what printing cuts off.
MAX_LENGTH_ERROR = 1e-2
# Frames may lie so many frame steps before the first pose or after the last one.
MAX_BEYOND = 0.5


@dataclass(frozen=True, eq=False)
class Trajectory:
    """Where a camera was."""

    path: Path
    """The file that was read."""
    Ts_world_cam: Float[Array, "n 4 4"]
    """The poses."""
    times: Float[Array, " n"] | None
    """When the camera was there, s, increasing; None: at frames 0, 1, ..."""
    step: float
    """Seconds from frame to frame."""

    def require_frames(self, needed: int, reason: str) -> int:
        """The number of frames, a pose each; BadFile for less than are needed."""
        count = len(self.Ts_world_cam)
        if count < needed:
            raise BadFile(
                f"{self.path}: {count} poses, but {reason}, counted from 0; give one pose per "
                f"frame, {needed} in all, or the poses of key-frames with their times "
                f"({' '.join(TUM_COLUMNS)})"
            )
        return count

    def at(self, times: Float[Array, " m"]) -> Float[Array, "m 4 4"]:
        """The poses at these times, s; without times of its own, the poses themselves.

        Raises BadFile for times before the first pose or after the last one.
        """
        if self.times is None:
            return self.Ts_world_cam
        from scipy.spatial.transform import Rotation, Slerp

        slack = MAX_BEYOND * self.step
        for time in (times[:1], times[-1:]):
            if ((time < self.times[0] - slack) | (time > self.times[-1] + slack)).any():
                raise BadFile(
                    f"{self.path}: poses from {self.times[0]:.9g} to {self.times[-1]:.9g} s, but "
                    f"a frame at {time[0]:.9g} s; give poses for all frames, or the frames their "
                    "times (a column `time` in the file of boxes, in the same clock)"
                )
        inside = np.clip(times, self.times[0], self.times[-1])
        poses = np.tile(np.eye(4), (len(times), 1, 1))
        turns = Rotation.from_matrix(self.Ts_world_cam[:, :3, :3])
        poses[:, :3, :3] = Slerp(self.times, turns)(inside).as_matrix()
        for axis in range(3):
            poses[:, axis, 3] = np.interp(inside, self.times, self.Ts_world_cam[:, axis, 3])
        return poses


def write_trajectory(trajectory: Trajectory, path: Path) -> None:
    """Write poses as `read_trajectory` reads them: with times in TUM's layout, else one a frame."""
    if trajectory.times is None:
        write_poses(trajectory.Ts_world_cam, path)
        return
    from scipy.spatial.transform import Rotation

    poses = trajectory.Ts_world_cam
    quaternions = Rotation.from_matrix(poses[:, :3, :3]).as_quat()
    rows = np.column_stack([poses[:, :3, 3], quaternions]).tolist()
    lines = [
        f"{time!r} " + " ".join(f"{value:.9f}" for value in row)
        for time, row in zip(trajectory.times.tolist(), rows, strict=True)
    ]
    write_lines(path, [f"# {' '.join(TUM_COLUMNS)}", *lines])


def read_trajectory(path: Path, frame_rate: float, metric: bool = True) -> Trajectory:
    """The trajectory in a file of numbers, in one of three layouts; lines with `#` are left out.

    12 numbers a line: see `read_poses`, a line a frame. 8: TUM's, time and camera-to-world as
    translation and quaternion. 13: time and the 12. Times are seconds, increasing. frame_rate: Hz.
    metric: positions are in metres, so that leaps are refused.
    Raises BadFile as `read_poses`, for times that do not increase, and for quaternions that are
    none.
    """
    step = 1.0 / frame_rate
    filled = (line.strip() for line in read_text(path).split("\n"))
    lines = [line for line in filled if line and not line.startswith("#")]
    count = len(lines[0].replace(",", " ").split()) if lines else 0
    if count not in (len(TUM_COLUMNS), len(TIMED_COLUMNS)):
        return Trajectory(path, read_poses(path, step=step if metric else None), None, step)
    columns = TUM_COLUMNS if count == len(TUM_COLUMNS) else TIMED_COLUMNS
    delimiter = "," if "," in lines[0] else None
    table = read_table(path, columns, delimiter, comment="#")
    times = table.finite(["time"])[:, 0]
    back = np.r_[False, np.diff(times) <= 0.0]
    table.reject(back, "a time that is not after the one before", ["time"], "sort the poses")
    if len(times) < 2:
        raise BadFile(f"{path}: a single pose; give those of a drive")
    Ts_world_cam = np.tile(np.eye(4), (len(table), 1, 1))
    if columns == TUM_COLUMNS:
        from scipy.spatial.transform import Rotation

        quaternions = table.finite(TUM_COLUMNS[4:])
        off = np.abs(np.linalg.norm(quaternions, axis=1) - 1.0) > MAX_LENGTH_ERROR
        cure = "TUM's order is qx qy qz qw, of length 1"
        table.reject(off, "no quaternion of length 1", TUM_COLUMNS[4:], cure)
        Ts_world_cam[:, :3, :3] = Rotation.from_quat(quaternions).as_matrix()
        Ts_world_cam[:, :3, 3] = table.finite(TUM_COLUMNS[1:4])
    else:
        Ts_world_cam = rigid_poses(table)
    if metric:
        metres = np.linalg.norm(np.diff(Ts_world_cam[:, :3, 3], axis=0), axis=1)
        far = np.r_[False, metres > [max_step(gap) for gap in np.diff(times).tolist()]]
        cure = f"are the positions in metres, and all of one map? {SCALE_CURE}"
        table.reject(far, "a leap that no camera makes", ["tx", "ty", "tz"], cure)
    return Trajectory(path, Ts_world_cam, times, step)
