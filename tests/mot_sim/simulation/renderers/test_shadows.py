"""Shadows on the road."""

import numpy as np
import pytest

from mot_sim.simulation.renderers import MeshInstances, Sun, View
from mot_sim.simulation.renderers.shadows import Outlines, casters, drawn, fall, shadow_mask
from tests.mot_sim.simulation.renderers.shapes import KITTI, at, box, view_of

SQUARE = np.array([[0.0, 0.0], [2.0, 0.0], [2.0, 4.0], [0.0, 4.0], [1.0, 1.0]])


def sun_taken(view: View) -> np.ndarray:
    """The mask of all shadows in a view."""
    return shadow_mask(view, 0.3, casters(view, 0.3))


def test_light_from_the_right_above_falls_to_the_left() -> None:
    points = np.array([[0.0, -2.0, 10.0], [1.0, 0.0, 5.0]])
    fallen = fall(points, Sun(towards=(1.0, -2.0, 0.0)))
    assert fallen == pytest.approx(np.array([[-1.0, 10.0], [1.0, 5.0]]))


def test_an_outline_grows_from_its_middle() -> None:
    grown = Outlines.around([SQUARE, SQUARE + 10.0]).grown(0.5)
    assert len(grown) == 8  # the inner point is no corner
    assert grown[:4].min(axis=0) == pytest.approx([-0.5, -1.0])
    assert grown[4:].max(axis=0) == pytest.approx([12.5, 15.0])


def test_an_outline_that_shrinks_too_far_becomes_a_point() -> None:
    assert Outlines.around([SQUARE]).grown(-9.0) == pytest.approx(np.tile([1.0, 2.0], (4, 1)))


def test_nothing_casts_no_shadow() -> None:
    assert not sun_taken(View(KITTI, MeshInstances.empty())).any()


def test_a_shadow_that_reaches_behind_the_camera_is_cut() -> None:
    mask = sun_taken(view_of(KITTI, (box(14.0), at(KITTI, -4.6, 5.0, np.pi / 2))))
    assert mask[-1, 0] > 0
    assert mask[-1, -1] == 0
    assert not mask[:170].any()


def test_a_shadow_that_ends_just_before_the_camera_is_cut() -> None:
    # Its corner at 10 um lies ten thousand million pixels to the left.
    outline = np.array([[-150.0, 1e-5], [-2.0, 20.0], [-9.0, 30.0]])
    whole = np.array([[-2.0, 20.0], [-9.0, 30.0], [-9.0, 20.0]])
    polygons = drawn(KITTI, np.concatenate((outline, whole)), np.array([3, 6]), 0.3)
    assert len(polygons) == 2
    assert (np.abs(polygons[0]) <= 8000 * 16 + 1).all()
    assert polygons[0][:, 0].max() == polygons[1][:, 0].max()


def test_it_is_darkest_beneath_the_car() -> None:
    mask = sun_taken(view_of(KITTI, (box(), at(KITTI, 0.0, 10.0))))
    u, v = np.round(KITTI.project(np.array([0.0, KITTI.height, 10.0]))).astype(int)
    assert mask[v, u] == 255
    assert len(np.unique(mask)) >= 4  # soft
