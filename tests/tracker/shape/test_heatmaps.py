"""From maps to points."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tracker.shape import decode
from tracker.shape.keypoints import chances

CELLS = 16


def hill(x: float, y: float, odds: float, spread: float = 0.8) -> np.ndarray:
    """The map of a keypoint at shares x, y whose odds of being seen are known."""
    v, u = np.mgrid[:CELLS, :CELLS]
    off = (u + 0.5 - x * CELLS) ** 2 + (v + 0.5 - y * CELLS) ** 2
    shape = np.exp(-0.5 * off / spread**2) + 1e-12
    return np.log(odds * shape / shape.sum()).astype(np.float32)[None, None]


def test_even_odds_in_one_cell_are_even_chances() -> None:
    maps = np.full((1, 1, 4, 4), -60.0, np.float32)
    maps[0, 0, 2, 1] = 0.0
    assert chances(maps)[0, 0, 2, 1] == pytest.approx(0.5)
    x, y, confidence = decode(maps)[0, 0]
    assert (x, y) == pytest.approx((1.5 / 4, 2.5 / 4))
    assert confidence == pytest.approx(0.5)


@given(st.floats(0.2, 0.8), st.floats(0.2, 0.8), st.floats(0.05, 100.0))
def test_a_hill_gives_its_place_and_its_chance(x: float, y: float, odds: float) -> None:
    found = decode(hill(x, y, odds))[0, 0]
    assert np.hypot(found[0] - x, found[1] - y) < 0.1 / CELLS  # a tenth of a cell
    assert found[2] == pytest.approx(odds / (1.0 + odds), abs=0.02)


def test_large_odds_do_not_overflow() -> None:
    maps = np.zeros((1, 2, 4, 4), np.float32)
    maps[0, 0, 1, 1], maps[0, 1] = 3e4, -3e4
    found = decode(maps)[0]
    assert np.isfinite(found).all()
    assert found[:, 2] == pytest.approx([1.0, 0.0])


def test_no_map_gives_no_point() -> None:
    assert decode(np.zeros((0, 36, CELLS, CELLS), np.float32)).shape == (0, 36, 3)
