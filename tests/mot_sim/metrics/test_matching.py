"""Pairs of one frame, and what the door turns away."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import linear_sum_assignment

from benchmarks.metrics.cases import random_case, tracks
from mot_sim.metrics.matching import Overlaps, bare_rows, best_rival, match, peel, same_frame_pairs
from mot_sim.metrics.preprocessing import prepare_sequence
from tracker.errors import BadTracks
from tracker.types import Tracks

BOX = (0.0, 0.0, 40.0, 30.0)


def test_pairs_are_all_those_of_one_frame():
    a, b = np.array([0, 0, 2, 5]), np.array([0, 1, 2, 2])
    rows, columns = same_frame_pairs(a, b)
    assert list(zip(rows.tolist(), columns.tolist(), strict=True)) == [
        (0, 0),
        (1, 0),
        (2, 2),
        (2, 3),
    ]


def test_nothing_pairs_with_nothing():
    nothing = np.zeros(0, dtype=np.int64)
    for a, b in ((nothing, nothing), (nothing, np.arange(3)), (np.arange(3), nothing)):
        rows, columns = same_frame_pairs(a, b)
        assert len(rows) == len(columns) == 0


def test_only_boxes_that_touch_are_kept_as_pairs():
    truth = tracks([(0, 1, BOX), (0, 2, (100.0, 0.0, 140.0, 30.0))])
    output = tracks([(0, 7, BOX), (0, 8, (20.0, 0.0, 60.0, 30.0))])
    overlaps = Overlaps.between(truth, output)
    assert overlaps.rows.tolist() == [0, 0]
    np.testing.assert_allclose(overlaps.iou, [1.0, 1.0 / 3.0])


def test_kept_rows_are_renumbered_with_their_pairs():
    truth = tracks([(0, 9, BOX), (1, 4, BOX), (2, 9, BOX)])
    output = tracks([(0, 70, BOX), (1, 70, BOX), (2, 60, BOX)])
    left = Overlaps.between(truth, output).keep(
        np.array([False, True, True]), np.array([True, True, True])
    )
    assert left.truth.ids.tolist() == [0, 1]
    assert left.output.ids.tolist() == [1, 1, 0]
    assert left.rows.tolist() == [0, 1]
    assert left.columns.tolist() == [1, 2]
    assert left.id_counts == (2, 2)


@pytest.mark.parametrize("frame", [-1, 5, 99])
def test_a_frame_outside_the_sequence_is_named(frame: int):
    table = tracks([(0, 1, BOX), (frame, 2, BOX)])
    with pytest.raises(BadTracks, match=f"output: frame {frame} is outside"):
        bare_rows(table, np.ones(2, dtype=bool), 5, "output")


def test_a_box_that_is_not_finite_is_named():
    table = tracks([(0, 1, BOX), (3, 2, (0.0, np.nan, 1.0, 1.0))])
    with pytest.raises(BadTracks, match=r"nan.* of id 2 in frame 3 is not finite"):
        bare_rows(table, np.ones(2, dtype=bool), 5, "output")


def test_an_id_twice_in_a_frame_is_named():
    table = tracks([(3, 2, BOX), (3, 2, BOX)])
    with pytest.raises(BadTracks, match="output: id 2 stands twice in frame 3"):
        bare_rows(table, np.ones(2, dtype=bool), 5, "output")


def test_rows_come_back_in_the_order_of_frames():
    table = tracks([(3, 2, BOX), (1, 5, BOX), (3, 1, BOX), (0, 9, BOX)])
    ordered = bare_rows(table, np.ones(4, dtype=bool), 5, "output")
    assert ordered.frames.tolist() == [0, 1, 3, 3]
    assert ordered.ids.tolist() == [9, 5, 2, 1]


def test_no_row_is_a_table_too():
    assert len(bare_rows(Tracks.empty(), np.zeros(0, dtype=bool), 0, "output")) == 0


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

    monkeypatch.setattr("scipy.optimize.linear_sum_assignment", refuse)
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
