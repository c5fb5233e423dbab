"""One item ahead, on a thread."""

import threading
from collections.abc import Iterator

import pytest

from tracker.ego import prefetch


def test_the_items_come_in_order_and_none_is_lost() -> None:
    assert list(prefetch(range(50))) == list(range(50))
    assert list(prefetch([])) == []
    assert list(prefetch([None, None])) == [None, None]


def test_exactly_one_item_is_made_ahead() -> None:
    made = []

    def make() -> Iterator[int]:
        for number in range(9):
            made.append(number)
            yield number

    coming = prefetch(make())
    for number in range(3):
        assert next(coming) == number
        assert len(made) <= number + 2
    coming.close()
    assert len(made) <= 4


def test_an_error_comes_where_its_item_was_due() -> None:
    def make() -> Iterator[int]:
        yield 1
        raise ValueError("two")

    coming = prefetch(make())
    assert next(coming) == 1
    with pytest.raises(ValueError, match="two"):
        next(coming)


def test_no_thread_is_left_behind() -> None:
    before = threading.active_count()
    coming = prefetch(range(100))
    next(coming)
    coming.close()
    assert threading.active_count() == before
