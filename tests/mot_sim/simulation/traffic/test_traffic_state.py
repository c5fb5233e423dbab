"""One moment of traffic: outlines of cars."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

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
