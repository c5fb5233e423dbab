"""Eq. 1 by hand, there and back."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tracker.errors import BadConfig, UnknownName
from tracker.shape import ShapeBasis

# Two points; the first vector lengthens, the second lifts the front point.
BASIS = ShapeBasis(
    ("front", "rear"),
    np.array([[2.0, 0.0, 0.0], [-2.0, 0.0, 0.0]]),
    np.array([[[1.0, 0, 0], [-1.0, 0, 0]], [[0, -1.0, 0], [0, 0, 0]]]),
    np.array([0.5, 0.1]),
)
numbers = st.floats(-10.0, 10.0)


def test_a_shape_is_the_mean_plus_the_weighted_vectors() -> None:
    shape = BASIS.shape(np.array([0.5, 2.0]))
    assert shape.tolist() == [[2.5, -2.0, 0.0], [-2.5, 0.0, 0.0]]


@given(numbers, numbers)
def test_the_coefficients_of_a_shape_come_back(first: float, second: float) -> None:
    lambdas = np.array([[first, second]])
    np.testing.assert_allclose(BASIS.project(BASIS.shape(lambdas)), lambdas, atol=1e-9)


@given(st.lists(numbers, min_size=6, max_size=6))
def test_what_a_projection_leaves_is_square_to_every_vector(values: list[float]) -> None:
    points = np.reshape(values, (2, 3))
    rest = points - BASIS.shape(BASIS.project(points))
    np.testing.assert_allclose(np.tensordot(BASIS.vectors, rest, 2), 0.0, atol=1e-9)


def test_no_car_and_no_coefficient_work_everywhere() -> None:
    assert BASIS.shape(np.zeros((0, 2))).shape == (0, 2, 3)
    assert BASIS.project(np.zeros((0, 2, 3))).shape == (0, 2)
    rigid = BASIS.first(0)
    assert rigid.project(np.ones((4, 2, 3))).shape == (4, 0)
    np.testing.assert_array_equal(rigid.shape(np.zeros(0)), BASIS.mean)


def test_a_selection_keeps_the_coefficients_and_the_order_asked_for() -> None:
    swapped = BASIS.select(["rear", "front"])
    lambdas = np.array([0.3, -1.0])
    np.testing.assert_array_equal(swapped.shape(lambdas), BASIS.shape(lambdas)[::-1])
    with pytest.raises(UnknownName, match=r"unknown point 'fron'.*Did you mean 'front'"):
        BASIS.select(["fron"])


def test_scaling_scales_every_shape() -> None:
    lambdas = np.array([1.0, 1.0])
    np.testing.assert_allclose(BASIS.scaled(3.0).shape(lambdas), 3.0 * BASIS.shape(lambdas))


def test_more_coefficients_than_there_are_is_said() -> None:
    assert BASIS.first(1).std is not None
    with pytest.raises(BadConfig, match="3 shape coefficients: this basis has 0 to 2"):
        BASIS.first(3)
