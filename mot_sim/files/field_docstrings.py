"""The docstrings of fields: the bare strings under them, read from the source."""

import ast
import sys
from collections.abc import Mapping
from functools import lru_cache
from importlib.resources import files
from inspect import cleandoc, getsource
from types import MappingProxyType


@lru_cache(maxsize=256)
def field_docstrings(kind: type) -> Mapping[str, str]:
    """What stands under each field of a class and of its bases, on one line.

    Fields without a docstring are absent, and so are all where there is no source to read.
    """
    found: dict[str, str] = {}
    for each in reversed(kind.__mro__):
        found |= _of_module(each.__module__).get(each.__qualname__, {})
    return MappingProxyType(found)


@lru_cache(maxsize=256)
def _of_module(name: str) -> dict[str, dict[str, str]]:
    """The docstrings of the fields of a module's classes, by the classes' qualified names."""
    try:
        tree = ast.parse(getsource(sys.modules[name]))
    except (KeyError, OSError, TypeError, SyntaxError):  # built in, typed by hand, or gone
        return {}
    return dict(_classes(tree.body, ""))


def field_docstring_in(module: str, kind: str, field: str) -> str:
    """The docstring of one field of a class, without importing the module, a file of ours.

    Raises KeyError where the module has none of this name.
    """
    package, *inner, file = module.split(".")
    source = files(package).joinpath(*inner, f"{file}.py").read_text(encoding="utf-8")
    return dict(_classes(ast.parse(source).body, ""))[kind][field]


def _classes(body: list[ast.stmt], prefix: str) -> list[tuple[str, dict[str, str]]]:
    found = []
    for node in body:
        if isinstance(node, ast.ClassDef):
            found.append((prefix + node.name, fields_with_docstrings(node)))
            found += _classes(node.body, f"{prefix}{node.name}.")
    return found


def fields_with_docstrings(node: ast.ClassDef) -> dict[str, str]:
    """The docstring under each annotated name of a class body, on one line."""
    found = {}
    for field, below in zip(node.body, node.body[1:], strict=False):
        if (
            isinstance(field, ast.AnnAssign)
            and isinstance(field.target, ast.Name)
            and isinstance(below, ast.Expr)
            and isinstance(below.value, ast.Constant)
            and isinstance(below.value.value, str)
        ):
            found[field.target.id] = " ".join(cleandoc(below.value.value).split())
    return found
