"""What modules of kernels share: types of arrays, and how functions are compiled."""

from collections.abc import Callable
from typing import Any, TypeVar

from numba import boolean, config, float64, int64, njit
from numba.types import Array

from tracker.kernels.parts import as_part, few_types

Function = TypeVar("Function", bound=Callable[..., Any])

# Inputs, which are never written to: float64 with so many dimensions, contiguous rows.
F1, F2, F3, F4 = (Array(float64, n, "C", readonly=True) for n in (1, 2, 3, 4))
# The same of any strides, as users give them.
A1, A2 = (Array(float64, n, "A", readonly=True) for n in (1, 2))
A_I1 = Array(int64, 1, "A", readonly=True)
I1, I2 = (Array(int64, n, "C", readonly=True) for n in (1, 2))
B1, B2 = (Array(boolean, n, "C", readonly=True) for n in (1, 2))
# Outputs, which the caller has made.
OUT1, OUT2, OUT3, OUT4 = (Array(float64, n, "C") for n in (1, 2, 3, 4))
OUT_I1, OUT_I2 = (Array(int64, n, "C") for n in (1, 2))
OUT_B1, OUT_B2 = (Array(boolean, n, "C") for n in (1, 2))
# Numbers.
FLOAT, INT, BOOL = float64, int64, boolean


def kernel(*arguments: Any, allocates: bool = True) -> Callable[[Function], Function]:
    """Compile a function for arguments of these types, or take it from the cache.

    No fast maths, so the same numbers on every processor; x / 0 is inf or NaN as in NumPy.
    allocates: whether it makes arrays; one that makes none, nor calls what does, needs no counts
    of references, so that views of rows cost nothing in its loops.
    """
    options = {"cache": bool(config.CACHE_DIR), "error_model": "numpy", "no_cfunc_wrapper": True}
    if not allocates:
        options["_nrt"] = False

    def compiled(function: Function) -> Function:
        return njit(arguments, **options)(function)

    return compiled


def inlined(function: Function) -> Function:
    """A function for kernels to call that makes no array; it is compiled with each of them.

    It counts no references, whichever kernel it is first compiled with.
    """
    return _compiled_with_callers(function, _nrt=False)


def inlined_with_arrays(function: Function) -> Function:
    """The same for one that makes arrays, or gives parts of some to callers that drop them."""
    return _compiled_with_callers(function)


def _compiled_with_callers(function: Function, **options: Any) -> Function:
    """A function that nobody but kernels can call."""
    options |= {"no_cfunc_wrapper": True, "no_cpython_wrapper": True} | as_part()
    found = njit(error_model="numpy", **options)(function)
    template_of = found.get_call_template

    def of_few_types(arguments: Any, named: Any) -> Any:
        _, arguments = found.fold_argument_types(arguments, named)
        return template_of(few_types(arguments, found.overloads), {})

    found.get_call_template = of_few_types
    return found
