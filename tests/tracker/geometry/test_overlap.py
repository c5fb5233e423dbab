"""Overlaps of boxes and of convex polygons."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tracker.geometry import box_intersection, box_iou, convex_intersection, polygon_area

boxes = st.tuples(*[st.floats(-50, 50)] * 2, *[st.floats(0, 60)] * 2).map(
    lambda b: np.array([b[0], b[1], b[0] + b[2], b[1] + b[3]])
)


def rectangle(x: float, z: float, length: float, width: float, yaw: float) -> np.ndarray:
    c, s = np.cos(yaw), np.sin(yaw)
    corners = np.array([[1, 1], [-1, 1], [-1, -1], [1, -1]]) * [length / 2, width / 2]
    return corners @ np.array([[c, s], [-s, c]]) + [x, z]


rectangles = st.builds(
    rectangle,
    st.floats(-3, 3),
    st.floats(-3, 3),
    st.floats(0.5, 6),
    st.floats(0.5, 6),
    st.floats(-4, 4),
)


def test_half_overlapping_boxes_have_an_iou_of_one_third() -> None:
    a, b = np.array([[0.0, 0, 10, 10]]), np.array([[5.0, 0, 15, 10]])
    assert box_intersection(a, b) == pytest.approx(50.0)
    assert box_iou(a, b) == pytest.approx(1 / 3)


def test_touching_boxes_share_nothing() -> None:
    assert box_iou(np.array([[0.0, 0, 1, 1]]), np.array([[1.0, 0, 2, 1]])) == 0.0


def test_boxes_without_area_overlap_nothing_not_even_themselves() -> None:
    point = np.array([[3.0, 3.0, 3.0, 3.0]])
    assert box_iou(point, point) == 0.0


def test_every_pair_by_broadcasting() -> None:
    a, b = np.zeros((3, 4)), np.zeros((5, 4))
    assert box_iou(a[:, None], b[None]).shape == (3, 5)
    assert box_iou(a[:0, None], b[None]).shape == (0, 5)


@given(boxes, boxes)
def test_iou_is_symmetric_and_between_0_and_1(a: np.ndarray, b: np.ndarray) -> None:
    iou = box_iou(a[None], b[None])[0]
    assert 0.0 <= iou <= 1.0 + 1e-12
    assert iou == box_iou(b[None], a[None])[0]


@given(boxes)
def test_a_box_with_area_overlaps_itself_wholly(box: np.ndarray) -> None:
    if (box[2:] - box[:2]).min() > 1e-3:
        assert box_iou(box[None], box[None])[0] == pytest.approx(1.0)


def test_crossed_rectangles_share_the_square_in_the_middle() -> None:
    a, b = rectangle(0, 0, 4, 2, 0.0)[None], rectangle(0, 0, 4, 2, np.pi / 2)[None]
    assert convex_intersection(a, b) == pytest.approx(4.0)


@given(rectangles, rectangles)
def test_shared_area_is_symmetric_and_at_most_the_smaller(a: np.ndarray, b: np.ndarray) -> None:
    shared = convex_intersection(a[None], b[None])[0]
    assert shared == pytest.approx(convex_intersection(b[None], a[None])[0], abs=1e-9)
    smaller = min(polygon_area(a[None])[0], polygon_area(b[None])[0])
    assert -1e-9 <= shared <= smaller + 1e-9


@given(rectangles, rectangles)
def test_shared_area_equals_a_count_of_grid_points(a: np.ndarray, b: np.ndarray) -> None:
    axis = np.linspace(-8, 8, 160)
    grid = np.stack(np.meshgrid(axis, axis), axis=-1).reshape(-1, 2)
    inside = np.ones(len(grid), bool)
    for polygon in (a, b):
        edges = np.roll(polygon, -1, axis=0) - polygon
        to_point = grid[:, None] - polygon
        side = edges[:, 0] * to_point[..., 1] - edges[:, 1] * to_point[..., 0]
        inside &= (side >= 0).all(axis=1) | (side <= 0).all(axis=1)
    cell = (axis[1] - axis[0]) ** 2
    assert convex_intersection(a[None], b[None])[0] == pytest.approx(inside.sum() * cell, abs=2.0)


def grid_rectangles(rng: np.random.Generator, count: int) -> tuple[np.ndarray, np.ndarray]:
    """Pairs with one yaw, on half a metre's grid: shared sides and corners, and no area."""
    signs = np.array([[1, 1], [-1, 1], [-1, -1], [1, -1]]) / 2
    sides, offset = rng.integers(0, 5, (2, count, 2)), rng.integers(-6, 7, (count, 2)) / 2
    yaw, turned = rng.choice([0.0, 0.4, np.pi / 2], count), rng.choice([1, -1], count)
    turn = np.array([[np.cos(yaw), np.sin(yaw)], [-np.sin(yaw), np.cos(yaw)]]).transpose(2, 0, 1)
    a, b = signs * sides[0][:, None], signs * sides[1][:, None] + offset[:, None]
    b = np.where(turned[:, None, None] > 0, b, b[:, ::-1])
    return a @ turn + [300.0, -40.0], b @ turn + [300.0, -40.0]


def test_areas_are_shapelys() -> None:
    shapely = pytest.importorskip("shapely")
    rng = np.random.default_rng(0)
    a, b = grid_rectangles(rng, 300)
    free = [np.stack([rectangle(*rng.uniform(0.5, 4, 5)) for _ in range(300)]) for _ in range(2)]
    for one, other in ((a, b), free, (b, b), (a[:, :3], b)):
        expected = shapely.area(
            shapely.intersection(shapely.polygons(one), shapely.polygons(other))
        )
        assert (expected > 0.1).sum() > 30
        np.testing.assert_allclose(convex_intersection(one, other), expected, atol=1e-11)


def test_what_is_not_known_shares_nothing() -> None:
    square = rectangle(0, 0, 2, 2, 0.0)[None]
    unknown = np.full((1, 4, 2), np.nan)
    assert convex_intersection(square, unknown) == convex_intersection(unknown, square) == 0.0


def test_no_polygons_share_nothing() -> None:
    assert convex_intersection(np.zeros((0, 4, 2)), np.zeros((0, 4, 2))).shape == (0,)
