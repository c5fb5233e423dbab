"""Folds: alike in what makes tracking hard, the same every time."""

from itertools import product

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mot_sim.experiments.tuning.folds import (
    TRAITS,
    balanced_folds,
    box_motion,
    imbalance,
    shares_of,
    traits_of,
)
from tracker.errors import BadConfig
from tracker.types import Tracks


def drives(*sizes: float) -> np.ndarray:
    """Drives that hold so much of every trait."""
    return np.repeat(np.array(sizes, float)[:, None], len(TRAITS), axis=1)


def test_drives_are_divided_into_equal_halves_where_that_can_be() -> None:
    sizes = drives(5, 4, 3, 2, 1, 1)
    folds = balanced_folds(sizes, 2)
    assert [sizes[folds == fold][:, 0].sum() for fold in (0, 1)] == [8.0, 8.0]


def test_traits_are_balanced_beside_mere_size() -> None:
    traits = drives(1, 1, 1, 1)
    traits[:, TRAITS.index("occluded")] = (9, 9, 1, 1)
    folds = balanced_folds(traits, 2)
    assert folds[0] != folds[1]
    assert folds[2] != folds[3]


@given(
    st.lists(st.lists(st.integers(0, 50), min_size=6, max_size=6), min_size=4, max_size=6),
    st.integers(2, 3),
)
def test_no_move_and_no_swap_would_balance_better(rows: list[list[int]], count: int) -> None:
    traits = np.array(rows, float) + 1.0
    folds, shares = balanced_folds(traits, count), shares_of(traits)
    assert set(folds.tolist()) <= set(range(count))
    found = imbalance(folds, shares)
    for drive, fold in product(range(len(traits)), range(count)):
        moved = folds.copy()
        moved[drive] = fold
        assert imbalance(moved, shares) >= found - 1e-9
    np.testing.assert_array_equal(folds, balanced_folds(traits, count))


def test_a_drive_without_counted_cars_makes_no_fold() -> None:
    traits = drives(3, 2, 0)
    assert len(balanced_folds(traits, 2)) == 3
    with pytest.raises(BadConfig, match="3 folds, but only 2 of 3 sequences hold counted cars"):
        balanced_folds(traits, 3)


def test_one_fold_is_refused() -> None:
    with pytest.raises(BadConfig, match="1 folds: give 2 or more"):
        balanced_folds(drives(1, 1), 1)


def car(frames: list[int], boxes: list[list[float]], **columns: object) -> Tracks:
    return Tracks(np.array(frames), np.zeros(len(frames), np.int64), np.array(boxes), **columns)


def test_motion_is_counted_in_heights_of_the_box_between_neighbouring_frames() -> None:
    boxes = [[0.0, 0, 20, 10], [30.0, 0, 50, 20], [30.0, 0, 50, 40]]
    approaching, sideways = box_motion(car([0, 1, 3], boxes))  # frame 2 is missing
    assert approaching == pytest.approx(np.log(2.0))
    assert sideways == pytest.approx(30.0 / 20.0)


def test_traits_count_what_kitti_counts() -> None:
    boxes = [[0.0, 0, 20, 10]] * 4
    levels = {"occlusion": np.array([0, 2, 3, 0]), "truncation": np.array([0, 0, 0, 1])}
    kinds = np.array(["Car"] * 4)
    found = dict(
        zip(TRAITS, traits_of(car([0, 1, 2, 3], boxes, kinds=kinds, **levels)), strict=True)
    )
    assert found["boxes"] == 2  # not the one with occlusion 3, nor the truncated one
    assert found["cars"] == 1
    assert found["occluded"] == 2
    assert found["truncated"] == 1
    assert (traits_of(Tracks.empty()) == 0.0).all()
