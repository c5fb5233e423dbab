"""Lengths read off the road of the street."""

import numpy as np
import pytest

from tests.tracker.ego.corridor import CAMERA, STRAIGHT, filmed
from tracker.ego import RoadScale
from tracker.types import Camera

FREE = np.ones((188, 620), bool)
AHEAD = np.array([0.0, 0.0, -1.0])
GUESSES = np.arange(0.0, 2.0, 0.1)


def textures(road: RoadScale) -> tuple[np.ndarray, np.ndarray]:
    images, _ = filmed(STRAIGHT)
    return road.texture(images[0][:, :, 0]), road.texture(images[1][:, :, 0])


def test_the_road_tells_the_length() -> None:
    road = RoadScale(CAMERA)
    length = road(*textures(road), FREE, np.eye(3), AHEAD, GUESSES)
    assert length is not None
    assert length.metres == pytest.approx(0.9, abs=0.02)
    assert abs(length.tilt) < 4e-3
    assert length.likeness > 0.7


def test_a_camera_twice_as_high_went_twice_as_far() -> None:
    high = Camera.mounted(CAMERA.K, CAMERA.image_size, 2.0 * 1.65)
    road = RoadScale(high, far=32.0, half_width=6.0)
    length = road(*textures(road), FREE, np.eye(3), AHEAD, np.arange(0.0, 3.0, 0.1))
    assert length is not None
    assert length.metres == pytest.approx(1.8, abs=0.05)


def test_a_hidden_or_flat_road_tells_nothing() -> None:
    road = RoadScale(CAMERA)
    before, now = textures(road)
    assert road(before, now, ~FREE, np.eye(3), AHEAD, GUESSES) is None
    flat = road.texture(np.full((188, 620), 80, np.uint8))
    assert road(flat, flat, FREE, np.eye(3), AHEAD, GUESSES) is None
    noise = np.random.default_rng(0).integers(0, 256, (188, 620), dtype=np.uint8)
    assert road(road.texture(noise), now, FREE, np.eye(3), AHEAD, GUESSES) is None


def test_a_camera_that_sees_no_road_reads_nothing() -> None:
    up = Camera.mounted(CAMERA.K, CAMERA.image_size, 1.65, pitch=1.0)
    road = RoadScale(up)
    assert road.pixels.shape == (0, 2)
    images, _ = filmed(STRAIGHT)
    texture = road.texture(images[0][:, :, 0])
    assert road(texture, texture, FREE, np.eye(3), AHEAD, GUESSES) is None
