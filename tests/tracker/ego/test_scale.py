"""Metres for odometry of unknown scale."""

from collections.abc import Iterator

import numpy as np
import pytest

from tracker import Camera, Cuboids, Detections, Frame
from tracker.ego import EgoScale
from tracker.geometry import homogeneous

K = np.array([[700.0, 0.0, 620.0], [0.0, 700.0, 180.0], [0.0, 0.0, 1.0]])
CAMERA = Camera.mounted(K, (1241, 376), 1.65)
SIZE = np.array([3.9, 1.5, 1.6])


def drive(unit: float, speed: float = 10.0, frames: int = 40) -> Iterator[Frame]:
    """A street with parked cars on both sides, one that leads and one that comes towards us.

    unit: metres per unit of the odometry. The camera brakes a little on the way.
    """
    rng = np.random.default_rng(0)
    parked = [np.array([side, 0.0, z]) for z in range(12, 90, 12) for side in (-5.0, 4.0)]
    at, before = 0.0, 0.0
    for index in range(frames):
        seconds = 0.1 * index
        if index:
            at += 0.1 * speed * (1.0 if index < 20 else 0.8)
        moving = [
            np.array([0.0, 0.0, 15.0 + 0.95 * speed * seconds]),
            np.array([-2.5, 0.0, 95.0 - 9.0 * seconds]),
        ]
        bases = np.array([*parked, *moving]) - [0.0, 0.0, at]
        bases = bases[bases[:, 2] > 5.0]
        yaws = np.full(len(bases), -0.5 * np.pi)
        corners = Cuboids(bases, yaws, np.tile(SIZE, (len(bases), 1))).corners()
        T = CAMERA.T_cam_road
        pixels = CAMERA.project(corners @ T[:3, :3].T + T[:3, 3])
        boxes = np.hstack([pixels.min(axis=1), pixels.max(axis=1)])
        boxes = boxes + rng.normal(0.0, 0.01, boxes.shape) * (boxes[:, 3:] - boxes[:, 1:2])
        T_now_before = homogeneous(t=np.array([0.0, 0.0, (before - at) / unit]))
        before = at
        found = Detections(boxes, np.full(len(boxes), 0.9))
        yield Frame(index, seconds, found, None if index == 0 else T_now_before)


@pytest.mark.parametrize("unit", [0.05, 1.0, 20.0])
def test_parked_cars_tell_the_scale_whatever_it_is(unit: float) -> None:
    scale = EgoScale(CAMERA)
    given = list(drive(unit))
    frames = [scale.step(frame) for frame in given]
    found = scale.estimate
    assert found.known
    assert found.factor == pytest.approx(unit, rel=0.12)
    assert found.low < unit < found.high < 1.5 * found.low
    last = frames[-1].T_now_before
    assert last is not None
    assert last[2, 3] == pytest.approx(-0.8, rel=0.12)
    cov = frames[-1].motion_cov
    assert cov is not None
    assert 0.02 * 0.8 < np.sqrt(cov[2, 2]) < 0.25 * 0.8
    scale.reset()
    again = [scale.step(frame) for frame in given]
    assert np.array_equal(again[-1].T_now_before, last)


def test_until_cars_have_told_it_the_translation_counts_as_unknown() -> None:
    scale = EgoScale(CAMERA)
    first, second, *_ = (scale.step(frame) for frame in drive(0.05, frames=3))
    assert first.T_now_before is None
    assert second.T_now_before is not None
    assert second.T_now_before[2, 3] == 0.0
    assert second.motion_cov is not None
    assert second.motion_cov[2, 2] == pytest.approx(1.0)
    assert not scale.estimate.known


def test_a_camera_that_stands_tells_nothing() -> None:
    scale = EgoScale(CAMERA)
    for frame in drive(1.0, speed=0.0):
        scale.step(frame)
    assert not scale.estimate.known


def test_frames_without_boxes_or_motion_are_handed_on() -> None:
    scale = EgoScale(CAMERA)
    empty = Frame(0, 0.0, Detections.empty(), None)
    assert scale.step(empty) is empty
    assert scale.step(Frame(1, 0.1, None, np.eye(4))).detections is None
