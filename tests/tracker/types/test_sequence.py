"""Frames, and what satisfies the protocol of a sequence."""

import dataclasses

import numpy as np
import pytest

from mot_sim.datasets.recorded import DetectionLog, RecordedSequence
from tests.tracker.samples import LEVEL
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
