"""Peeling off the obvious pairs finds the same matching as solving every frame."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import linear_sum_assignment

from benchmarks.metrics.cases import random_case, tracks
from mot_sim.metrics import matching
from mot_sim.metrics.matching import best_rival, match, peel
from mot_sim.metrics.overlaps import Overlaps
from mot_sim.metrics.preprocessing import prepare_sequence

BOX = (0.0, 0.0, 40.0, 30.0)


def solve_every_frame(overlaps: Overlaps, weights: np.ndarray) -> set[int]:
    """The chosen pairs of the plain Hungarian algorithm, frame by frame."""
    chosen = set()
    for frame in np.unique(overlaps.frames):
        rows = np.flatnonzero(overlaps.truth.frames == frame)
        columns = np.flatnonzero(overlaps.output.frames == frame)
        pairs = np.flatnonzero(overlaps.frames == frame)
        matrix = np.zeros((len(rows), len(columns)))
        index = np.full(matrix.shape, -1)
        where = overlaps.rows[pairs] - rows[0], overlaps.columns[pairs] - columns[0]
        matrix[where], index[where] = weights[pairs], pairs
        chosen |= set(index[linear_sum_assignment(-matrix)].tolist()) - {-1}
    return chosen


@given(st.integers(0, 100_000))
def test_matching_is_that_of_the_hungarian_algorithm_ties_included(seed: int):
    case = random_case(seed)
    overlaps = prepare_sequence(case.truth, case.output, case.frame_count).overlaps
    chosen = match(overlaps, np.arange(len(overlaps.iou)), overlaps.iou)
    assert set(chosen.tolist()) == solve_every_frame(overlaps, overlaps.iou)


def test_an_unrivalled_pair_is_certain():
    chosen, unclear = peel(np.array([0, 1]), np.array([0, 1]), np.array([0.1, 0.9]))
    assert chosen.all()
    assert not unclear.any()


def test_a_chain_peels_from_its_heavy_end():
    # 0-0 outweighs its only rival 1-0; without column 0, pair 1-1 stands alone.
    rows, columns = np.array([0, 1, 1]), np.array([0, 0, 1])
    chosen, unclear = peel(rows, columns, np.array([0.9, 0.8, 0.05]))
    assert chosen.tolist() == [True, False, True]
    assert not unclear.any()


def test_a_tie_is_left_to_the_solver():
    chosen, unclear = peel(np.array([0, 0]), np.array([0, 1]), np.array([0.5, 0.5]))
    assert not chosen.any()
    assert unclear.all()


def test_the_best_pair_may_lose_to_two_others():
    overlaps = Overlaps.between(
        tracks([(0, 1, BOX), (0, 2, BOX)]), tracks([(0, 5, BOX), (0, 6, BOX)])
    )
    chosen = match(overlaps, np.arange(4), np.array([0.9, 0.8, 0.8, 0.1]))
    assert chosen.tolist() == [1, 2]


def test_best_rival_is_the_best_of_the_others():
    rivals = best_rival(np.array([0, 0, 0, 2, 3, 3]), np.array([1.0, 3.0, 2.0, 5.0, 4.0, 4.0]))
    assert rivals.tolist() == [3.0, 2.0, 3.0, 0.0, 4.0, 4.0]


def test_frames_without_a_choice_are_never_solved(monkeypatch):
    def refuse(*_: object, **__: object) -> None:
        raise AssertionError("solved a frame that holds no choice")

    monkeypatch.setattr(matching, "linear_sum_assignment", refuse)
    rows = [
        (frame, name, (90.0 * name, 0.0, 90.0 * name + 80.0, 40.0))
        for frame in range(5)
        for name in range(3)
    ]
    overlaps = Overlaps.between(tracks(rows), tracks(rows))
    assert len(match(overlaps, np.arange(15), overlaps.iou)) == 15


def test_no_pair_gives_no_match():
    overlaps = Overlaps.between(tracks([]), tracks([(0, 1, BOX)]))
    assert len(match(overlaps, np.zeros(0, dtype=np.int64), np.zeros(0))) == 0
