"""The triangles before the near plane that face the camera."""

import numpy as np
import pytest
import shapely
from hypothesis import assume, given
from hypothesis import strategies as st

from mot_sim.simulation.renderers import MeshInstances
from mot_sim.simulation.renderers.triangles import (
    Triangles,
    boxes_inside,
    cut_near,
    side_planes,
    sphere_in_view,
)
from tests.mot_sim.simulation.renderers.shapes import CROOKED, KITTI, at, box, lump, view_of, wedge

NEAR = 0.3
FAR = np.array([100.0, 80.0])


def area(corners: np.ndarray) -> np.ndarray:
    a, b, c = corners.swapaxes(0, 1)
    return 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1)


def test_no_object_gives_no_triangle() -> None:
    triangles = Triangles.of(MeshInstances.empty(), KITTI, NEAR)
    assert len(triangles) == 0
    assert triangles.slices(0).shape == (0, 2)


def test_of_a_box_straight_ahead_only_rear_and_roof_face_the_camera() -> None:
    view = view_of(KITTI, (box(4.0, 1.5, 1.8), at(KITTI, 0.0, 12.0, -np.pi / 2)))
    triangles = Triangles.of(view.instances, KITTI, NEAR)
    assert len(triangles) == 4
    assert np.unique(triangles.corners[..., 2].max(axis=1).round(6)).tolist() == [10.0, 14.0]


def test_an_object_behind_the_camera_or_beside_the_view_has_no_triangle() -> None:
    places = [at(KITTI, 0.0, -9.0), at(KITTI, 40.0, 10.0), at(KITTI, -40.0, 10.0)]
    view = view_of(KITTI, *((lump(), place) for place in places))
    assert not sphere_in_view(view.instances, KITTI, NEAR).any()
    assert len(Triangles.of(view.instances, KITTI, NEAR)) == 0


def test_objects_keep_their_order_and_their_slices() -> None:
    places = [at(KITTI, 0.0, 20.0), at(KITTI, 0.0, -9.0), at(KITTI, 3.0, 30.0)]
    view = view_of(KITTI, *((wedge(), place) for place in places))
    triangles = Triangles.of(view.instances, KITTI, NEAR)
    (_, a), (b, c), (d, e) = triangles.slices(3).tolist()
    assert a == b == c == d
    assert e == len(triangles)
    assert (np.diff(triangles.objects) >= 0).all()


def test_the_view_has_four_sides_that_face_its_middle() -> None:
    middle = CROOKED.rays(np.array([[61.0, 48.0]]))
    assert (middle @ side_planes(CROOKED).T > 0.0).all()
    outside = CROOKED.rays(np.array([[-0.6, 48.0], [122.6, 48.0], [61.0, -0.6], [61.0, 96.6]]))
    assert ((outside @ side_planes(CROOKED).T).min(axis=1) < 0.0).all()


@pytest.mark.parametrize(
    ("depths", "pieces", "share"),
    [
        ((1.0, 1.0, 1.0), 1, 1.0),
        ((-1.0, -1.0, -1.0), 0, 0.0),
        ((-1.0, 1.0, 1.0), 2, 0.75),  # half of both edges is cut: a quarter of the area
        ((1.0, -1.0, 1.0), 2, 0.75),
        ((-1.0, -1.0, 1.0), 1, 0.25),
        ((-1.0, 1.0, -1.0), 1, 0.25),
    ],
)
def test_a_triangle_is_cut_at_the_near_plane(depths, pieces, share) -> None:
    corners = np.array([[[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [0.0, 2.0, 0.0]]])
    corners[0, :, 2] = depths
    cut, source = cut_near(corners, 0.0)
    assert len(cut) == pieces
    assert (source == 0).all()
    assert (cut[..., 2] >= 0.0).all()
    assert area(cut).sum() == pytest.approx(share * area(corners)[0])
    turn = np.cross(cut[:, 1] - cut[:, 0], cut[:, 2] - cut[:, 0])
    before = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    assert ((turn * before).sum(axis=1) > 0.0).all()  # still the same way round


def test_an_object_that_crosses_the_near_plane_is_cut_there() -> None:
    view = view_of(KITTI, (box(), at(KITTI, -1.6, 1.0, np.pi / 2)))
    triangles = Triangles.of(view.instances, KITTI, NEAR)
    assert len(triangles) > 0
    assert triangles.corners[..., 2].min() == NEAR


@pytest.mark.parametrize(
    ("triangle", "inside"),
    [
        (((10, 10), (50, 20), (30, 60)), (10, 10, 50, 60)),
        # From its only corner inside it opens to the right: at u = 100 it is 40 pixels high.
        (((60, 40), (160, 90), (160, -10)), (60, 20, 100, 60)),
        (((50, -40), (90, 40), (10, 40)), (10, 0, 90, 40)),
        # No edge is inside: the whole rectangle is covered.
        (((-300, -200), (400, -200), (50, 900)), (0, 0, 100, 80)),
        # No corner is inside: the line u + v = 40 cuts off the rectangle's first corner.
        (((-60, 100), (100, -60), (-60, -60)), (0, 0, 40, 40)),
        (((-60, 100), (100, -60), (200, 200)), (0, 0, 100, 80)),
    ],
)
def test_the_boxes_inside_is_that_of_the_part_inside(triangle, inside) -> None:
    for turned in (triangle, triangle[::-1]):
        found = boxes_inside(np.array([turned], float), FAR)
        assert found == pytest.approx(np.array([inside], float))


def test_a_triangle_past_a_corner_of_the_image_is_not_inside_it() -> None:
    past = np.array([[(-50.0, 20.0), (20.0, -50.0), (-60.0, -60.0)]])
    within = np.array([[(70.0, 50.0), (80.0, 50.0), (75.0, 60.0)]])
    found = boxes_inside(np.concatenate((past, within)), FAR)
    assert found.tolist() == [[np.inf, np.inf, -np.inf, -np.inf], [70.0, 50.0, 80.0, 60.0]]
    assert boxes_inside(past[:0], FAR).shape == (0, 4)


@given(st.tuples(*[st.integers(-150, 250)] * 6))
def test_the_box_inside_is_that_of_the_polygon_cut(corners) -> None:
    triangle = np.array(corners, float).reshape(3, 2)
    assume(shapely.Polygon(triangle).area > 1.0)
    cut = shapely.Polygon(triangle).intersection(shapely.box(0.0, 0.0, *FAR))
    (found,) = boxes_inside(triangle[None], FAR)
    if cut.is_empty:
        assert np.isinf(found).all()
    else:
        np.testing.assert_allclose(found, cut.bounds, atol=1e-6)
