"""Whoever reads a field, an axis or an option is told what it is."""

import ast
from collections.abc import Iterator
from importlib import import_module
from pathlib import Path
from typing import Any, get_type_hints

from mot_sim.experiments.sweep import Design
from mot_sim.files.field_docstrings import fields_with_docstrings
from tracker.frameworks import FRAMEWORKS

ROOT = Path(__file__).parent.parent


def fields_of(node: ast.ClassDef) -> list[str]:
    """The public fields of a dataclass or NamedTuple; none of any other class."""
    made = [ast.unparse(each) for each in (*node.decorator_list, *node.bases)]
    if not any(each.split("(")[0].split(".")[-1] in ("dataclass", "NamedTuple") for each in made):
        return []
    return [
        each.target.id
        for each in node.body
        if isinstance(each, ast.AnnAssign)
        and isinstance(each.target, ast.Name)
        and not each.target.id.startswith("_")
        and not ast.unparse(each.annotation).startswith("ClassVar")
    ]


def public_classes(body: list[ast.stmt], outer: str = "") -> Iterator[tuple[str, ast.ClassDef]]:
    for node in body:
        if isinstance(node, ast.ClassDef) and not node.name.startswith("_"):
            yield outer + node.name, node
            yield from public_classes(node.body, f"{outer}{node.name}.")


def undocumented(source: str) -> list[tuple[str, str]]:
    """Class and field of every public field without a docstring of its own."""
    return [
        (name, field)
        for name, node in public_classes(ast.parse(source).body)
        for field in fields_of(node)
        if not fields_with_docstrings(node).get(field)
    ]


def is_handed_on(path: Path, name: str, field: str) -> bool:
    """Whether a field is an option of a command whose text is that of another class's field."""
    if path.parent != ROOT / "mot_sim" / "cli":
        return False
    kind: Any = getattr(import_module(f"mot_sim.cli.{path.stem}"), name)
    told = get_type_hints(kind, include_extras=True)[field]
    return any(callable(getattr(each, "help", None)) for each in getattr(told, "__metadata__", ()))


def test_every_field_of_a_public_class_says_what_it_is() -> None:
    silent = [
        f"{path.relative_to(ROOT)}: {name}.{field}"
        for package in ("tracker", "mot_sim", "scenes")
        for path in sorted((ROOT / package).rglob("*.py"))
        for name, field in undocumented(path.read_text(encoding="utf-8"))
        if not is_handed_on(path, name, field)
    ]
    assert silent == []


def test_fields_without_a_docstring_are_found() -> None:
    source = '''
@dataclass(frozen=True)
class Car:
    """A car."""
    KINDS: ClassVar[int] = 2
    doors: int
    """How many."""
    wheels: int = 4
    _key: int = 0

    class Seat(NamedTuple):
        row: int
        """"""

class Plain:
    speed: float

@dataclasses.dataclass
class _Private:
    speed: float
'''
    assert undocumented(source) == [("Car", "wheels"), ("Car.Seat", "row")]


def test_every_axis_of_a_sweep_says_what_it_is() -> None:
    trackers = ["default", "paper"]
    trackers += [f"{each}=default:associate={each}" for each in FRAMEWORKS]
    design = Design(axes={"detector.jitter": (1.0,)}, trackers=trackers)
    texts = design.axis_descriptions()
    assert list(texts) == list(design.known_axes())
    assert {axis for axis, text in texts.items() if not text} == set()
