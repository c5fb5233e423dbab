"""Sequences whose motion is seen in their images."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import pytest
from numpy import ndarray as Array

from tests.tracker.ego.corridor import CAMERA, STRAIGHT, filmed
from tracker.ego import VisualOdometry, VisualSequence
from tracker.errors import MissingCue
from tracker.types import Camera, Detections, Frame, Sequence


@dataclass(frozen=True, eq=False)
class Film:
    """Some images as a sequence."""

    images: list[Array | None]
    name: str = "film"
    camera: Camera = CAMERA

    def __len__(self) -> int:
        return len(self.images)

    def __iter__(self) -> Iterator[Frame]:
        for index, image in enumerate(self.images):
            yield Frame(index, 0.1 * index, Detections.empty(), image=image)


def test_frames_carry_the_motion_that_their_images_show() -> None:
    images, _ = filmed(STRAIGHT)
    drive = VisualSequence(Film(list(images)))
    assert isinstance(drive, Sequence)
    assert (drive.name, len(drive), drive.camera) == ("film", 9, CAMERA)
    odometry = VisualOdometry(CAMERA)
    for number, frame in enumerate(drive):
        T, cov = odometry.step(images[number], np.zeros((0, 4)), 0.1)
        assert frame.index == number
        assert frame.image is images[number]
        if T is None or frame.T_now_before is None:
            assert T is frame.T_now_before is frame.motion_cov is None
            continue
        np.testing.assert_allclose(frame.T_now_before, T, atol=1e-9)
        np.testing.assert_allclose(frame.motion_cov, cov, atol=1e-9)


def test_a_thread_changes_no_bit() -> None:
    images, _ = filmed(STRAIGHT)
    film = Film(list(images))
    pairs = zip(VisualSequence(film), VisualSequence(film, threaded=True), strict=True)
    for plain, threaded in list(pairs)[1:]:
        assert plain.T_now_before is not None
        assert threaded.T_now_before is not None
        assert plain.T_now_before.tobytes() == threaded.T_now_before.tobytes()


def test_a_sequence_without_any_image_says_so() -> None:
    with pytest.raises(MissingCue, match="none of 3 frames has an image"):
        list(VisualSequence(Film([None] * 3)))
    assert list(VisualSequence(Film([]))) == []
