"""Pictures of cars with their identities."""

from dataclasses import replace

import numpy as np
import pytest

from mot_sim.simulation.registry import SCENES
from mot_sim.simulation.scenery import WEATHERS
from mot_sim.training.identities import (
    MIN_HEIGHT_PIXELS,
    MIN_VISIBLE_SHARE,
    CarPicture,
    RenderedDrive,
    car_pictures,
    training_drives,
)

DRIVE = RenderedDrive("gauntlet", 3, ("clear", "dusk"), (0, 4), beside=0.0)


@pytest.fixture(scope="module")
def sights() -> list[CarPicture]:
    return list(car_pictures(DRIVE))


def test_there_is_a_picture_a_frame_and_weather_with_the_same_cars_in_it(sights) -> None:
    assert [sight.frame for sight in sights] == [0, 4, 0, 4]
    assert len(sights) == DRIVE.pictures
    assert {sight.drive for sight in sights} == {"gauntlet/3"}
    clear, dusk = sights[0], sights[2]
    assert len(set(clear.ids.tolist()) & set(dusk.ids.tolist())) >= 4
    assert clear.image.mean() > dusk.image.mean() + 5.0


def test_cars_are_large_and_visible_enough_and_boxes_inside_the_image(sights) -> None:
    for sight in sights:
        height, width = sight.image.shape[:2]
        assert (sight.visible >= MIN_VISIBLE_SHARE).all()
        assert (sight.boxes[:, 3] - sight.boxes[:, 1] >= MIN_HEIGHT_PIXELS).all()
        assert (sight.boxes >= 0.0).all()
        assert (sight.boxes <= [width - 1, height - 1, width - 1, height - 1]).all()
        assert len(set(sight.ids.tolist())) == len(sight.ids)


def test_boxes_tremble_like_a_detectors_and_by_nothing_when_asked(sights) -> None:
    drive = replace(DRIVE, weathers=("clear",), frames=(0,))
    (exact,) = car_pictures(drive, edge_std=0.0)
    shared = np.intersect1d(exact.ids, sights[0].ids)
    rows = [np.searchsorted(sight.ids, shared) for sight in (exact, sights[0])]
    true, seen = exact.boxes[rows[0]], sights[0].boxes[rows[1]]
    off = np.abs(seen - true) / np.tile(true[:, 2:] - true[:, :2], 2)
    assert 0.005 < off.mean() < 0.06
    np.testing.assert_array_equal(exact.image, sights[0].image)


def test_lessons_are_known_scenes_and_weathers_and_not_the_scenes_of_the_benchmark() -> None:
    drives = training_drives()
    assert {drive.scene for drive in drives} <= set(SCENES) - {"look_alikes", "t_junction"}
    assert {weather for drive in drives for weather in drive.weathers} <= set(WEATHERS)
    assert len({drive.name for drive in drives}) == len(drives)
    assert all(drive.seed < 900 for drive in drives)
