"""Means with their intervals: Student's, clipped to what is possible."""

from math import inf

import numpy as np
import pytest
from scipy.stats import t as student

from mot_sim.tables import NO_INTERVAL, Interval, few_seeds_note, limits_of


def test_an_interval_is_students() -> None:
    values = np.array([1.0, 2.0, 4.0, 7.0])
    found = Interval.of(values)
    low, high = student.interval(0.95, 3, values.mean(), values.std(ddof=1) / 2.0)
    assert (found.mean, found.count) == (3.5, 4)
    assert found.low == pytest.approx(low)
    assert found.high == pytest.approx(high)
    assert found.half == pytest.approx(high - 3.5)


def test_one_value_has_no_interval_and_none_has_no_mean() -> None:
    assert Interval.of(np.array([2.0])) == Interval(2.0, None, None, 1)
    assert Interval.of(np.zeros(0)) == NO_INTERVAL == Interval(None, None, None, 0)
    assert NO_INTERVAL.half is None


@pytest.mark.parametrize(
    ("score", "of_scores", "of_differences"),
    [
        ("HOTA", (0.0, 1.0), (-1.0, 1.0)),
        ("CLR_Re", (0.0, 1.0), (-1.0, 1.0)),
        ("MOTA", (-inf, 1.0), (-inf, inf)),
        ("IDSW", (0.0, inf), (-inf, inf)),
        ("FP_per_frame", (0.0, inf), (-inf, inf)),
    ],
)
def test_what_a_score_can_be(
    score: str, of_scores: tuple[float, float], of_differences: tuple[float, float]
) -> None:
    assert limits_of(score) == of_scores
    assert limits_of(score, is_difference=True) == of_differences


def test_intervals_are_clipped_to_what_is_possible() -> None:
    two = Interval.of(np.array([0.8, 1.0]), limits_of("HOTA"))
    assert two.mean == pytest.approx(0.9)
    assert (two.low, two.high) == (0.0, 1.0)
    switches = Interval.of(np.array([0.0, 2.0]), limits_of("IDSW"))
    assert switches.low == 0.0
    assert switches.high == switches.mean + switches.half == pytest.approx(1.0 + 12.7062)  # type: ignore[operator]
    less = Interval.of(np.array([-0.9, 0.9]), limits_of("HOTA", is_difference=True))
    assert (less.low, less.high) == (-1.0, 1.0)
    accuracy = Interval.of(np.array([-0.5, 0.9]), limits_of("MOTA"))
    assert accuracy.high == 1.0
    assert accuracy.low is not None
    assert accuracy.low < -1.0


def test_few_seeds_are_called_too_few() -> None:
    told = "2 seeds: too few for an interval to mean much; 5 or more are better."
    assert few_seeds_note([8, 2, 0]) == told
    assert few_seeds_note([1]) == "1 seed: too few for an interval; 5 or more are better."
    assert few_seeds_note([5, 8], "drive") == few_seeds_note([]) == few_seeds_note([0]) == ""
