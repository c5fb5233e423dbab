"""Folders of results, finished or half finished, with their clips and pictures."""

import json
from base64 import b64encode
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from hashlib import sha256
from pathlib import Path, PurePosixPath

from mot_sim.datasets.boxes import RUN_FILE
from mot_sim.experiments.result_file import RESULT_FILE, Made, Result, read_result
from mot_sim.experiments.sweep.running import read_partial
from mot_sim.experiments.sweep.store import SWEEP_FILE
from mot_sim.experiments.sweep.summary import summary, sweep_tables
from mot_sim.files.documents import CONTENT_ERRORS
from mot_sim.files.text import read_text, what_is_there
from mot_sim.tables import Cell, Table
from tracker.errors import BadConfig, BadFile

RESULT_FILES = (RESULT_FILE, SWEEP_FILE, RUN_FILE)  # any of them makes a folder one of ours
SHOWN_FILES = (".mp4", ".png")
MEDIA_TYPES = {
    ".mp4": "video/mp4",
    ".png": "image/png",
    ".jpg": "image/jpeg",
    ".jpeg": "image/jpeg",
    ".gif": "image/gif",
}
# The codecs in an MP4 that browsers play; mp4v, OpenCV's own, is none of them.
PLAYABLE_CODECS = (b"avc1", b"avc3", b"av01", b"vp09")


@dataclass(frozen=True)
class ResultSource:
    """A result, and the folder that it lies in."""

    folder: Path
    """The folder."""
    result: Result
    """The result; of an unfinished sweep, what is there."""
    sha256: str
    """Hash of the file that it was read from, in hexadecimal digits."""


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
                f"{folder}: nothing of ours: no {', '.join(RESULT_FILES)} there or one folder "
                "below; name folders that sweep, stress, breaking-point, compare, tables, tune, "
                "diagnose or track got as --out"
            )
        for place in places:
            found.setdefault(place.resolve(), read_source(place))
    return list(found.values())


def _places(folder: Path) -> Iterator[Path]:
    """The folder if it is one of ours, else those of its folders that are."""
    if not folder.is_dir():
        there = what_is_there(folder, "nothing of ours")
        raise BadFile(f"{folder}: {there}; name a folder that a command got as --out")
    if _is_ours(folder):
        yield folder
        return
    try:
        yield from (each for each in sorted(folder.iterdir()) if each.is_dir() and _is_ours(each))
    except OSError as error:
        raise BadFile(f"{folder}: cannot be read: {error.strerror}") from None


def _is_ours(folder: Path) -> bool:
    return any((folder / name).is_file() for name in RESULT_FILES)


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
    except CONTENT_ERRORS as error:
        raise BadFile(f"{file}: no run of ours: {error!r:.120}") from None
    shown = [path for path in sorted(folder.iterdir()) if path.suffix.lower() in SHOWN_FILES]
    files = tuple(path.name for path in shown if path.is_file() and not path.is_symlink())
    return Result(
        "run",
        f"{folder.name}: results of a tracker",
        Made("", versions, "", finished),
        (
            Table.of("sequences", "What went through the tracker", ("sequence", *names), rows),
            Table.of("settings", "Settings", ("setting", "value"), settings),
        ),
        files,
    )


def _cell(value: object) -> Cell:
    """A value of JSON in a table; lists and objects as text."""
    if value is None or isinstance(value, str | int | float):
        return value
    return json.dumps(value)


@dataclass(frozen=True)
class Medium:
    """A picture or clip of a result."""

    name: str
    """Its path relative to the result's folder."""
    path: Path
    """The file."""
    uri: str | None
    """Its bytes as a data URI, for the page; None: it is left out."""
    reason: str = ""
    """Why it is left out; empty where it is not."""

    @property
    def is_clip(self) -> bool:
        """Whether it moves in a player."""
        return self.path.suffix.lower() == ".mp4"

    @property
    def title(self) -> str:
        """Its name as words."""
        return PurePosixPath(self.name).stem.replace("-", " ").replace("_", " ")


def load_media(sources: Sequence[ResultSource], room: int) -> dict[int, list[Medium]]:
    """The files of every source, by its place; in turns, until `room` bytes are taken."""
    found: dict[int, list[Medium]] = {place: [] for place in range(len(sources))}
    most = max((len(source.result.files) for source in sources), default=0)
    for turn in range(most):
        for place, source in enumerate(sources):
            if turn < len(source.result.files):
                medium = _load(source.folder, source.result.files[turn], room)
                room -= len(medium.uri or "")
                found[place].append(medium)
    return found


def _load(folder: Path, name: str, room: int) -> Medium:
    """One file; left out with its reason where it is missing, too large, or cannot be shown."""
    path = folder / name
    kind = MEDIA_TYPES.get(path.suffix.lower())
    if kind is None:
        return Medium(name, path, None, f"no browser shows {path.suffix or 'such files'} in a page")
    try:
        size = path.stat().st_size
        if 4 * size > 3 * room:
            told = f"{size / 1e6:.1f} MB: the page would be too large"
            return Medium(name, path, None, told)
        content = path.read_bytes()
    except OSError as error:
        return Medium(name, path, None, f"cannot be read: {error.strerror}")
    if path.suffix.lower() == ".mp4" and not any(codec in content for codec in PLAYABLE_CODECS):
        return Medium(name, path, None, "no H.264: browsers do not play it; write the clip again")
    return Medium(name, path, f"data:{kind};base64,{b64encode(content).decode()}")
