"""Grids, one axis at a time, drawn points, and how axes are written."""

import numpy as np
import pytest

from mot_sim.experiments.sweep.points import Range, parse_axis, points_of
from tracker.errors import BadConfig

AXES = {"a": (0, 1), "b": (2.0, 3.0, 4.0)}
WHOLE = {"a": True, "b": False, "c": True}


def test_a_grid_has_all_combinations_the_last_axis_fastest() -> None:
    points = points_of(AXES, "grid", 0, WHOLE)
    assert len(points) == 6
    assert points[:2] == ({"a": 0, "b": 2.0}, {"a": 0, "b": 3.0})


def test_one_at_a_time_sets_one_axis() -> None:
    points = points_of(AXES, "one_at_a_time", 0, WHOLE)
    assert points == ({"a": 0}, {"a": 1}, {"b": 2.0}, {"b": 3.0}, {"b": 4.0})


def test_drawn_points_fill_every_stratum_of_every_axis() -> None:
    axes = {"b": Range(0.0, 1.0), "c": Range(1.0, 9.0), "a": (5, 6)}
    points = points_of(axes, "random", 10, WHOLE)
    strata = sorted(int(10 * float(point["b"])) for point in points)
    assert strata == list(range(10))
    assert [type(point["c"]) for point in points] == [int] * 10
    assert sorted(point["a"] for point in points) == [5] * 5 + [6] * 5


def test_one_more_axis_leaves_the_drawn_levels_of_the_others() -> None:
    alone = points_of({"b": Range(0.0, 1.0)}, "random", 5, WHOLE)
    both = points_of({"c": Range(0.0, 1.0), "b": Range(0.0, 1.0)}, "random", 5, WHOLE)
    assert [point["b"] for point in alone] == [point["b"] for point in both]


def test_a_logarithmic_range_has_its_geometric_mean_in_the_middle() -> None:
    assert Range(0.01, 1.0, log=True).at(0.5) == pytest.approx(0.1)
    assert Range(0.0, 3.0).at(0.5) == pytest.approx(1.5)


@pytest.mark.parametrize(
    ("text", "levels"),
    [
        ("a.b=0,0.5,1", (0, 0.5, 1)),
        (" a.b = true , no ", (True, "no")),
        ("a.b=0..3", Range(0.0, 3.0)),
        ("a.b=0.1..10 log", Range(0.1, 10.0, log=True)),
    ],
)
def test_an_axis_is_read_as_it_is_written(text: str, levels: object) -> None:
    assert parse_axis(text) == ("a.b", levels)


@pytest.mark.parametrize("text", ["a", "=1", "a=", "a=1,,2", "a=x..y", "a=3..1", "a=0..1 log"])
def test_an_axis_that_is_none_is_refused(text: str) -> None:
    with pytest.raises(BadConfig, match=r"--axis|range"):
        parse_axis(text)


def test_ranges_end_somewhere() -> None:
    with pytest.raises(BadConfig, match="low below high"):
        Range(0.0, np.inf)
