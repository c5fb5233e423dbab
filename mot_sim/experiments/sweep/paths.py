"""Values inside nested dataclasses by dotted names: `lifecycle.max_gap`, `misses.by_height.3`."""

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import fields, is_dataclass, replace
from difflib import get_close_matches
from math import isfinite
from typing import Any, TypeVar

from mot_sim.files.field_docstrings import field_docstrings
from tracker.errors import BadConfig, UnknownName

Level = float | int | str | bool  # what an axis can be set to
Whole = TypeVar("Whole")


def scalars(whole: Any, prefix: str = "") -> dict[str, Level]:
    """All numbers, words and switches inside, by their dotted names."""
    return {path: value for path, value, _ in _leaves(whole, prefix, "")}


def descriptions(whole: Any, prefix: str = "", own: str = "") -> dict[str, str]:
    """What each of `scalars` is: the docstring of the innermost field that holds it.

    own: what those that no field holds are.
    """
    return {path: text for path, _, text in _leaves(whole, prefix, own, field_docstrings)}


def _leaves(
    whole: Any,
    path: str,
    text: str,
    docstrings: Callable[[type], Mapping[str, str]] = lambda _: {},
) -> Iterator[tuple[str, Level, str]]:
    """The dotted name, the value and the text of everything inside that can be set."""
    if isinstance(whole, Level):
        yield path, whole, text
        return
    parts: dict[str, Any] = {}
    texts: Mapping[str, str] = {}
    if isinstance(whole, Mapping):
        parts = {str(name): value for name, value in whole.items()}
    elif isinstance(whole, tuple):
        parts = {str(number): value for number, value in enumerate(whole)}
    elif is_dataclass(whole):
        parts = {each.name: getattr(whole, each.name) for each in fields(whole) if each.init}
        texts = docstrings(type(whole))
    for name, value in parts.items():
        inner = f"{path}.{name}" if path else name
        yield from _leaves(value, inner, texts.get(name, text), docstrings)


def with_value(whole: Whole, path: str, value: Level | None) -> Whole:
    """A copy with one value changed; the path must be one of `scalars`, or a part for None."""
    name, _, rest = path.partition(".")
    if isinstance(whole, tuple):
        place, parts = int(name), list(whole)
        parts[place] = with_value(parts[place], rest, value) if rest else value
        return tuple(parts)  # type: ignore[return-value]
    inner = getattr(whole, name)
    new = with_value(inner, rest, value) if rest else value
    return replace(whole, **{name: new})  # type: ignore[type-var]


def fitting(value: Level, like: Level, where: str) -> Level:
    """The value in the type of the one that it replaces. Raises BadConfig for another type."""
    wanted = type(like)
    number = float(value) if type(value) in (int, float) else None
    if wanted is float and number is not None:
        if not isfinite(number):
            raise BadConfig(f"{where} = {value}: give a finite number")
        return number
    if wanted is int and number is not None and number.is_integer():
        return int(number)
    if type(value) is not wanted:
        names = {float: "a number", int: "a whole number", bool: "true or false", str: "a word"}
        raise BadConfig(f"{where} = {value!r}: give {names[wanted]}, for example {like!r}")
    return value


def parse_setting(text: str) -> tuple[str, Level]:
    """The axis and the level of NAME=LEVEL, as `--set` takes it. Raises BadConfig."""
    name, equals, value = (part.strip() for part in text.partition("="))
    if not (name and equals and value):
        raise BadConfig(f"--set {text}: write NAME=LEVEL")
    return name, parse_level(value)


def parse_settings(texts: Iterable[str], given: Mapping[str, Level] = {}) -> dict[str, Level]:
    """All of them; given: what other options set. Raises BadConfig for an axis set twice."""
    found = dict(given)
    for text in texts:
        name, level = parse_setting(text)
        if name in found:
            raise BadConfig(f"--set {text}: {name} is set to {found[name]} already; set it once")
        found[name] = level
    return found


def parse_level(text: str) -> Level:
    """What a word of the command line means: true, false, a number, or the word itself."""
    switches = {"true": True, "false": False}
    if text.lower() in switches:
        return switches[text.lower()]
    for kind in (int, float):
        try:
            return kind(text)
        except ValueError:
            pass
    return text


MAX_SHOWN = 12  # names in an error; of more, those of one branch are shown as branch.*


def unknown(what: str, name: str, known: Mapping[str, Any]) -> UnknownName:
    """The error for a name with dots: those of the same root, and the nearest of all."""
    roots = sorted({each.partition(".")[0] for each in known})
    root = name.partition(".")[0]
    near = sorted(each for each in known if each.partition(".")[0] == root)
    if len(near) > MAX_SHOWN:
        near = sorted({_branch(each) for each in near})
    shown = ", ".join(near) if near else ", ".join(f"{each}.*" for each in roots)
    close = get_close_matches(name, known, n=1, cutoff=0.5) or [
        each for each in sorted(known) if each.rpartition(".")[2] == name.rpartition(".")[2]
    ]
    hint = f". Did you mean '{close[0]}'?" if close else ""
    return UnknownName(f"unknown {what} '{name}'; known: {shown}{hint}")


def _branch(path: str) -> str:
    """A name of two parts; of more, the first two, and a star for the rest."""
    first, *rest = path.split(".", 2)
    return ".".join((first, *rest[:1], *("*" for _ in rest[1:])))
