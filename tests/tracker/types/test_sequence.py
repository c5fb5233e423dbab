"""Frames, and what satisfies the protocol of a sequence."""

import dataclasses

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from mot_sim.datasets.recorded import DetectionLog, RecordedSequence
from tests.tracker.samples import LEVEL
from tracker.errors import BadConfig, BadMotion
from tracker.geometry import homogeneous, rotation_y
from tracker.types import Detections, Frame, Sequence, SequenceWrapper


def recorded() -> RecordedSequence:
    log = DetectionLog(np.array([1]), Detections(np.array([[0.0, 0, 9, 9]]), np.ones(1)))
    return RecordedSequence("short", LEVEL, 3, log, np.arange(3))


def test_a_recorded_drive_is_a_sequence() -> None:
    sequence = recorded()
    assert isinstance(sequence, Sequence)
    assert sequence.camera is LEVEL
    assert [len(frame.detections) for frame in sequence] == [0, 1, 0]


def test_a_wrapped_sequence_is_a_sequence_like_the_one_inside() -> None:
    sequence = SequenceWrapper(recorded())
    assert isinstance(sequence, Sequence)
    assert (sequence.name, sequence.camera, len(sequence)) == ("short", LEVEL, 3)
    assert [frame.index for frame in sequence] == [0, 1, 2]


def test_a_list_of_frames_is_no_sequence_because_it_has_no_camera() -> None:
    assert not isinstance(list(recorded()), Sequence)


def test_truth_never_rides_in_a_frame() -> None:
    fields = {field.name for field in dataclasses.fields(Frame)}
    assert fields == {"index", "time", "detections", "T_now_before", "motion_cov", "image"}


def test_a_frame_needs_no_motion_and_no_image() -> None:
    frame = Frame(0, 0.0, Detections.empty())
    assert frame.T_now_before is None
    assert frame.motion_cov is None
    assert frame.image is None


def test_a_frame_cannot_be_changed() -> None:
    with pytest.raises(dataclasses.FrozenInstanceError):
        Frame(0, 0.0, Detections.empty()).index = 1


GOOD = np.array(homogeneous(rotation_y(0.1), np.array([0.2, 0.0, -1.0])))


@pytest.mark.parametrize(
    ("T", "told"),
    [
        (GOOD.T, "transposed: the translation stands in the last row"),
        (GOOD @ np.diag([1.0, 1.0, -1.0, 1.0]), "its determinant is -1: mirrored"),
        (GOOD * np.array([[1.5], [1.5], [1.5], [1.0]]), r"its rotation is scaled by 1\.5"),
        (-GOOD * np.array([[2.0], [2.0], [2.0], [-1.0]]), "scaled by 2 and mirrored"),
        (np.where(np.eye(4) > 0, np.nan, GOOD), r"entry \[0, 0\] is nan: not finite"),
        (homogeneous(t=np.array([0.0, np.inf, 0.0])), r"entry \[1, 3\] is inf"),
        (np.diag([0.0, 0.0, 0.0, 1.0]), "its rotation is all zeros"),
        (np.diag([1.0, 1.0, 0.9, 1.0]), r"not orthonormal: rows of lengths 1, 1, 0\.9"),
        (GOOD + np.eye(4, k=1) * 0.01, "not orthonormal"),
        (np.zeros((4, 4)), "its last row is 0, 0, 0, 0"),
        (np.eye(3), r"its shape is \(3, 3\)"),
        ("still", "T_now_before: values of type"),
    ],
)
@pytest.mark.unchecked
def test_a_motion_that_is_not_rigid_is_named_with_what_is_wrong(T, told: str) -> None:
    with pytest.raises(BadMotion, match=f"frame 7: T_now_before: .*{told}|frame 7: {told}"):
        Frame(7, 0.7, Detections.empty(), T)


@pytest.mark.parametrize(
    ("cov", "told"),
    [
        (np.full((6, 6), np.nan), r"entry \[0, 0\] is nan"),
        (np.diag([1.0, 1.0, -1e-3, 1.0, 1.0, 1.0]), r"it has the negative eigenvalue -0\.001"),
        (np.eye(6) + np.eye(6, k=1), r"not symmetric: entry \[0, 1\] is 1, \[1, 0\] 0"),
        (np.eye(3), r"its shape is \(3, 3\); give 6x6"),
    ],
)
@pytest.mark.unchecked
def test_what_is_no_covariance_is_named_with_what_is_wrong(cov, told: str) -> None:
    with pytest.raises(BadMotion, match=f"frame 1: motion_cov: {told}"):
        Frame(1, 0.1, Detections.empty(), np.eye(4), cov)


@given(
    st.tuples(*[st.floats(-3, 3)] * 3), st.tuples(*[st.floats(-50, 50)] * 3),
    st.sampled_from(["float32", "six digits", "list", "3x4"]),
)  # fmt: skip
@pytest.mark.unchecked
def test_rigid_motions_pass_whatever_their_number_format(turn, shift, form: str) -> None:
    T = homogeneous(Rotation.from_rotvec(turn).as_matrix(), np.array(shift))
    given = {
        "float32": T.astype(np.float32),
        "six digits": np.array([[float(f"{value:.6g}") for value in row] for row in T]),
        "list": T.tolist(),
        "3x4": T[:3],
    }[form]
    taken = Frame(1, 0.1, Detections.empty(), given, np.diag([1e-4] * 6).astype(np.float32))
    assert taken.T_now_before is not None
    assert taken.T_now_before.dtype == np.float64
    np.testing.assert_allclose(taken.T_now_before, T, atol=1e-4)


def test_covariances_of_rank_one_and_of_nothing_pass() -> None:
    along = np.array([[0.1, 0.3, 2.0, 0.01, 0.0, 0.2]])
    for cov in (np.zeros((6, 6)), along.T @ along, 1e-30 * np.eye(6)):
        assert Frame(1, 0.1, Detections.empty(), np.eye(4), cov).motion_cov is cov


@pytest.mark.parametrize("time", [np.nan, np.inf, -np.inf, "now", None])
@pytest.mark.unchecked
def test_a_time_that_is_none_is_refused_at_once(time) -> None:
    with pytest.raises(BadConfig, match=f"frame 0: time is {time!r}".replace("np.", "")):
        Frame(0, time, Detections.empty())


@pytest.mark.unchecked
def test_numbers_of_other_types_are_taken() -> None:
    frame = Frame(np.int64(3), np.float32(0.5), Detections.empty())
    assert (type(frame.index), frame.index, type(frame.time), frame.time) == (int, 3, float, 0.5)
    assert type(Frame(0, 1, Detections.empty()).time) is float
    with pytest.raises(BadConfig, match=r"frame index is 0\.5"):
        Frame(0.5, 0.0, Detections.empty())
