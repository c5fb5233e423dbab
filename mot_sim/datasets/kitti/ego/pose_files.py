"""Camera poses from files that lie beside the splits."""

from dataclasses import dataclass
from pathlib import Path

from jaxtyping import Float
from numpy import ndarray as Array

from mot_sim.datasets.kitti.calibration import Calibration
from mot_sim.datasets.kitti.places import beside_the_splits, require_file
from mot_sim.datasets.poses import read_poses

# Standard deviations of ORB-SLAM3 over one frame in camera 2: x, y, z in metres, rotations in
# radians. Root mean squares of its difference from OXTS on the ten sequences 0, 2, 3, 4, 5, 7,
# 9, 11, 17, 20: .0174, .0129, .0662 m; 3.7e-4, 7.0e-4, 4.7e-4 rad (.04 of the forward .066 is
# OXTS's own). Its path is 2.6 to 6.5 % too long, on 20 4.9 % too short: errors of scale, alike
# from frame to frame, which no covariance of one frame can say.
ORBSLAM3_MOTION_STD = (0.018, 0.013, 0.066, 4e-4, 7e-4, 5e-4)


@dataclass(frozen=True, eq=False)
class PoseFiles:
    """Motion from `<root>/odometry/<folder>/SSSS.txt`, its camera taken for camera 2."""

    folder: str
    motion_cov: Float[Array, "6 6"]

    def poses(
        self, root: Path, split: str, name: str, calibration: Calibration, frame_count: int
    ) -> Float[Array, "n 4 4"]:
        """Ts_world_cam; raises DatasetNotFound without the file and BadFile for a bad one."""
        path = beside_the_splits(root, "odometry", self.folder, split) / f"{name}.txt"
        require_file(path, "pose file", "give it, or take another ego-motion: oxts, none")
        return read_poses(path, frame_count)
