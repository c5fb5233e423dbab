"""Strokes, colours and text."""

from itertools import pairwise

import numpy as np
import pytest

from mot_sim.plotting import canvas
from mot_sim.plotting.colours import PAINT_COLOURS, colour_of_id, ink_on
from mot_sim.simulation.traffic.roads import PAINTS


def blank() -> np.ndarray:
    return np.zeros((60, 100, 3), np.uint8)


def test_a_filled_square_covers_its_pixels() -> None:
    image = blank()
    canvas.fill_polygon(image, np.array([(10.0, 10), (19, 10), (19, 19), (10, 19)]), (9, 8, 7))
    assert (image[10:20, 10:20] == (9, 8, 7)).all()
    assert (image[25:] == 0).all()


def test_degenerate_polygons_and_lines_leave_the_image_alone() -> None:
    image = blank()
    canvas.fill_polygon(image, np.zeros((2, 2)), (255, 0, 0))
    canvas.draw_line(image, np.zeros((1, 2)), (255, 0, 0))
    assert not image.any()


def test_corners_far_outside_do_not_overflow() -> None:
    image = blank()
    canvas.fill_polygon(
        image, np.array([(-1e7, -1e7), (1e7, -1e7), (1e7, 1e7), (-1e7, 1e7)]), (1, 2, 3)
    )
    assert (image == (1, 2, 3)).all()


def test_text_is_as_wide_as_foretold() -> None:
    image = blank()
    end = canvas.draw_text(image, "42", (10, 40), (255, 255, 255))
    assert abs(end - 10 - canvas.text_width("42")) <= 2
    columns = np.flatnonzero(image.any(axis=(0, 2)))
    assert columns.min() >= 9
    assert columns.max() <= end + 1


@pytest.mark.parametrize("place", [(-9, 12), (90, 62), (30, -2), (500, 500)])
def test_text_that_leaves_the_image_is_cut(place: tuple[int, int]) -> None:
    image, large = blank(), np.zeros((80, 160, 3), np.uint8)
    canvas.draw_text(image, "gap 4.2 m", place, (255, 255, 255))
    canvas.draw_text(large, "gap 4.2 m", (place[0] + 20, place[1] + 10), (255, 255, 255))
    assert np.array_equal(image, large[10:70, 20:120])


def test_no_word_draws_nothing() -> None:
    image = blank()
    assert canvas.draw_text(image, "", (10, 40), (255, 255, 255)) == 10
    assert not image.any()


def test_ids_have_stable_and_different_colours() -> None:
    colours = [colour_of_id(track_id) for track_id in range(20)]
    assert len(set(colours)) == 20
    apart = [np.abs(np.subtract(a, b)).sum() for a, b in pairwise(colours)]
    assert min(apart) > 120
    assert ink_on((255, 255, 0)) == (0, 0, 0)
    assert ink_on((0, 0, 160)) == (255, 255, 255)


def test_every_paint_has_a_colour() -> None:
    assert set(PAINT_COLOURS) == set(PAINTS)
