"""Functions that kernels take in are compiled once, and give what Python gives."""

from typing import Any

import numpy as np
import pytest

from tracker.kernels import parts
from tracker.kernels.compiling import A1, F1, FLOAT, OUT1, inlined, inlined_with_arrays, kernel

KNOWN = np.array([3.0, 1.0, 2.0])


def made() -> tuple[Any, Any]:
    """A number of an array to a whole power; all of them, of which views are taken."""

    @inlined
    def power(numbers, row, count):  # type: ignore[no-untyped-def]
        product = 1.0
        for _ in range(count):
            product *= numbers[row]
        return product

    @inlined
    def put_powers(numbers, count, powers):  # type: ignore[no-untyped-def]
        for row in range(len(numbers)):
            powers[row : row + 1][0] = power(numbers, row, count)

    return power, put_powers


@inlined_with_arrays
def handed_on(numbers):  # type: ignore[no-untyped-def]
    """The array itself."""
    return numbers


def types_of(function: Any) -> list[str]:
    """What a function was compiled for."""
    return [", ".join(str(each) for each in types) for types in function.overloads]


def test_a_part_is_compiled_once_for_all_whole_numbers_and_for_arrays_that_may_be_written() -> None:
    power, put_powers = made()

    @kernel(F1, OUT1)
    def both(numbers, powers):  # type: ignore[no-untyped-def]
        put_powers(numbers, 2, powers)
        put_powers(powers, 3, powers)
        return power(numbers, 0, 0) + power(powers, 1, len(numbers))

    powers = np.empty(3)
    assert both(KNOWN, powers) == 2.0
    assert powers.tolist() == [3.0**6, 1.0, 2.0**6]
    array = "readonly array(float64, 1d, C)"
    assert types_of(power) == [f"{array}, int64, int64"]
    assert types_of(put_powers) == [f"{array}, int64, array(float64, 1d, C)"]


def test_a_part_takes_arrays_of_other_strides() -> None:
    power, _ = made()

    @kernel(A1, FLOAT)
    def first(numbers, factor):  # type: ignore[no-untyped-def]
        return factor * power(numbers, 0, 2)

    assert first(KNOWN[::-1], 0.5) == 2.0
    assert types_of(power) == ["readonly array(float64, 1d, A), int64, int64"]


def test_an_array_that_is_handed_on_may_still_be_written() -> None:
    @kernel(F1, OUT1)
    def through(numbers, result):  # type: ignore[no-untyped-def]
        there = handed_on(result)
        there[0] = handed_on(numbers)[1]

    result = np.zeros(1)
    through(KNOWN, result)
    assert result[0] == 1.0


def test_another_numba_compiles_parts_as_all_else(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(parts, "_ASKED", ("something_new",))
    assert parts.as_part() == {}

    @inlined
    def twice(number):  # type: ignore[no-untyped-def]
        return 2.0 * number

    @kernel(FLOAT)
    def fourfold(number):  # type: ignore[no-untyped-def]
        return twice(twice(number))

    assert fourfold(1.5) == 6.0


def test_a_part_has_no_machine_code_of_its_own() -> None:
    power, _ = made()

    @kernel(F1)
    def squared(numbers):  # type: ignore[no-untyped-def]
        return power(numbers, 0, 2)

    assert squared(KNOWN) == 9.0
    (part, *_) = power.overloads.values()
    assert part.library.get_pointer_to_function("anything") == 0
    (whole,) = squared.overloads.values()
    assert whole.library.get_pointer_to_function(whole.fndesc.llvm_cpython_wrapper_name) != 0
