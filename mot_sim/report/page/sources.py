"""Folders of results: finished ones, sweeps that were left half way, runs of a tracker."""

import json
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from hashlib import sha256
from pathlib import Path

from mot_sim.evaluation.run_folder import RUN_FILE
from mot_sim.experiments.result_file import FAULTS, RESULT_FILE, Made, Result, read_result
from mot_sim.experiments.sweep.store import SWEEP_FILE
from mot_sim.experiments.sweep.summary import summary, sweep_tables
from mot_sim.experiments.sweep.unfinished import read_partial
from mot_sim.files.text import read_text
from mot_sim.tables import Cell, Table
from tracker.errors import BadConfig, BadFile

FILES = (RESULT_FILE, SWEEP_FILE, RUN_FILE)  # any of them makes a folder one of ours
SHOWN_FILES = (".mp4", ".png")


@dataclass(frozen=True)
class ResultSource:
    """A result and the folder that it lies in. sha256: of the file it was read from."""

    folder: Path
    result: Result
    sha256: str


def find_sources(folders: Sequence[Path]) -> list[ResultSource]:
    """What the folders hold, each with those right below where it is none itself.

    Raises BadConfig for no folder, BadFile for one that holds nothing of ours, or what is damaged.
    """
    if not folders:
        raise BadConfig("nothing to report: name folders that a command got as --out")
    found: dict[Path, ResultSource] = {}
    for folder in folders:
        places = list(_places(folder))
        if not places:
            raise BadFile(
                f"{folder}: nothing of ours: no {', '.join(FILES)} there or one folder below; name "
                "folders that sweep, stress, breaking-point, compare, tables, tune, diagnose or "
                "track got as --out"
            )
        for place in places:
            found.setdefault(place.resolve(), read_source(place))
    return list(found.values())


def _places(folder: Path) -> Iterator[Path]:
    """The folder if it is one of ours, else those of its folders that are."""
    if not folder.is_dir():
        raise BadFile(f"{folder}: no folder; name one that a command got as --out")
    if _is_ours(folder):
        yield folder
        return
    try:
        yield from (each for each in sorted(folder.iterdir()) if each.is_dir() and _is_ours(each))
    except OSError as error:
        raise BadFile(f"{folder}: cannot be read: {error.strerror}") from None


def _is_ours(folder: Path) -> bool:
    return any((folder / name).is_file() for name in FILES)


def read_source(folder: Path) -> ResultSource:
    """What one folder holds. Raises BadFile."""
    if (folder / RESULT_FILE).is_file():
        result = read_result(folder)
        if (folder / SWEEP_FILE).is_file() and not result.made.finished:
            result = _half_way(folder, result.made.command)
        return ResultSource(folder, result, _hash(folder / RESULT_FILE))
    if (folder / SWEEP_FILE).is_file():
        return ResultSource(folder, _half_way(folder), _hash(folder / SWEEP_FILE))
    return ResultSource(folder, _run(folder), _hash(folder / RUN_FILE))


def _hash(path: Path) -> str:
    return sha256(path.read_bytes()).hexdigest()


def _half_way(folder: Path, command: str = "") -> Result:
    """A sweep that was not finished, with the tables of what is there."""
    half = read_partial(folder)
    tables: tuple[Table, ...] = ()
    if half.table is not None:
        tables = sweep_tables(half.table, summary(half.table), half.description)
    made = Made(
        command, half.versions, half.code, half.done == half.wanted, (half.done, half.wanted)
    )
    axes = ", ".join(half.description["axes"])
    return Result("sweep", f"{half.description['scene']}: {axes}", made, tables)


def _run(folder: Path) -> Result:
    """A tracker's results: what it was given and how much went through."""
    file = folder / RUN_FILE
    try:
        described = json.loads(read_text(file))
        settings = tuple(
            (str(name), _cell(value))
            for name, value in described["settings"].items()
            if value is not None
        )
        names = ("frames", "detections", "rows", "ids", "seconds")
        rows = tuple(
            (str(name), *(_cell(part[each]) for each in names))
            for name, part in described["sequences"].items()
        )
        versions = {str(name): str(each) for name, each in described["versions"].items()}
        finished = bool(described["complete"])
    except FAULTS as error:
        raise BadFile(f"{file}: no run of ours: {error!r:.120}") from None
    files = tuple(
        path.name for path in sorted(folder.iterdir())
        if path.suffix.lower() in SHOWN_FILES and path.is_file() and not path.is_symlink()
    )  # fmt: skip
    return Result(
        "run", f"{folder.name}: results of a tracker", Made("", versions, "", finished),
        (
            Table.of("sequences", "What went through the tracker", ("sequence", *names), rows),
            Table.of("settings", "Settings", ("setting", "value"), settings),
        ),
        files,
    )  # fmt: skip


def _cell(value: object) -> Cell:
    """A value of JSON in a table; lists and objects as text."""
    if value is None or isinstance(value, str | int | float):
        return value
    return json.dumps(value)


__all__ = ["ResultSource", "find_sources", "read_source"]
