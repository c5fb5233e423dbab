"""The scene from above."""

from dataclasses import replace

import numpy as np
import pytest

from mot_sim.plotting.colours import EGO_COLOUR, colour_of_id
from mot_sim.report.topview import TRUTH_COLOUR, TopView, ellipse
from mot_sim.simulation.rig import Rig
from mot_sim.simulation.traffic import Roads
from mot_sim.simulation.traffic.roads import rectangle

CAMERA = Rig.kitti().camera
VIEW = TopView(Roads(), (0.0, 0.0), 5.0, (400, 200), (50.0, 100.0))
SQUARE = np.array([[(12.0, 1.0), (12.0, -1.0), (8.0, -1.0), (8.0, 1.0)]])


def test_world_x_is_to_the_right_and_world_y_down() -> None:
    np.testing.assert_allclose(VIEW.pixels(np.array([[0.0, 0.0], [1, 0], [0, 1]])),
                               [[50, 100], [55, 100], [50, 105]])  # fmt: skip


def test_our_heading_is_to_the_right() -> None:
    turned = replace(VIEW, origin=(3.0, 4.0), heading=np.pi / 2)  # we drive along +y
    np.testing.assert_allclose(turned.pixels(np.array([[3.0, 4.0], [3, 6], [2, 4]])),
                               [[50, 100], [60, 100], [50, 105]], atol=1e-9)  # fmt: skip


def test_the_panel_shows_us_the_truth_and_the_tracks() -> None:
    image = VIEW.ground.copy()
    before = image.copy()
    VIEW.draw_us(image, SQUARE[0] - (10.0, 0.0), CAMERA, np.zeros(3))
    assert tuple(image[100, 50]) == EGO_COLOUR
    VIEW.draw_truth(image, SQUARE)
    assert image[100, 110].min() > 0.95 * TRUTH_COLOUR[0]  # the nose, x = 12
    VIEW.draw_places(image, np.array([4]), SQUARE + (20.0, 0.0))
    assert (image == colour_of_id(4)).all(axis=2).sum() > 30
    VIEW.draw_trails(image, {6: np.array([(40.0, 5.0), (45.0, 5.0)])})
    assert (image[125, 252:270] == image[125, 260]).all()
    assert (image[125, 260] != before[125, 260]).any()
    assert (VIEW.ground == before).all()


def test_roads_are_drawn_and_without_any_there_are_rings() -> None:
    road = rectangle("asphalt", (0.0, 20.0), (-3.0, 3.0))
    paved = replace(VIEW, roads=Roads((road,)))
    assert len(np.unique(paved.ground.reshape(-1, 3), axis=0)) > 1
    on, off = paved.ground[100, 100], paved.ground[20, 100]
    assert tuple(on) != tuple(off)
    assert len(np.unique(VIEW.ground.reshape(-1, 3), axis=0)) > 2


def test_an_ellipse_has_the_half_axes_of_its_covariance() -> None:
    turn = np.array([[0.8, -0.6], [0.6, 0.8]])
    cov = turn @ np.diag([9.0, 0.25]) @ turn.T
    points = (ellipse(np.array([1.0, 2.0]), cov, 2.0) - (1.0, 2.0)) @ turn
    assert np.abs(points[:, 0]).max() == pytest.approx(6.0, rel=1e-2)
    assert np.abs(points[:, 1]).max() == pytest.approx(1.0, rel=1e-2)
    flat = ellipse(np.zeros(2), np.zeros((2, 2)))
    np.testing.assert_allclose(flat, 0.0)


def test_nobody_is_drawn_nowhere() -> None:
    image = VIEW.ground.copy()
    VIEW.draw_truth(image, np.zeros((0, 4, 2)))
    VIEW.draw_places(image, np.zeros(0, np.int64), np.zeros((0, 4, 2)))
    VIEW.draw_doubts(image, np.zeros(0, np.int64), np.zeros((0, 2)), np.zeros((0, 2, 2)))
    VIEW.draw_trails(image, {})
    assert (image == VIEW.ground).all()


def test_a_heading_that_is_not_sure_has_a_hollow_tip_and_an_assumed_one_none() -> None:
    def tips(chance: float) -> tuple[bool, bool]:
        """Whether something is drawn before the nose, and behind the tail."""
        image = VIEW.ground.copy()
        VIEW.draw_places(image, np.array([4]), SQUARE, np.array([chance]))
        changed = (image[98:103] != VIEW.ground[98:103]).any(axis=(0, 2))
        return bool(changed[114:116].any()), bool(changed[84:86].any())

    assert tips(0.99) == (True, False)
    assert tips(0.6) == (True, True)
    assert tips(np.nan) == (False, False)


def test_two_sigma_of_a_place_are_tinted_where_they_are_stated() -> None:
    image = VIEW.ground.copy()
    covs = np.array([np.diag([4.0, 0.25]), np.full((2, 2), np.nan)])
    VIEW.draw_doubts(image, np.array([4, 5]), np.array([[20.0, 0.0], [40.0, 0.0]]), covs)
    columns = np.flatnonzero((image != VIEW.ground).any(axis=(0, 2)))
    assert abs(columns.min() - (50 + 5 * 16)) <= 1
    assert abs(columns.max() - (50 + 5 * 24)) <= 1
