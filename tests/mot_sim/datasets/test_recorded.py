"""A recorded drive: frames in order, motion composed over what is left out."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from mot_sim.datasets.recorded import DetectionLog, RecordedSequence, looking_interval
from tracker.errors import BadConfig
from tracker.geometry import adjoint_of, homogeneous, invert, transform
from tracker.types import Camera, Detections, Sequence

CAMERA = Camera.mounted(np.array([[100.0, 0, 50], [0, 100, 20], [0, 0, 1]]), (100, 40), 1.65)


def small_motion(twist: np.ndarray) -> np.ndarray:
    """The transform of a translation and a rotation vector."""
    return homogeneous(Rotation.from_rotvec(twist[3:]).as_matrix(), twist[:3])


def drive(frame_count: int = 6, seed: int = 0) -> RecordedSequence:
    """A curvy drive with one box in every second frame."""
    rng = np.random.default_rng(seed)
    poses = [np.eye(4)]
    for _ in range(frame_count - 1):
        poses.append(poses[-1] @ small_motion(rng.normal([0, 0, 1, 0, 0.1, 0], 0.05)))
    frames = np.arange(0, frame_count, 2)
    boxes = np.tile([10.0, 10.0, 20.0, 20.0], (len(frames), 1))
    return RecordedSequence(
        name="drive",
        camera=CAMERA,
        frame_count=frame_count,
        log=DetectionLog(frames, Detections(boxes, frames / 10.0)),
        frame_indices=np.arange(frame_count),
        Ts_world_cam=np.array(poses),
        motion_cov=np.diag([0.01, 0.01, 0.04, 1e-6, 1e-6, 1e-6]),
    )


def test_it_is_a_sequence() -> None:
    assert isinstance(drive(), Sequence)


def test_rows_are_brought_into_the_order_of_frames() -> None:
    boxes = np.arange(12.0).reshape(3, 4)
    log = DetectionLog.of(np.array([2, 0, 2]), Detections(boxes, np.array([0.1, 0.2, 0.3])))
    assert log.at(0).scores.tolist() == [0.2]
    assert log.at(1).boxes.shape == (0, 4)
    assert log.at(2).scores.tolist() == [0.1, 0.3]


def test_frames_carry_time_boxes_and_motion() -> None:
    frames = list(drive())
    assert [frame.index for frame in frames] == [0, 1, 2, 3, 4, 5]
    assert [frame.time for frame in frames] == [0.0, 0.1, 0.2, 0.3, 0.4, 0.5]
    assert [len(frame.detections) for frame in frames] == [1, 0, 1, 0, 1, 0]
    assert frames[0].T_now_before is None
    assert frames[0].motion_cov is None
    assert all(frame.image is None for frame in frames)


def test_motion_moves_a_standing_point_from_the_camera_before_to_the_camera_now() -> None:
    sequence = drive()
    assert sequence.Ts_world_cam is not None
    point_world = np.array([[1.0, 2.0, 30.0]])
    seen = [transform(invert(pose), point_world) for pose in sequence.Ts_world_cam]
    for frame in list(sequence)[1:]:
        assert frame.T_now_before is not None
        moved = transform(frame.T_now_before, seen[frame.index - 1])
        np.testing.assert_allclose(moved, seen[frame.index], atol=1e-9)


def test_driving_forward_brings_what_stands_nearer() -> None:
    forward = RecordedSequence(
        "ahead", CAMERA, 2, DetectionLog(np.zeros(0, np.int64), Detections.empty()),
        np.arange(2), np.array([np.eye(4), homogeneous(None, np.array([0.0, 0.0, 2.0]))]),
    )  # fmt: skip
    T_now_before = list(forward)[1].T_now_before
    assert T_now_before is not None
    np.testing.assert_allclose(transform(T_now_before, np.array([[0.0, 0, 10]])), [[0, 0, 8]])


def test_motion_is_composed_over_dropped_frames() -> None:
    sequence = drive()
    motions = [frame.T_now_before for frame in sequence]
    kept = list(sequence.subset([1, 4, 5]))
    assert [frame.index for frame in kept] == [1, 4, 5]
    assert kept[0].T_now_before is None
    np.testing.assert_allclose(kept[1].T_now_before, motions[4] @ motions[3] @ motions[2])
    np.testing.assert_allclose(kept[2].T_now_before, motions[5])
    assert kept[1].time == 0.4


def test_a_subset_of_a_subset_and_an_empty_one_work() -> None:
    sequence = drive()
    assert [f.index for f in sequence.subset(range(4)).subset([0, 3])] == [0, 3]
    assert list(sequence.subset([])) == []
    assert len(sequence.subset([])) == 0


def test_covariance_grows_over_dropped_frames_as_samples_do() -> None:
    sequence = drive()
    motions = [frame.T_now_before for frame in sequence]
    rng = np.random.default_rng(3)
    assert sequence.motion_cov is not None
    spread = np.linalg.cholesky(sequence.motion_cov * 1e-4)
    exact = motions[3] @ motions[2] @ motions[1]
    noisy = np.tile(np.eye(4), (4000, 1, 1))
    for motion in motions[1:4]:
        twists = rng.normal(size=(4000, 6)) @ spread.T
        errors = np.tile(np.eye(4), (4000, 1, 1))
        errors[:, :3, :3] = Rotation.from_rotvec(twists[:, 3:]).as_matrix()
        errors[:, :3, 3] = twists[:, :3]
        noisy = errors @ motion @ noisy
    left = noisy @ invert(exact)
    errors = np.hstack([left[:, :3, 3], Rotation.from_matrix(left[:, :3, :3]).as_rotvec()])
    given_cov = list(sequence.subset([0, 3]))[1].motion_cov
    assert given_cov is not None
    measured = np.cov(errors.T) / 1e-4
    scale = np.sqrt(np.diag(given_cov))
    np.testing.assert_allclose(
        measured / np.outer(scale, scale), given_cov / np.outer(scale, scale), atol=0.1
    )


@given(st.lists(st.floats(-2.0, 2.0), min_size=12, max_size=12))
def test_the_adjoint_carries_small_motions(values: list[float]) -> None:
    T, twist = small_motion(np.array(values[:6])), 1e-6 * np.array(values[6:])
    carried = T @ small_motion(twist) @ invert(T)
    np.testing.assert_allclose(carried, small_motion(adjoint_of(T) @ twist), atol=1e-10)


@pytest.mark.parametrize(
    ("chosen", "message"),
    [
        ([6], "no frame 6: it has 6 frames of 0..5"),
        ([-1], "no frame -1"),
        ([3, 1], "must increase"),
    ],
)
def test_bad_subsets_are_refused(chosen: list[int], message: str) -> None:
    with pytest.raises(BadConfig, match=message):
        drive().subset(chosen)


def test_without_poses_nobody_knows_the_motion() -> None:
    blind = RecordedSequence(
        "blind", CAMERA, 3, DetectionLog(np.zeros(0, np.int64), Detections.empty()), np.arange(3)
    )
    assert all(frame.T_now_before is None and frame.motion_cov is None for frame in blind)
    assert all(len(frame.detections) == 0 for frame in blind)


def test_a_detector_that_looked_at_every_nth_frame_only() -> None:
    """None is not the same as nothing found: frame 4 was looked at."""
    whole = drive(12)
    log = whole.log
    gone = replace(whole, log=DetectionLog(log.frames[[0, 1, 3]], log.detections.select([0, 1, 3])))
    frames = list(gone.looked_at_every(2))
    assert [frame.looked_at for frame in frames] == [True, False] * 6
    assert [len(frame.found) for frame in frames[:7:2]] == [1, 1, 0, 1]
    assert frames[1].T_now_before is not None
    assert [frame.looked_at for frame in whole.looked_at_every(1)] == [True] * 12
    with pytest.raises(BadConfig, match="every 0"):
        whole.looked_at_every(0)


def test_boxes_in_frames_that_were_not_looked_at_are_counted_aloud(caplog) -> None:
    sequence = drive(12).looked_at_every(4)
    assert "3 of 6 boxes are left out" in caplog.text
    assert [len(frame.found) for frame in sequence][:5] == [1, 0, 0, 0, 1]


def test_boxes_that_all_lie_in_every_nth_frame_tell_of_themselves(caplog) -> None:
    """Eleven even numbers are no chance, six may be; where they begin does not matter."""
    assert all(frame.looked_at for frame in drive(12).looked_at_every(None))
    assert caplog.text == ""
    frames = list(drive(30).looked_at_every(None))
    assert [frame.looked_at for frame in frames] == [True, False] * 15
    assert "one frame in 2 only, from 0 on" in caplog.text
    assert "--every 1" in caplog.text
    assert all(frame.looked_at for frame in drive(30).looked_at_every(1))


@pytest.mark.parametrize(
    ("frames", "interval"),
    [
        (range(0, 8000, 2), 2),
        (range(3, 60, 5), 5),
        ([0, 10, 20, 60, 70], 10),
        ([0, 1000], 1),
        (range(0, 12, 2), 1),
        ([*range(0, 60, 2), 61], 1),
        ([], 1),
        ([4, 4, 4], 1),
    ],
)
def test_the_interval_of_looks(frames, interval: int) -> None:
    assert looking_interval(np.array(frames, np.int64)) == interval
