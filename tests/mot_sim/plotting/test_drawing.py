"""Marks over images."""

from itertools import pairwise

import numpy as np
import pytest

from mot_sim.plotting import draw_detections, draw_tracks
from mot_sim.plotting.colours import (
    GROUND_COLOUR,
    NEUTRAL_COLOUR,
    SKY_COLOUR,
    SWITCH_COLOUR,
    TRUE_COLOUR,
    WRONG_COLOUR,
    colour_of_id,
)
from mot_sim.plotting.drawing import (
    SWITCH_FRAMES,
    Area,
    draw_areas,
    draw_false,
    draw_switch,
    draw_true_boxes,
    plain_ground,
)
from mot_sim.simulation.rig import Rig
from tracker.types import Detections, Tracks

BOX = (100.0, 100.0, 200.0, 150.0)


def blank() -> np.ndarray:
    return np.zeros((375, 1242, 3), np.uint8)


def one(box: tuple[float, float, float, float] = BOX, track_id: int = 4) -> Tracks:
    return Tracks(np.zeros(1, np.int64), np.array([track_id]), np.array([box]))


def count(image: np.ndarray, colour: tuple[int, int, int]) -> int:
    """Pixels of about this colour: thin lines are smoothed."""
    return int((np.abs(image.astype(int) - colour) < 30).all(axis=2).sum())


def test_tracks_have_the_colours_of_their_ids() -> None:
    image = blank()
    draw_tracks(image, one())
    assert tuple(image[150, 150]) == colour_of_id(4)
    assert not image[120, 150].any()


@pytest.mark.parametrize("corner", [(0.0, 0.0), (1230.0, 360.0)])
def test_labels_stay_in_the_image(corner) -> None:
    image = blank()
    u, v = corner
    draw_tracks(image, one((u, v, u + 11.0, v + 14.0), 123))
    assert count(image, colour_of_id(123)) > 200


def test_labels_give_way_to_one_another() -> None:
    image = blank()
    taken: list[Area] = []
    boxes = np.array([BOX, (104.0, 100.0, 196.0, 148.0), (108.0, 101.0, 190.0, 146.0)])
    three = Tracks(np.zeros(3, np.int64), np.array([41, 52, 63]), boxes)
    draw_tracks(image, three, taken=taken)
    draw_true_boxes(image, three.select(np.zeros(3, bool)), three, Tracks.empty(), taken)
    assert len(taken) == 6
    for number, (left, top, right, bottom) in enumerate(taken):
        for other in taken[:number]:
            assert right <= other[0] or other[2] <= left or bottom <= other[1] or other[3] <= top
    assert taken[0][3] == 100  # the nearest car's stands at its box


def test_search_areas_are_tinted_inside_and_leave_the_rest_alone() -> None:
    image = np.full((375, 1242, 3), 100, np.uint8)
    draw_areas(image, np.array([4, 5]), np.array([BOX, (300.0, 50.0, 300.0, 90.0)]))
    colour = np.array(colour_of_id(4), float)
    inside = image[125, 150].astype(float)
    assert np.linalg.norm(inside - colour) < np.linalg.norm(100.0 - colour)
    assert (image[125, 250] == 100).all()
    assert (image[70, 295:305] == 100).all()  # an area without extent is not drawn


def test_true_boxes_tell_found_missed_and_neutral_apart() -> None:
    nobody = Tracks.empty()
    shown = {TRUE_COLOUR: (one(), nobody, nobody), WRONG_COLOUR: (nobody, one(), nobody),
             NEUTRAL_COLOUR: (nobody, nobody, one())}  # fmt: skip
    for colour, tables in shown.items():
        image = blank()
        draw_true_boxes(image, *tables)
        assert count(image, colour) > 40
        assert colour == WRONG_COLOUR or count(image, WRONG_COLOUR) == 0


def test_small_missed_cars_are_marked_without_words() -> None:
    large, small = blank(), blank()
    nobody = Tracks.empty()
    draw_true_boxes(large, nobody, one(), nobody)
    draw_true_boxes(small, nobody, one((100.0, 100.0, 130.0, 120.0)), nobody)
    assert large[152:166, 102:160].any()
    assert not small[124:140, 102:160].any()


def test_false_boxes_are_crossed_out() -> None:
    image = blank()
    draw_false(image, one())
    assert tuple(image[125, 150]) == WRONG_COLOUR  # where the diagonals meet


def test_a_switch_flashes_and_fades() -> None:
    bright = []
    for age in range(SWITCH_FRAMES):
        image = blank()
        draw_switch(image, np.array(BOX), 3, 17, age)
        bright.append(count(image[:150], SWITCH_COLOUR))
    assert bright[0] > 2 * bright[-1] > 0
    assert all(a >= b for a, b in pairwise(bright))


def test_what_has_no_image_is_sky_ground_and_a_note() -> None:
    image = plain_ground(Rig.kitti().camera, "no image of this frame")
    assert image.shape == (375, 1242, 3)
    assert tuple(image[120, 100]) == SKY_COLOUR
    assert count(image[250:], GROUND_COLOUR) > 1000
    assert count(image[:40], TRUE_COLOUR) > 50
    up = plain_ground(Rig.kitti(pitch=1.2).camera, "no image")
    assert count(up[40:], SKY_COLOUR) > 300_000


def test_nothing_draws_nothing() -> None:
    image = blank()
    draw_detections(image, Detections.empty())
    draw_tracks(image, Tracks.empty())
    draw_areas(image, np.zeros(0, np.int64), np.zeros((0, 4)))
    draw_true_boxes(image, Tracks.empty(), Tracks.empty(), Tracks.empty())
    draw_false(image, Tracks.empty())
    assert not image.any()
