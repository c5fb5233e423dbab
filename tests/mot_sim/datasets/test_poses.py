"""Pose files: 12 numbers a line."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from mot_sim.datasets.poses import read_poses, write_poses
from tests.mot_sim.datasets.conftest import write
from tracker.errors import BadFile

LEVEL = "1 0 0 5 0 1 0 6 0 0 1 7\n"


def test_a_line_is_a_matrix_row_by_row(tmp_path: Path) -> None:
    poses = read_poses(write(tmp_path / "p.txt", "0 0 1 5 0 1 0 6 -1 0 0 7\n"), 1)
    expected = [[0, 0, 1, 5], [0, 1, 0, 6], [-1, 0, 0, 7], [0, 0, 0, 1]]
    np.testing.assert_allclose(poses, [expected], atol=1e-12)


def test_an_empty_file_holds_no_pose(tmp_path: Path) -> None:
    assert read_poses(write(tmp_path / "p.txt", "")).shape == (0, 4, 4)


@given(st.lists(st.tuples(*[st.floats(-3, 3)] * 6), max_size=4))
def test_written_poses_are_read_back(
    tmp_path_factory: pytest.TempPathFactory, twists: list[tuple[float, ...]]
) -> None:
    path = tmp_path_factory.mktemp("poses") / "p.txt"
    poses = np.tile(np.eye(4), (len(twists), 1, 1))
    for pose, twist in zip(poses, twists, strict=True):
        pose[:3, :3] = Rotation.from_rotvec(twist[:3]).as_matrix()
        pose[:3, 3] = twist[3:]
    write_poses(poses, path)
    np.testing.assert_allclose(read_poses(path, len(twists)), poses, atol=2e-9)


def test_printed_rotations_become_orthonormal(tmp_path: Path) -> None:
    R = Rotation.from_rotvec([0.1, 0.2, 0.3]).as_matrix().round(4)
    row = " ".join(f"{value:.4f}" for value in np.column_stack([R, [0, 0, 0]]).flat)
    pose = read_poses(write(tmp_path / "p.txt", row))[0]
    np.testing.assert_allclose(pose[:3, :3] @ pose[:3, :3].T, np.eye(3), atol=1e-12)
    np.testing.assert_allclose(pose[:3, :3], R, atol=1e-4)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (LEVEL, r"p.txt: 1 poses for 2 frames"),
        (LEVEL + "2 0 0 0 0 1 0 0 0 0 1 0\n", r"p.txt:2: the first three columns are no rotation"),
        (LEVEL + "1 0 0 0 0 1 0 0 0 0 -1 0\n", r"p.txt:2: the first three columns are no rotation"),
        (LEVEL + "1 0 0 nan 0 1 0 0 0 0 1 0\n", r"p.txt:2: t1 is not finite"),
        (LEVEL + "1 0 0 0 0 1 0 0 0 0 1\n", r"p.txt:2: 11 values where 12 belong"),
    ],
)
def test_bad_poses_are_refused(tmp_path: Path, text: str, message: str) -> None:
    with pytest.raises(BadFile, match=message):
        read_poses(write(tmp_path / "p.txt", text), 2)
