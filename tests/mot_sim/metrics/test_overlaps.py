"""Pairs of one frame, and what the door turns away."""

import numpy as np
import pytest

from benchmarks.metrics.cases import tracks
from mot_sim.metrics.overlaps import Overlaps, bare_rows, same_frame_pairs
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
