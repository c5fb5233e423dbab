"""What a package hands on, loaded when it is first asked for, so that importing it is quick."""

import sys
from collections.abc import Callable, Mapping
from difflib import get_close_matches
from importlib import import_module
from typing import Any


def lazy_names(
    package: str, modules: Mapping[str, str]
) -> tuple[Callable[[str], Any], Callable[[], list[str]]]:
    """The `__getattr__` and `__dir__` of a package that hands on names of these modules.

    modules: by name. An AttributeError for another name says which one is nearest.
    """

    def get(name: str) -> Any:
        """One of the names, from its module."""
        if name not in modules:
            close = get_close_matches(name, modules, n=1)
            hint = f"; did you mean {close[0]!r}?" if close else ""
            raise AttributeError(f"module {package!r} has no attribute {name!r}{hint}")
        value = getattr(import_module(modules[name]), name)
        setattr(sys.modules[package], name, value)
        return value

    def names() -> list[str]:
        """The names that are handed on, loaded or not, beside the package's own."""
        return sorted({*vars(sys.modules[package]), *modules})

    return get, names
