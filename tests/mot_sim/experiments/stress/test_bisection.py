"""Doubling, then halving, towards the place at which something turns bad."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from mot_sim.experiments.stress.bisection import Reach


def test_a_search_by_hand() -> None:
    asked: list[float] = []

    def is_bad(place: float) -> bool:
        asked.append(place)
        return place >= 3.1

    assert Reach(1.0, 64.0, 0.1).bracket(is_bad) == (3.0, 3.25)
    assert asked == [1.0, 2.0, 4.0, 3.0, 3.5, 3.25]


def test_what_never_turns_bad_has_no_bracket() -> None:
    asked: list[float] = []
    assert Reach(1.0, 5.0).bracket(lambda place: bool(asked.append(place))) is None
    assert asked == [1.0, 2.0, 4.0, 5.0]


def test_what_is_bad_from_the_start_on_is_found_at_0() -> None:
    found = Reach(1.0, 64.0).bracket(lambda _: True)
    assert found is not None
    assert found[0] == 0.0
    assert found[1] <= 1e-4


@given(st.integers(1, 40), st.integers(1, 5), st.integers(1, 40))
def test_whole_places_are_found_exactly(turn: int, first: int, most: int) -> None:
    found = Reach(float(first), float(most), is_whole=True).bracket(lambda place: place >= turn)
    assert found == ((turn - 1.0, float(turn)) if turn <= most else None)


@given(st.floats(1e-3, 60.0), st.floats(0.1, 4.0), st.sampled_from([0.01, 0.1, 0.5]))
def test_the_bracket_holds_the_turn_and_is_narrow(
    turn: float, first: float, precision: float
) -> None:
    found = Reach(first, 64.0, precision).bracket(lambda place: place >= turn)
    assert found is not None
    near, far = found
    assert near < turn <= far
    assert far - near <= precision * far


@pytest.mark.parametrize("is_whole", [True, False])
def test_the_first_step_is_cut_to_the_farthest_place(is_whole: bool) -> None:
    asked: list[float] = []
    Reach(8.0, 3.0, is_whole=is_whole).bracket(lambda place: bool(asked.append(place)))
    assert asked == [3.0]
