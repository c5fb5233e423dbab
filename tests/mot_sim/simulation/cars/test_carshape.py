"""Paints and parts."""

import numpy as np
import pytest

from mot_sim.simulation.cars import PAINTS, PARTS, load_fleet, paint_colour
from mot_sim.simulation.cars.carshape import choose, part_colours
from tracker.errors import UnknownName


def test_paint_covers_what_is_painted_and_nothing_else() -> None:
    parts = np.arange(len(PARTS))
    red, blue = part_colours(parts, "red"), part_colours(parts, "blue")
    assert red[0].tolist() == list(PAINTS["red"][0])
    np.testing.assert_array_equal(red[1:], blue[1:])
    assert part_colours(np.zeros(0, dtype=np.int64), "red").shape == (0, 3)


def test_a_cars_mesh_wears_its_colours() -> None:
    car = load_fleet().car(np.zeros(5))
    mesh = car.mesh("white")
    np.testing.assert_array_equal(mesh.visual.face_colors[:, :3], car.colours("white"))


def test_a_colour_of_ones_own_is_taken_and_an_unknown_name_is_not() -> None:
    assert paint_colour((1, 2, 3)) == (1, 2, 3)
    with pytest.raises(UnknownName, match=r"unknown colour 'gray'; .*Did you mean 'grey'"):
        paint_colour("gray")


def test_draws_fall_into_shares() -> None:
    draws = np.array([0.0, 0.19, 0.21, 0.49, 0.51, 0.999])
    assert choose([2.0, 3.0, 5.0], draws).tolist() == [0, 0, 1, 1, 2, 2]
    assert sum(share for _, share in PAINTS.values()) == pytest.approx(1.0)
