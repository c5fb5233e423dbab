"""Score maps: from a detector's scores to probabilities."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mot_sim.datasets import ScoreMap
from tracker.errors import BadConfig


def test_half_of_the_boxes_at_the_midpoint_are_right() -> None:
    expected = [0.5, 1.0 / (1.0 + np.exp(-1.0)), 1.0 / (1.0 + np.exp(1.0))]
    np.testing.assert_allclose(ScoreMap(3.0, 2.0)(np.array([3.0, 5.0, 1.0])), expected)


@given(st.lists(st.floats(-1e6, 1e6), max_size=20), st.floats(-10, 10), st.floats(1e-3, 100))
def test_mapped_scores_are_probabilities_in_the_same_order(
    scores: list[float], midpoint: float, scale: float
) -> None:
    mapped = ScoreMap(midpoint, scale)(np.sort(np.array(scores)))
    assert ((mapped >= 0.0) & (mapped <= 1.0)).all()
    assert (np.diff(mapped) >= 0.0).all()


def test_a_map_is_read_from_two_numbers() -> None:
    assert ScoreMap.parse("2.43, 1.24") == ScoreMap(2.43, 1.24)


@pytest.mark.parametrize("text", ["", "1", "1,2,3", "a,b", "1,0", "1,-2", "nan,1", "1,inf"])
def test_anything_else_is_refused_with_the_text(text: str) -> None:
    with pytest.raises(BadConfig, match=r"score map"):
        ScoreMap.parse(text)
