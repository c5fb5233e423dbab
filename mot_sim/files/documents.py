"""JSON and TOML files: whatever is wrong with one, a BadFile that names it."""

import json
import tomllib
from pathlib import Path
from typing import Any

from mot_sim.files.text import read_text
from tracker.errors import BadFile

MAX_WHOLE = 2**63
# Written by hand, or a profile of noise; ours have 5 kB. Parsing dotted keys takes the square of
# their number in time and memory.
MAX_TOML_BYTES = 200_000
MAX_DOTS = 2_000  # in one line: a key of a thousand parts, or a list of a thousand fractions
MAX_JSON_BYTES = 500_000_000
# What reading plain values of another shape than expected raises.
CONTENT_ERRORS = (
    ValueError,
    TypeError,
    LookupError,
    AttributeError,
    RecursionError,
    ArithmeticError,
)
TOO_DEEP = "values inside values, deeper than anything of ours"


def read_json(path: Path, what: str = "not JSON") -> Any:
    """What a JSON file holds. Raises BadFile, with `what` for a file that is none."""
    return parse_json(read_text(path, MAX_JSON_BYTES), str(path), what)


def parse_json(text: str, where: str, what: str = "not JSON") -> Any:
    """What a JSON text holds. Raises BadFile: where, what it is not, and why."""
    try:
        return json.loads(text, parse_int=_whole)
    except ValueError as error:
        raise BadFile(f"{where}: {what}: {error}") from None
    except RecursionError:
        raise BadFile(f"{where}: {what}: {TOO_DEEP}") from None


def read_toml(path: Path, what: str = "not TOML") -> dict[str, Any]:
    """What a TOML file holds. Raises BadFile, with `what` for a file that is none."""
    text = read_text(path, MAX_TOML_BYTES)
    longest = max(text.split("\n"), key=len)
    if longest.count(".") > MAX_DOTS:
        raise BadFile(f"{path}: {what}: {TOO_DEEP}: {longest[:60]!r}")
    try:
        content = tomllib.loads(text)
        _require_whole(content)
    except ValueError as error:
        raise BadFile(f"{path}: {what}: {error}") from None
    except RecursionError:
        raise BadFile(f"{path}: {what}: {TOO_DEEP}") from None
    return content


def require_inside(named: str, where: str, *homes: Path) -> None:
    """Raise BadFile unless the path that a file names lies in one of the given folders.

    named: relative to the working folder, or absolute; links are followed.
    """
    place = Path(named).resolve()
    if not any(place.is_relative_to(home.resolve()) for home in homes):
        allowed = " and ".join(dict.fromkeys(str(home) for home in homes))
        raise BadFile(f"{where}: it names {named}, which lies outside {allowed}; move it there")


def _whole(text: str) -> int:
    """A whole number of 64 bits, which no float is too small for. Raises ValueError."""
    number = int(text)
    if abs(number) >= MAX_WHOLE:
        raise ValueError(f"{text[:20]}... is no number of 64 bits")
    return number


def _require_whole(value: Any) -> None:
    """Raise ValueError for a whole number inside that has more than 64 bits."""
    if isinstance(value, dict | list):
        for each in value.values() if isinstance(value, dict) else value:
            _require_whole(each)
    elif isinstance(value, int) and abs(value) >= MAX_WHOLE:
        raise ValueError(f"{str(value)[:20]}... is no number of 64 bits")
