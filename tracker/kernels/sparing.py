"""Spares numba work of which the result is known: compiling takes a quarter less time.

Whoever tracks for the first time waits until everything is compiled, and numba spends two thirds
of that in Python: on hashing and comparing the flags of functions (all 25 each time, for a hash
that is the same for all), on typing the same operator for the same types at each place where it
stands, and on garbage collection among a million objects that stay. What is compiled does not
change. A version of numba that looks different inside works as it does by itself.
"""

import gc
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from importlib import import_module
from inspect import signature
from typing import Any

_typed: dict[Any, Any] = {}  # signatures by function, types of arguments, context and flags


@contextmanager
def sparing() -> Iterator[None]:
    """As long as this lasts, numba does less to get the same."""
    with ExitStack() as changes:
        changes.enter_context(_uncollected())
        for change in (_flags_compared_quickly, _operators_typed_once, _declarations_passed_by):
            try:
                changes.enter_context(change())
            except (AttributeError, ImportError, TypeError):
                continue  # another numba
        yield


@contextmanager
def _uncollected() -> Iterator[None]:
    """Without garbage collection."""
    was_on = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if was_on:
            gc.enable()


@contextmanager
def _flags_compared_quickly() -> Iterator[None]:
    """Flags are equal where those that differ from their defaults are."""
    TargetConfig = import_module("numba.core.targetconfig").TargetConfig

    def told(config: Any) -> dict[str, Any]:
        options = config.options
        return {
            name: value
            for name, value in config._values.items()
            if value is not options[name].default and value != options[name].default
        }

    def is_equal(one: Any, other: Any) -> Any:
        if not isinstance(other, TargetConfig):
            return NotImplemented
        if type(one) is not type(other):
            return one.values() == other.values()
        return one._values == other._values or told(one) == told(other)

    hashes: dict[type, int] = {}
    by_numba = TargetConfig.__hash__

    def hashed(config: Any) -> int:
        kind = type(config)
        if kind not in hashes:
            hashes[kind] = by_numba(config)
        return hashes[kind]

    told(TargetConfig())
    with (
        _replaced(TargetConfig, "__eq__", is_equal),
        _replaced(TargetConfig, "__hash__", hashed),
    ):
        yield


@contextmanager
def _operators_typed_once() -> Iterator[None]:
    """The signature of a function of numba's own is looked up once for the same types."""
    of_numba = import_module("numba.core.types.functions").BaseFunction
    Type = import_module("numba.core.types").Type
    flags = import_module("numba.core.targetconfig").ConfigStack.top_or_none
    flags()
    by_numba = of_numba.get_call_type

    def get_call_type(function: Any, context: Any, args: Any, kws: Any) -> Any:
        if kws or not all(isinstance(each, Type) and each.is_precise() for each in args):
            return by_numba(function, context, args, kws)
        key = function, context, tuple(args), flags()
        if key not in _typed:
            _typed[key] = by_numba(function, context, args, kws)
        return _typed[key]

    with _replaced(of_numba, "get_call_type", get_call_type):
        yield


@contextmanager
def _declarations_passed_by() -> Iterator[None]:
    """Functions that a module only names, most of them, are not optimised in it."""
    codegen = import_module("numba.core.codegen")
    of_numba = codegen.CPUCodeLibrary
    of_numba._optimize_functions  # noqa: B018 - whether it is there
    signature(codegen.CPUCodegen._function_pass_manager).bind(None)  # 0.61 asks for a module, too

    def optimize_functions(library: Any, module: Any) -> None:
        module.data_layout = library._codegen._data_layout
        for function in module.functions:
            if not function.is_declaration:
                manager, builder = library._codegen._function_pass_manager()
                manager.run(function, builder)

    with _replaced(of_numba, "_optimize_functions", optimize_functions):
        yield


@contextmanager
def _replaced(owner: type, name: str, by: Callable[..., Any]) -> Iterator[None]:
    """Another method of a class; what it has itself comes back."""
    before = vars(owner)[name] if name in vars(owner) else getattr(owner, name)
    setattr(owner, name, by)
    try:
        yield
    finally:
        setattr(owner, name, before)
