"""Functions that only kernels call: what numba makes of them is not finished before they have it.

Left alone, numba optimises each function and writes machine code for it, though all that kernels
take from it is the code before that, which is optimised again in each of them.
"""

from typing import Any

from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import Compiler
from numba.core.runtime import rtsys
from numba.types import Array, BaseTuple, Boolean, NoneType, Number, unliteral

# What is asked of numba beyond what it promises; a version without it compiles as it does alone.
_ASKED = ("_ensure_finalized", "_finalize_final_module", "_optimize_final_module")


class _Nowhere:
    """The memory of a process, for code that does not come there."""

    def set_env(self, name: str, environment: Any) -> None:
        """Nobody looks there."""


class Part(JITCodeLibrary):  # type: ignore[misc]
    """Code for kernels to take in."""

    codegen = _Nowhere()

    def add_linking_library(self, library: Any) -> None:
        """Other parts; a kernel has the counting of references with it."""
        if library is not rtsys.library:
            super().add_linking_library(library)

    def _optimize_final_module(self) -> None:
        """Kernels do."""

    def _finalize_final_module(self) -> None:
        """No machine code."""
        self._finalized = True

    def get_pointer_to_function(self, name: str) -> int:
        """There is none."""
        self._ensure_finalized()
        return 0


class PartCompiler(Compiler):  # type: ignore[misc]
    """Numba's own compiler, whose code goes to a part."""

    def compile_extra(self, func: Any) -> Any:
        """Compile a function."""
        codegen = self.state.targetctx.codegen()
        self.state.library = Part(codegen, func.__qualname__)
        return super().compile_extra(func)


def as_part() -> dict[str, Any]:
    """Options for numba to compile a function so."""
    is_known = all(hasattr(JITCodeLibrary, name) for name in _ASKED)
    return {"pipeline_class": PartCompiler} if is_known else {}


def few_types(arguments: tuple[Any, ...], compiled: Any) -> tuple[Any, ...]:
    """The types a function is to be compiled for, so that it is compiled seldom.

    For numba a 3 in a call has a type of its own: here all whole numbers are alike. What was
    compiled for arrays that are only read does for others, unless it hands one on.
    """
    plain = tuple(unliteral(each) for each in arguments)
    for known, result in compiled.items():
        if all(_fits(one, other) for one, other in zip(plain, known, strict=True)):
            given = result.signature.return_type
            if all(isinstance(each, (Number, Boolean, NoneType)) for each in _each(given)):
                return tuple(known)
    return plain


def _each(given: Any) -> tuple[Any, ...]:
    """The types of a tuple."""
    return tuple(given) if isinstance(given, BaseTuple) else (given,)


def _fits(given: Any, known: Any) -> bool:
    """Whether it is the same, or the same array, only read."""
    if given == known:
        return True
    if not (isinstance(given, Array) and isinstance(known, Array)) or known.mutable:
        return False
    return bool(given.copy(readonly=True) == known)
