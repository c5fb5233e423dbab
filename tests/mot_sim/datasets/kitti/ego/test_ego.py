"""Every source of ego-motion keeps the same promise."""

from pathlib import Path

import numpy as np
import pytest

from mot_sim.datasets.kitti.calibration import read_calibration
from mot_sim.datasets.kitti.ego import EGO
from tracker.errors import DatasetNotFound


@pytest.mark.parametrize("name", sorted(EGO))
def test_a_source_gives_poses_and_their_covariance_or_neither(name: str, tiny_tree: Path) -> None:
    calibration = read_calibration(tiny_tree / "training" / "calib" / "0030.txt")
    poses = EGO[name].poses(tiny_tree, "training", "0030", calibration, 3)
    covariance = EGO[name].motion_cov
    assert (poses is None) == (covariance is None)
    if poses is None or covariance is None:
        return
    assert poses.shape == (3, 4, 4)
    turns = poses[:, :3, :3]
    np.testing.assert_allclose(turns @ turns.transpose(0, 2, 1), np.tile(np.eye(3), (3, 1, 1)))
    np.testing.assert_array_equal(covariance, covariance.T)
    assert (np.linalg.eigvalsh(covariance) > 0.0).all()


def test_a_missing_pose_file_is_named(tiny_tree: Path) -> None:
    calibration = read_calibration(tiny_tree / "training" / "calib" / "0030.txt")
    with pytest.raises(DatasetNotFound, match=r"odometry/orbslam3/testing/0030.txt: no pose file"):
        EGO["orbslam3"].poses(tiny_tree, "testing", "0030", calibration, 3)
