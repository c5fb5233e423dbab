"""Where the camera's motion comes from: one entry a source."""

from pathlib import Path
from typing import Protocol, runtime_checkable

import numpy as np
from jaxtyping import Float
from numpy import ndarray as Array

from mot_sim.datasets.kitti.calibration import Calibration
from mot_sim.datasets.kitti.ego.oxts import Oxts
from mot_sim.datasets.kitti.ego.pose_files import ORBSLAM3_MOTION_STD, PoseFiles
from mot_sim.datasets.kitti.ego.unknown import UnknownEgo
from mot_sim.datasets.kitti.ego.visual import ImageMotion, VisualEgo


@runtime_checkable
class EgoSource(Protocol):
    """What gives the camera's poses; motion_cov is None exactly when `poses` gives None.

    One that sees the motion while the drive is played gives None here, and has a `watch`.
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

__all__ = [
    "EGO",
    "ORBSLAM3_MOTION_STD",
    "EgoSource",
    "ImageMotion",
    "Oxts",
    "PoseFiles",
    "UnknownEgo",
    "VisualEgo",
]
