"""No ego-motion: nobody knows how the camera moved."""

from dataclasses import dataclass
from pathlib import Path

from mot_sim.datasets.kitti.calibration import Calibration


@dataclass(frozen=True, eq=False)
class UnknownEgo:
    """Frames whose T_now_before is None."""

    motion_cov: None = None

    def poses(
        self, root: Path, split: str, name: str, calibration: Calibration, frame_count: int
    ) -> None:
        """No poses."""
        return
