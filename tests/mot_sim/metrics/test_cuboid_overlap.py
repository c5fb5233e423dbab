"""Intersection over union of cuboids by hand, and what moves of both leave alone."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mot_sim.metrics.cuboid_overlap import Criterion, cuboid_iou
from tests.mot_sim.metrics.cuboid_cases import AHEAD, cuboids
from tracker.errors import BadConfig
from tracker.geometry import rotation_y
from tracker.types import Cuboids

NUMBERS = st.floats(-3.0, 3.0)
CARS = st.tuples(NUMBERS, NUMBERS, NUMBERS, *[st.floats(0.5, 6.0)] * 3)


def iou(a: tuple, b: tuple) -> float:
    return float(cuboid_iou(cuboids([a]), cuboids([b]))[0])


@pytest.mark.parametrize(
    ("other", "expected"),
    [
        ((0.0, 10.0), 1.0),
        ((0.0, 12.0), 1 / 3),  # half a length ahead
        ((1.0, 10.0), 1 / 3),  # half a width aside
        ((0.0, 10.0, 0.0), 1 / 3),  # across: 2 x 2 m of 4 x 2 m
        ((0.0, 10.0, AHEAD, 4.0, 0.75, 2.0), 0.5),  # half as high
        ((0.0, 10.0, AHEAD, 2.0, 1.5, 1.0), 0.25),  # inside
        ((0.0, 14.0), 0.0),  # bumper to bumper
        ((0.0, 30.0), 0.0),
    ],
)
def test_overlap_by_hand(other: tuple, expected: float):
    assert iou((0.0, 10.0), other) == pytest.approx(expected, abs=1e-12)


def test_a_square_turned_by_45_degrees_shares_an_octagon():
    octagon = 2.0 * (np.sqrt(2.0) - 1.0)
    turned = iou((0.0, 9.0, 0.0, 1.0, 1.0, 1.0), (0.0, 9.0, np.pi / 4, 1.0, 1.0, 1.0))
    assert turned == pytest.approx(octagon / (2.0 - octagon), abs=1e-12)


def test_cuboids_above_each_other_share_what_their_heights_share():
    a = cuboids([(0.0, 10.0)])
    raised = Cuboids(a.base - [[0.0, 0.5, 0.0]], a.yaw, a.size)
    assert cuboid_iou(a, raised)[0] == pytest.approx(1.0 / 2.0, abs=1e-12)  # 1 m of 1.5 m
    above = Cuboids(a.base - [[0.0, 1.5, 0.0]], a.yaw, a.size)
    assert cuboid_iou(a, above)[0] == 0.0


@pytest.mark.parametrize("column", range(6))
def test_what_is_not_known_shares_nothing(column: int):
    row = np.array([0.0, 10.0, AHEAD, 4.0, 1.5, 2.0])
    row[column] = np.nan
    assert iou(tuple(row.tolist()), (0.0, 10.0)) == 0.0


def test_no_cuboids_have_no_overlap():
    assert cuboid_iou(Cuboids.empty(), Cuboids.empty()).shape == (0,)


@given(a=CARS, b=CARS)
def test_overlap_is_symmetric_and_at_most_the_ratio_of_volumes(a: tuple, b: tuple):
    sizes = sorted([np.prod(a[3:]), np.prod(b[3:])])
    assert 0.0 <= iou(a, b) <= sizes[0] / sizes[1] + 1e-9
    assert iou(a, b) == pytest.approx(iou(b, a), abs=1e-9)


@given(a=CARS, b=CARS)
def test_a_heading_off_by_pi_makes_no_difference(a: tuple, b: tuple):
    backwards = (*a[:2], a[2] + np.pi, *a[3:])
    assert iou(backwards, b) == pytest.approx(iou(a, b), abs=1e-9)


@given(a=CARS, b=CARS, turn=NUMBERS)
def test_a_turn_of_both_makes_no_difference(a: tuple, b: tuple, turn: float):
    def turned(car: tuple) -> tuple:
        x, _, z = rotation_y(turn) @ [car[0], 0.0, car[1]]
        return (x, z, car[2] + turn, *car[3:])

    assert iou(turned(a), turned(b)) == pytest.approx(iou(a, b), abs=1e-9)


@pytest.mark.parametrize(("text", "name"), [(".25", "0.25"), ("1", "1"), ("0.5 M", "0.5m")])
def test_criteria_are_read_from_text(text: str, name: str):
    assert Criterion.parse(text).name == name


@pytest.mark.parametrize("text", ["0", "1.01", "-.5", "nan", "inf", "0m", "-1m", "infm", "nanm"])
def test_a_threshold_that_nothing_or_everything_meets_is_refused(text: str):
    with pytest.raises(BadConfig, match=r"write \.25 for IoU"):
        Criterion.parse(text)


@pytest.mark.parametrize("text", ["", "m", "quarter", "2 metres"])
def test_a_threshold_that_is_no_number_is_refused(text: str):
    with pytest.raises(BadConfig, match=r"write \.25 for IoU"):
        Criterion.parse(text)


def test_similarity_by_distance_is_half_at_the_threshold():
    criterion = Criterion("distance", 2.0)
    here = cuboids([(0.0, 10.0)] * 4)
    there = cuboids([(0.0, 10.0), (0.0, 12.0), (3.0, 10.0), (0.0, 20.0)])
    np.testing.assert_allclose(criterion.similarity(here, there), [1.0, 0.5, 0.25, 0.0])
    assert criterion.precision(0.5) == 2.0
    unknown = Cuboids(np.full((1, 3), np.nan), np.zeros(1), np.ones((1, 3)))
    assert criterion.similarity(unknown, here.select([0]))[0] == 0.0
