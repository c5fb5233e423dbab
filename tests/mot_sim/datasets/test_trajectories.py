"""Poses a frame, or with times between which is interpolated."""

import tempfile
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from mot_sim.datasets.boxes import box_sequence
from mot_sim.datasets.trajectories import Trajectory, read_trajectory, write_trajectory
from tests.mot_sim.datasets.conftest import write
from tests.mot_sim.datasets.test_boxes import BOXES, CAMERA
from tracker.errors import BadFile

TUM = "# time tx ty tz qx qy qz qw\n0 0 0 0 0 0 0 1\n0.1 0 0 2 0 0.0499792 0 0.9987503\n"
TIMED = "0 1 0 0 0 0 1 0 0 0 0 1 0\n0.1 1 0 0 0 0 1 0 0 0 0 1 2\n"


TWISTS = st.lists(
    st.tuples(*([st.floats(-3.0, 3.0)] * 3), *([st.floats(-5.0, 5.0)] * 3)), min_size=2, max_size=5
)


@settings(max_examples=30, deadline=None)
@given(twists=TWISTS, timed=st.booleans(), start=st.floats(0.0, 1e9))
def test_what_is_written_is_read_back(twists: list, timed: bool, start: float) -> None:
    values = np.array(twists)
    poses = np.tile(np.eye(4), (len(values), 1, 1))
    poses[:, :3, :3] = Rotation.from_rotvec(values[:, :3]).as_matrix()
    poses[:, :3, 3] = values[:, 3:]
    times = start + 0.5 * np.arange(len(values)) if timed else None
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "poses.txt"
        write_trajectory(Trajectory(path, poses, times, 0.1), path)
        read = read_trajectory(path, 10.0)
    np.testing.assert_allclose(read.Ts_world_cam, poses, atol=5e-9)
    assert (None if read.times is None else read.times.tolist()) == (
        None if times is None else times.tolist()
    )


def test_between_two_poses_of_tum_is_interpolated(tmp_path: Path) -> None:
    """Half way: half of the shift and of the turn (0.1 rad about y)."""
    trajectory = read_trajectory(write(tmp_path / "p.txt", TUM), 20.0)
    poses = trajectory.at(np.array([0.0, 0.05, 0.1]))
    np.testing.assert_allclose(poses[:, 2, 3], [0, 1, 2])
    turns = Rotation.from_matrix(poses[:, :3, :3]).as_rotvec()
    np.testing.assert_allclose(turns[:, 1], [0, 0.05, 0.1], atol=1e-6)


def test_a_drive_takes_the_poses_at_the_times_of_its_frames(tmp_path: Path) -> None:
    """Three frames at 20 Hz and two poses: every frame moves by a metre."""
    write(tmp_path / "camera.toml", CAMERA)
    write(tmp_path / "boxes.csv", BOXES)
    for text in (TUM, TIMED, TIMED.replace(" ", ",")):
        poses = write(tmp_path / "poses.txt", text)
        frames = list(box_sequence(tmp_path / "boxes.csv", tmp_path / "camera.toml", poses=poses))
        assert len(frames) == 3
        motion = frames[2].T_now_before
        assert motion is not None
        assert np.linalg.norm(motion[:3, 3]) == pytest.approx(1.0, abs=0.01)


def test_frames_with_times_of_their_own_are_found_in_the_trajectory(tmp_path: Path) -> None:
    write(tmp_path / "camera.toml", CAMERA)
    boxes = "time,x_min,y_min,x_max,y_max\n100.02,1,2,9,9\n100.08,1,2,9,9\n"
    write(tmp_path / "boxes.csv", boxes)
    poses = write(
        tmp_path / "poses.txt", TIMED.replace("0 1 0", "100 1 0", 1).replace("\n0.1", "\n100.1")
    )
    frames = list(box_sequence(tmp_path / "boxes.csv", tmp_path / "camera.toml", poses=poses))
    motion = frames[1].T_now_before
    assert motion is not None
    np.testing.assert_allclose(motion[:3, 3], [0, 0, -1.2], atol=1e-9)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (TUM + "0.1 0 0 3 0 0 0 1\n", ":4: a time that is not after the one before: time 0.1"),
        (TUM.replace(" 1\n", " 2\n"), ":2: no quaternion of length 1"),
        (TUM.replace(" 2 0 ", " 900 0 "), ":3: a leap that no camera makes"),
        (TUM.replace(" 2 0 ", " nan 0 "), ":3: tz is not finite"),
        (TIMED.replace("2\n", "2 9\n"), ":2: 14 values where 13 belong"),
        (TIMED.replace("0.1 1 0", "0.1 2 0"), ":2: its rotation is not orthonormal"),
        ("0 0 0 0 0 0 0 1\n", ": a single pose"),
    ],
)
def test_broken_trajectories_are_refused(tmp_path: Path, text: str, message: str) -> None:
    with pytest.raises(BadFile, match=f"p.txt{message}"):
        read_trajectory(write(tmp_path / "p.txt", text), 10.0)


def test_poses_that_do_not_cover_the_frames_are_named(tmp_path: Path) -> None:
    trajectory = read_trajectory(write(tmp_path / "p.txt", TUM), 20.0)
    for times in ([-0.03, 0.1], [0.0, 0.13]):
        with pytest.raises(BadFile, match=r"poses from 0 to 0.1 s, but a frame at -?0\.\d+ s"):
            trajectory.at(np.array(times))
    write(tmp_path / "camera.toml", CAMERA)
    write(tmp_path / "boxes.csv", BOXES)
    few = write(tmp_path / "few.txt", "1 0 0 0 0 1 0 0 0 0 1 0\n")
    with pytest.raises(BadFile, match=r"few.txt: 1 poses, but .*boxes.csv reaches frame 2"):
        box_sequence(tmp_path / "boxes.csv", tmp_path / "camera.toml", poses=few)
