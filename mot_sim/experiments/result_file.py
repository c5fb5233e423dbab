"""`result.json`: what a command found, in tables, for the report and for other programs."""

import json
import shlex
import sys
from collections.abc import Mapping
from dataclasses import dataclass, field
from math import isfinite
from pathlib import Path, PurePosixPath, PureWindowsPath
from typing import Any

from mot_sim.files.documents import CONTENT_ERRORS
from mot_sim.files.fingerprint import code_digest
from mot_sim.files.settings import versions
from mot_sim.files.text import read_text
from mot_sim.files.writing import write_lines
from mot_sim.tables import Cell, Table, table_of
from tracker.errors import BadConfig, BadFile, UnknownName

RESULT_FILE = "result.json"
RESULT_FORMAT = 1  # raised when the file's layout changes
RESULT_KINDS = (
    "sweep",
    "stress",
    "breaking-point",
    "compare",
    "tables",
    "tune",
    "diagnosis",
    "run",
    "scenes",
    "validate-sim",
)
MAX_WHOLE_NUMBER = 2**63  # those of a file are smaller


@dataclass(frozen=True)
class Made:
    """How a result came about: enough to make it again."""

    command: str
    """The command line, as it was typed."""
    versions: dict[str, str]
    """Versions of Python and of the packages, by name."""
    code: str
    """Hash of the source code that ran."""
    finished: bool = True
    """Whether nothing is missing."""
    trials: tuple[int, int] | None = None
    """Numbers of finished and of wanted trials; None where trials are not counted."""
    form_only: bool = False
    """Whether only the form is shown: what was measured is next to nothing, and no result."""


@dataclass(frozen=True)
class Result:
    """What a command found, as `result.json` keeps it.

    Raises UnknownName for another kind, BadConfig for a file outside the result's folder.
    """

    kind: str
    """The command that made it: one of RESULT_KINDS."""
    title: str
    """The heading above it in a report."""
    made: Made
    """How it came about."""
    tables: tuple[Table, ...]
    """Its tables, in the order in which they are shown."""
    files: tuple[str, ...] = field(default=())
    """Pictures and clips, as paths relative to the result's folder, which they may not leave."""

    def __post_init__(self) -> None:
        if self.kind not in RESULT_KINDS:
            raise UnknownName.of("kind of result", self.kind, RESULT_KINDS)
        for name in self.files:
            if not _stays_inside(name):
                raise BadConfig(
                    f"file {name!r} of a result: name it relative to the result's folder: a/b.mp4"
                )

    def table(self, name: str) -> Table | None:
        """The table of a name; None where there is none."""
        return next((table for table in self.tables if table.name == name), None)


def made_here(
    *, finished: bool = True, trials: tuple[int, int] | None = None, form_only: bool = False
) -> Made:
    """By this process: its command line, versions and code. The arguments: see `Made`."""
    program = Path(sys.argv[0]).name if sys.argv else ""
    name = "mot-sim" if program in {"mot-sim", "__main__.py", ""} else program
    command = " ".join([name, *map(shlex.quote, sys.argv[1:])])
    return Made(command, versions(), code_digest(), finished, trials, form_only)


def write_result(folder: Path, result: Result) -> Path:
    """Write `result.json` into the folder, as a whole or not at all; gives its path.

    Raises BadOutput where the folder cannot be written to.
    """
    path = folder / RESULT_FILE
    content = {"format": RESULT_FORMAT, **vars(result), "made": vars(result.made)}
    content["tables"] = [table.as_content() for table in result.tables]
    write_lines(path, [json.dumps(_plain(content), indent=1, allow_nan=False)])
    return path


def read_result(folder: Path) -> Result:
    """The result that a folder holds. Raises BadFile: no such file, damaged, of another format."""
    path = folder / RESULT_FILE
    if not path.is_file():
        raise BadFile(f"{path}: no result there; name a folder that a command got as --out")
    text = read_text(path)
    try:
        content = json.loads(text)
        form = content["format"]
        if form == RESULT_FORMAT:
            result = _result(content)
    except json.JSONDecodeError as error:
        raise BadFile(
            f"{path}:{error.lineno}: damaged: {error.msg}; run the command that made it again"
        ) from None
    except CONTENT_ERRORS as error:
        raise BadFile(f"{path}: no result of ours: {error!r:.120}") from None
    except (BadConfig, UnknownName) as error:
        raise BadFile(f"{path}: {error}") from None
    if form != RESULT_FORMAT:
        raise BadFile(
            f"{path}: a result of format {form!r:.20}, this mot-sim reads {RESULT_FORMAT}: run the "
            "command again, or read it with the mot-sim that wrote it"
        )
    _require_inside(path, result)
    return result


def _result(content: Mapping[str, Any]) -> Result:
    """From the plain values of the file; Python's own errors for what does not fit."""
    made = content["made"]
    trials = made["trials"]
    return Result(
        _text(content["kind"]),
        _text(content["title"]),
        Made(
            _text(made["command"]),
            {_text(name): _text(each) for name, each in made["versions"].items()},
            _text(made["code"]),
            bool(made["finished"]),
            None if trials is None else (int(trials[0]), int(trials[1])),
            bool(made.get("form_only", False)),  # files of older versions lack it
        ),
        tuple(
            table_of(
                {
                    **table,
                    **{key: _text(table[key]) for key in ("name", "title", "note")},
                    "columns": [_text(name) for name in table["columns"]],
                    "rows": [tuple(map(_cell, row)) for row in table["rows"]],
                }
            )
            for table in content["tables"]
        ),
        tuple(map(_text, content["files"])),
    )


def _text(value: Any) -> str:
    """A word, without the halves of characters that JSON can spell and no file can hold."""
    if not isinstance(value, str):
        raise TypeError(f"{value!r:.40} where a word belongs")
    return value.encode("utf-8", "replace").decode()


def _cell(value: Any) -> Cell:
    if isinstance(value, str):
        return _text(value)
    is_whole = isinstance(value, int) and abs(value) < MAX_WHOLE_NUMBER
    if value is None or is_whole:
        return value
    if not isinstance(value, float):
        raise TypeError(f"{value!r:.40} in a table")
    return value if isfinite(value) else None


def _plain(value: Any) -> Any:
    """The value as JSON holds it: no numbers of NumPy, no NaN, no tuples."""
    if isinstance(value, Mapping):
        return {str(name): _plain(each) for name, each in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(each) for each in value]
    if hasattr(value, "item"):
        value = value.item()
    return None if isinstance(value, float) and not isfinite(value) else value


def _stays_inside(name: str) -> bool:
    """Whether a name leads to something in the folder that it is relative to, on any system."""
    posix, windows = PurePosixPath(name), PureWindowsPath(name)
    is_plain = bool(name) and "\0" not in name and not (windows.drive or windows.root)
    return is_plain and not posix.is_absolute() and ".." not in windows.parts


def _require_inside(path: Path, result: Result) -> None:
    """Raise BadFile for a file that a link leads out of the folder."""
    home = path.parent.resolve()
    for name in result.files:
        if not (home / name).resolve().is_relative_to(home):
            raise BadFile(f"{path}: {name!r} leads out of the folder by a link: leave it out")
