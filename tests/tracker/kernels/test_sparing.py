"""Numba that is spared work makes the same code."""

import gc
from collections.abc import Callable
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from numba import float64, int64, njit
from numba.core.codegen import CPUCodegen, CPUCodeLibrary
from numba.core.compiler import Flags
from numba.core.targetconfig import TargetConfig
from numba.core.types.functions import BaseFunction

from tracker.kernels import sparing as room
from tracker.kernels.sparing import sparing

NAMES = ("nrt", "boundscheck", "no_cpython_wrapper", "forceinline", "error_model")


def compiled() -> Any:
    """A function of some operators, compiled."""

    def weighed(numbers: Any, factor: float) -> float:
        total = 0.0
        for row in range(len(numbers)):
            total += max(numbers[row, 0], factor) * numbers[row, 1] ** 2
        return total / len(numbers)

    return njit((float64[:, ::1], int64))(weighed)


def text_of(function: Any) -> list[str]:
    """What the processor is told, without the names, which count functions."""
    (text,) = function.inspect_asm().values()
    lines = (line.split("#")[0].split() for line in text.splitlines())
    return [
        line[0]
        for line in lines
        if line and not line[0].startswith((".", "_")) and ":" not in line[0]
    ]


def test_the_code_is_the_same() -> None:
    alone = text_of(compiled())
    with sparing():
        spared = text_of(compiled())
        again = text_of(compiled())
    assert len(alone) > 50
    assert alone == spared == again == text_of(compiled())


@st.composite
def flags(draw: st.DrawFn) -> Flags:
    """Some flags, perhaps set to their defaults."""
    made = Flags()
    for name in draw(st.sets(st.sampled_from(NAMES))):
        setattr(made, name, "numpy" if name == "error_model" else draw(st.booleans()))
    return made


@given(flags(), flags())
def test_flags_are_equal_where_numba_says_so(one: Flags, other: Flags) -> None:
    alone = one == other, hash(one), hash(other)
    with sparing():
        assert alone == (one == other, hash(one), hash(other))
        assert one == one.copy()
        assert one != "flags"


def test_an_operator_is_typed_once(monkeypatch: pytest.MonkeyPatch) -> None:
    asked = []
    by_numba = BaseFunction.get_call_type

    def counted(function: Any, *arguments: Any) -> Any:
        asked.append(function)
        return by_numba(function, *arguments)

    monkeypatch.setattr(BaseFunction, "get_call_type", counted)
    monkeypatch.setattr(room, "_typed", {})
    with sparing():
        compiled()
        first = len(asked)
        compiled()
    assert first > 5
    assert len(asked) == first


def test_numba_is_as_before_afterwards() -> None:
    before = TargetConfig.__eq__, TargetConfig.__hash__, BaseFunction.get_call_type, gc.isenabled()
    with sparing(), sparing():
        assert BaseFunction.get_call_type is not before[2]
        assert not gc.isenabled()
    with pytest.raises(KeyboardInterrupt), sparing():
        raise KeyboardInterrupt
    after = TargetConfig.__eq__, TargetConfig.__hash__, BaseFunction.get_call_type, gc.isenabled()
    assert before == after


@pytest.mark.parametrize(
    "change",
    [room._flags_compared_quickly, room._operators_typed_once, room._declarations_passed_by],
    ids=lambda each: each.__name__,
)
def test_another_numba_works_as_it_does(
    change: Callable[[], Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("numba.core.targetconfig.ConfigStack", None)
    monkeypatch.setattr("numba.core.targetconfig.TargetConfig", None)
    monkeypatch.setattr("numba.core.codegen.CPUCodeLibrary", None)
    before = TargetConfig.__eq__, BaseFunction.get_call_type
    with pytest.raises((AttributeError, TypeError)), change():
        pass
    with sparing():
        assert before == (TargetConfig.__eq__, BaseFunction.get_call_type)


def test_passes_that_ask_for_a_module_are_left_to_numba(monkeypatch: pytest.MonkeyPatch) -> None:
    def of_old_numba(codegen: Any, llvm_module: Any) -> Any:
        raise AssertionError(codegen, llvm_module)

    monkeypatch.setattr(CPUCodegen, "_function_pass_manager", of_old_numba)
    before = CPUCodeLibrary._optimize_functions
    with sparing():
        assert CPUCodeLibrary._optimize_functions is before
