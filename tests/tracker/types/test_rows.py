"""Tables of rows: picking rows and putting tables end to end."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import pytest

from tracker.types import Cuboids, Detections, Tracks
from tracker.types.rows import Rows


def table(n: int, first: int = 0) -> Tracks:
    """Tracks with some columns, some None, and a nested table."""
    rows = np.arange(first, first + n)
    cuboids = Cuboids(np.column_stack([rows] * 3) + 0.5, rows * 0.1, np.ones((n, 3)))
    return Tracks(rows, rows + 100, np.column_stack([rows] * 4) * 1.0, cuboids=cuboids)


@pytest.mark.parametrize(
    "rows",
    [
        np.array([False, True, False, True, True]),
        np.array([1, 3, 4]),
        [1, 3, 4],
        [False, True, False, True, True],
    ],
    ids=["mask", "numbers", "list", "list of bools"],
)
def test_rows_are_selected_by_mask_and_by_number(rows) -> None:
    selected = table(5).select(rows)
    assert selected.frames.tolist() == [1, 3, 4]
    assert selected.ids.tolist() == [101, 103, 104]
    np.testing.assert_array_equal(selected.boxes[:, 0], [1, 3, 4])
    np.testing.assert_array_equal(selected.cuboids.base[:, 2], [1.5, 3.5, 4.5])
    assert selected.scores is None


def test_rows_are_selected_by_slice() -> None:
    assert table(5).select(slice(3, None)).ids.tolist() == [103, 104]
    assert table(5).select(slice(3, None)).cuboids.yaw.tolist() == pytest.approx([0.3, 0.4])


def test_rows_come_in_the_given_order_and_may_repeat() -> None:
    assert table(3).select(np.array([2, 0, 2])).frames.tolist() == [2, 0, 2]


@pytest.mark.parametrize("rows", [np.zeros(5, bool), np.zeros(0, np.int64), slice(0, 0), []])
def test_selecting_nothing_keeps_the_columns(rows) -> None:
    nothing = table(5).select(rows)
    assert len(nothing) == 0
    assert nothing.boxes.shape == (0, 4)
    assert nothing.cuboids.base.shape == (0, 3)


def test_what_is_cut_apart_concatenates_to_the_whole() -> None:
    whole = table(5)
    again = Tracks.concatenate([whole.select(slice(0, 2)), whole.select(slice(2, 5))])
    for name in ("frames", "ids", "boxes"):
        np.testing.assert_array_equal(getattr(again, name), getattr(whole, name))
    np.testing.assert_array_equal(again.cuboids.base, whole.cuboids.base)
    assert again.scores is None


def test_a_column_stays_only_where_every_part_has_it() -> None:
    box = np.array([[0.0, 0, 1, 1]])
    with_yaw = Detections(box, np.ones(1), yaw=np.zeros(1), size=np.ones((1, 3)))
    without_yaw = Detections(box, np.ones(1), size=np.ones((1, 3)))
    both = Detections.concatenate([with_yaw, without_yaw])
    assert both.yaw is None
    assert both.size.shape == (2, 3)
    nobody = without_yaw.select([])
    for parts in ([with_yaw, nobody], [nobody, with_yaw]):
        assert Detections.concatenate(parts).yaw is not None, "no rows lack no column"
    assert len(Detections.concatenate([nobody, nobody])) == 0


def test_selecting_copies_so_that_the_table_cannot_be_changed_through_it() -> None:
    whole = table(3)
    whole.select(np.array([0, 1])).boxes[:] = -1.0
    np.testing.assert_array_equal(whole.boxes, table(3).boxes)


def test_columns_are_replaced_by_name_and_the_old_table_stays() -> None:
    before = table(3)
    after = before.replaced(ids=np.array([7, 8, 9]), scores=np.ones(3))
    assert after.ids.tolist() == [7, 8, 9]
    assert after.scores is not None
    assert before.ids.tolist() == [100, 101, 102]
    assert before.scores is None
    assert after.boxes is before.boxes


def test_rows_of_another_table_take_their_places_and_the_old_table_stays() -> None:
    before = table(4)
    after = before.updated(np.array([3, 1]), table(2, first=50))
    assert after.frames.tolist() == [0, 51, 2, 50]
    np.testing.assert_array_equal(after.cuboids.base[:, 2], [0.5, 51.5, 2.5, 50.5])
    assert before.frames.tolist() == [0, 1, 2, 3]


def test_a_column_that_one_of_two_tables_lacks_is_lacking_afterwards() -> None:
    scored = table(2).replaced(scores=np.ones(2))
    assert table(4).updated(np.array([0, 1]), scored).scores is None
    assert scored.updated(np.array([0]), table(1)).scores is None


@dataclass(frozen=True, eq=False)
class Counted(Rows):
    """A table that remembers what was computed from it."""

    numbers: np.ndarray

    @cached_property
    def total(self) -> int:
        return int(self.numbers.sum())


def test_what_was_computed_from_a_table_is_no_column_of_the_next() -> None:
    whole = Counted(np.arange(4))
    assert whole.total == 6
    assert whole.select([1, 3]).total == 4
    assert whole.replaced(numbers=np.ones(2, np.int64)).total == 2
    assert whole.updated(np.array([0]), Counted(np.array([9]))).total == 15
    assert Counted.concatenate((whole, Counted(np.array([1])))).total == 7


def test_a_copy_has_arrays_of_its_own_and_a_locked_table_cannot_be_written_to() -> None:
    whole = table(3)
    mine = whole.copied()
    mine.ids[:] = 7
    mine.cuboids.base[:] = 7.0
    assert whole.ids.tolist() == [100, 101, 102]
    assert whole.cuboids.base[0, 0] == 0.5
    assert mine.scores is None
    assert whole.locked() is whole
    for array in (whole.ids, whole.cuboids.base):
        with pytest.raises(ValueError, match="read-only"):
            array[:] += 1
