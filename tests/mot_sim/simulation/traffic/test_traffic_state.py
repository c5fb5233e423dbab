"""Footprints of cars, and who touches whom."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from shapely import Polygon

from mot_sim.simulation.traffic import TrafficState, colliding_pairs, collisions
from mot_sim.simulation.traffic.traffic_state import outline
from tracker.geometry import polygon_area

coordinates, angles, sides = st.floats(-100, 100), st.floats(-7, 7), st.floats(0.5, 12)


def test_a_car_that_heads_along_x_has_its_right_side_at_larger_y() -> None:
    corners = outline(np.array([[10.0, 2.0, 0.0]]), np.array([[4.0, 1.5, 2.0]]))
    np.testing.assert_allclose(corners[0], [(12, 3), (12, 1), (8, 1), (8, 3)])


def test_a_car_that_heads_along_y_has_its_right_side_at_smaller_x() -> None:
    corners = outline(np.array([[0.0, 0.0, np.pi / 2]]), np.array([[4.0, 1.5, 2.0]]))
    np.testing.assert_allclose(corners[0], [(-1, 2), (1.0, 2), (1.0, -2), (-1, -2)], atol=1e-12)


@given(coordinates, coordinates, angles, sides, sides)
def test_outlines_keep_centre_and_area(x, y, heading, length, width) -> None:
    corners = outline(np.array([[x, y, heading]]), np.array([[length, 1.5, width]]))
    np.testing.assert_allclose(corners[0].mean(axis=0), (x, y), atol=1e-9)
    np.testing.assert_allclose(polygon_area(corners), length * width, rtol=1e-9)


def test_no_cars_have_no_outlines() -> None:
    assert outline(np.zeros((0, 3)), np.zeros((0, 3))).shape == (0, 4, 2)


SIZE = np.array([4.0, 1.5, 2.0])
rows = st.lists(
    st.tuples(st.floats(-6, 6), st.floats(-6, 6), st.floats(-7, 7)), min_size=2, max_size=6
)


def pairs(*poses: tuple[float, float, float]) -> list[list[int]]:
    return colliding_pairs(np.array(poses), np.tile(SIZE, (len(poses), 1))).tolist()


def test_cars_side_by_side_do_not_collide_until_they_overlap() -> None:
    assert pairs((0.0, 0.0, 0.0), (0.0, 2.0, 0.0)) == []
    assert pairs((0.0, 0.0, 0.0), (0.0, 1.9, 0.0)) == [[0, 1]]


def test_a_turned_corner_reaches_into_the_neighbour() -> None:
    assert pairs((0.0, 0.0, 0.0), (0.0, 2.2, 0.0)) == []
    assert pairs((0.0, 0.0, 0.0), (0.0, 2.2, 0.3)) == [[0, 1]]


@given(rows)
def test_pairs_are_those_whose_outlines_share_area(poses) -> None:
    size = np.tile(SIZE, (len(poses), 1))
    shapes = [Polygon(corners) for corners in outline(np.array(poses), size)]
    area = {
        (i, j): shapes[i].intersection(shapes[j]).area
        for i in range(len(poses))
        for j in range(i + 1, len(poses))
    }
    found = set(map(tuple, colliding_pairs(np.array(poses), size).tolist()))
    assert {pair for pair, shared in area.items() if shared > 1e-6} <= found
    assert all(area[pair] > -1e-6 for pair in found)
    assert all(shapes[i].distance(shapes[j]) < 1e-6 for i, j in found)


def test_nobody_collides_with_nobody() -> None:
    assert colliding_pairs(np.zeros((0, 3)), np.zeros((0, 3))).shape == (0, 2)


def test_the_ego_car_has_the_number_minus_one() -> None:
    at = np.array([1.0, 30.0])
    zero = np.zeros(2)
    state = TrafficState(
        0.0, np.array([7, 9]), at, zero, zero, zero, np.tile(SIZE, (2, 1)), np.zeros(3), SIZE
    )
    assert collisions(state).tolist() == [[-1, 7]]
