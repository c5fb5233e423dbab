"""What scenes say of themselves in their source, which is read and not run: so a list is quick."""

import ast
from collections.abc import Iterable
from dataclasses import dataclass
from importlib.util import find_spec
from inspect import cleandoc
from pathlib import Path
from typing import Any

from mot_sim.files.named_objects import NameRegister
from mot_sim.simulation.scene_names import SCENE_GROUP, SCENES
from tracker.errors import BadConfig

SCENE_NAMES = NameRegister("scene", SCENES, SCENE_GROUP)


@dataclass(frozen=True)
class SceneDescription:
    """A scene as its source describes it."""

    about: str
    """The first line of its function's docstring."""
    knobs: dict[str, Any]
    """The defaults of its own knobs by name; text for what is no plain value."""

    @classmethod
    def of(cls, name: str) -> "SceneDescription":
        """Of a scene's name. Raises UnknownName, and BadConfig where no source defines it."""
        module, _, path = SCENE_NAMES.place(name).partition(":")
        file = _file_of(name, module)
        try:
            tree = ast.parse(file.read_bytes(), str(file))
        except (OSError, SyntaxError, ValueError) as error:
            raise BadConfig(f"scene {name!r}: {file} cannot be read: {error}") from None
        function = _function(tree.body, path.split("."))
        if function is None:
            raise BadConfig(f"scene {name!r}: no function {path} is defined in {file}")
        return cls(_first_line(function), _defaults(function.args))


def _file_of(name: str, module: str) -> Path:
    """Where the source of a scene lies; packages around its module are imported."""
    try:
        spec = find_spec(module)
    except (Exception, SystemExit) as error:  # noqa: BLE001 - what a package raises at import
        raise BadConfig(f"scene {name!r}: {type(error).__name__}: {error}") from None
    if spec is None or spec.origin is None:
        raise BadConfig(f"scene {name!r}: No module named {module!r}")
    return Path(spec.origin)


def _function(body: Iterable[ast.stmt], path: list[str]) -> ast.FunctionDef | None:
    """The function of a dotted path in a module's or class's body; None where none is there."""
    for node in body:
        if isinstance(node, ast.FunctionDef) and [node.name] == path:
            return node
        if isinstance(node, ast.ClassDef) and node.name == path[0]:
            return _function(node.body, path[1:])
    return None


def _first_line(function: ast.FunctionDef) -> str:
    return cleandoc(ast.get_docstring(function) or "").partition("\n")[0]


def _defaults(arguments: ast.arguments) -> dict[str, Any]:
    """The arguments that have a default, in order."""
    places = [*arguments.posonlyargs, *arguments.args]
    defaults = arguments.defaults
    pairs = [
        *zip(places[len(places) - len(defaults) :], defaults, strict=True),
        *zip(arguments.kwonlyargs, arguments.kw_defaults, strict=True),
    ]
    return {each.arg: _value(default) for each, default in pairs if default is not None}


def _value(written: ast.expr) -> Any:
    return written.value if isinstance(written, ast.Constant) else ast.unparse(written)
