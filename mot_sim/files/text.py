"""Tables of numbers in text files: read fast, and explained line by line when they are bad."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from jaxtyping import Bool, Float, Int, Shaped
from numpy import ndarray as Array

from tracker.errors import BadFile

# Longest word that a text column keeps; KITTI's longest class is 'Person_sitting'.
MAX_WORD_LENGTH = 32

# Beyond this a float skips whole numbers.
MAX_INTEGER = 2.0**53
# No number of a file comes near; what is computed from smaller ones does not overflow.
MAX_NUMBER = 1e18
# 28 hours at 100 Hz; what is laid out by frames stays small.
MAX_FRAMES = 10_000_000
MAX_SHOWN_NAMES = 20  # of columns, in an error
MAX_TEXT_BYTES = 2_000_000_000  # 20 million rows of labels


@dataclass(frozen=True, eq=False)
class TextTable:
    """The rows of a text file: a structured array with one field per column."""

    path: Path
    """The file, as errors name it."""
    rows: Shaped[Array, " n"]
    """One row per line that is not blank, without the header."""
    header: bool = False
    """Whether the first line that is not blank holds names, not a row."""
    lines: tuple[int, ...] | None = None
    """The line of the file, from 1, that each row stands on; None: as `line` counts them."""

    def __len__(self) -> int:
        return len(self.rows)

    def __getitem__(self, column: str) -> Shaped[Array, " n"]:
        return np.ascontiguousarray(self.rows[column])

    def block(self, columns: Sequence[str]) -> Float[Array, "n c"]:
        """The named columns side by side."""
        block = np.empty((len(self.rows), len(columns)))
        for index, column in enumerate(columns):
            block[:, index] = self.rows[column]
        return block

    def integers(self, column: str, lowest: int | None = None, cure: str = "") -> Int[Array, " n"]:
        """A column of whole numbers; BadFile for fractions and for values below `lowest`."""
        numbers = self.finite([column], most=np.inf)[:, 0]
        broken = (numbers % 1.0 != 0.0) | (np.abs(numbers) > MAX_INTEGER)
        self.reject(broken, f"{column} is not a whole number", [column], cure)
        if lowest is not None:
            cure = f"{column}s of this format start at {lowest}"
            self.reject(numbers < lowest, f"{column} below {lowest}", [column], cure)
        return numbers.astype(np.int64)

    def frames(
        self, frame_count: int | None = None, first: int = 0, counted_in: Path | None = None
    ) -> Int[Array, " n"]:
        """The column `frame`, counted from 0 where the file counts from `first`.

        BadFile for frames before the first and, given frame_count, beyond the last. counted_in:
        the file whose lines were counted for it, which may lack some.
        """
        frames = self.integers("frame", first)
        beyond = frames - first >= MAX_FRAMES
        self.reject(beyond, "frame beyond any drive", ["frame"], f"write 0..{MAX_FRAMES - 1}")
        if frame_count is not None:
            last = frame_count - 1 + first
            cure = f"the sequence has frames {first}..{last}; is it the right one?"
            if counted_in is not None:
                cure += f" Or does {counted_in}, with one line per frame, lack some?"
            self.reject(frames > last, "frame beyond the sequence", ["frame"], cure)
        return frames - first

    def finite(self, columns: Sequence[str], most: float = MAX_NUMBER) -> Float[Array, "n c"]:
        """The named columns side by side; BadFile for NaN, infinity and beyond `most`."""
        block = self.block(columns)
        bad = ~(np.isfinite(block) & (np.abs(block) <= most))
        if bad.any():
            row, column = np.argwhere(bad)[0].tolist()
            what = "too large" if np.isfinite(block[row, column]) else "not finite"
            cure = "leave the row out, or write a finite number below 1e18"
            self.reject(bad.any(axis=1), f"{columns[column]} is {what}", [columns[column]], cure)
        return block

    def reject(
        self, bad: Bool[Array, " n"], what: str, columns: Sequence[str], cure: str = ""
    ) -> None:
        """Raise BadFile at the first bad row, with the values of the given columns."""
        if not bad.any():
            return
        row = int(np.flatnonzero(bad)[0])
        values = ", ".join(f"{column} {_shown(self.rows[row][column])}" for column in columns)
        ending = f"; {cure}" if cure else ""
        raise BadFile(f"{self.place(row)}: {what}: {values}{ending}")

    def reject_repeated(self, frames: Int[Array, " n"], ids: Int[Array, " n"]) -> None:
        """Raise BadFile at an id, >= 0, that stands twice in a frame."""
        order = np.lexsort((ids, frames))
        frame, number = frames[order], ids[order]
        twice = np.zeros(len(frames), bool)
        twice[order[1:]] = (
            (frame[1:] == frame[:-1]) & (number[1:] == number[:-1]) & (number[1:] >= 0)
        )
        self.reject(
            twice, "an id twice in a frame", ["frame", "id"], "an id names one object a frame"
        )

    def place(self, row: int) -> str:
        """Where a row stands, as errors name it: file:line."""
        return f"{self.path}:{self.line(row)}"

    def line(self, row: int) -> int:
        """The line of the file, from 1, that a row stands on; the file is read again for it."""
        if self.lines is not None:
            return self.lines[row]
        lines = read_text(self.path).split("\n")
        filled = [number for number, line in enumerate(lines, 1) if line.strip()]
        return filled[row + self.header]


# How the files begin that people give where a text file or a folder belongs, and what to do.
_PACKED = {
    b"PK\x03\x04": "a zip archive; unpack it, and give the folder",
    b"\x1f\x8b": "packed by gzip; unpack it with gunzip",
    b"\x93NUMPY": "an array of numpy; write it as text",
    b"PAR1": "a Parquet file; write it as text",
    b"\x89HDF": "an HDF5 file; write it as text",
    b"\x89PNG": "an image",
    b"\xff\xd8\xff": "an image",
    b"%PDF": "a PDF",
}


def packed_as(path: Path) -> str | None:
    """What a file is that is packed or binary, and what to do about it; None for any other."""
    try:
        with path.open("rb") as file:
            start = file.read(8)
    except OSError:
        return None
    return next((what for magic, what in _PACKED.items() if start.startswith(magic)), None)


def what_is_there(folder: Path, empty: str) -> str:
    """What stands where a folder belongs: nothing, a file (of what kind), or one with `empty`."""
    if folder.is_dir():
        return empty
    if not folder.exists():
        return "no such folder"
    return f"no folder but {packed_as(folder) or 'a single file'}"


def read_text(path: Path, most: int = MAX_TEXT_BYTES) -> str:
    """The whole file as text, whatever its line ends; BadFile when it cannot be read.

    most: bytes; a larger file is refused before it is read.
    """
    try:
        if (size := path.stat().st_size) > most:
            raise BadFile(f"{path}: {size:,} bytes, where files of this kind have at most {most:,}")
        return path.read_text(encoding="utf-8-sig")
    except UnicodeDecodeError as error:
        what = packed_as(path) or f"{error.reason} at byte {error.start}"
        raise BadFile(f"{path}: not a text file ({what})") from None
    except OSError as error:
        raise BadFile(f"{path}: cannot be read: {error.strerror}") from None


def read_table(
    path: Path,
    columns: Sequence[str] | Callable[[list[str]], Sequence[str] | None],
    delimiter: str | None = None,
    words: Sequence[str] = (),
    header: bool = False,
    line_of_frame: bool = False,
    comment: str | None = None,
) -> TextTable:
    """The table in a text file, one row a line; blank lines are skipped.

    columns: their names; or, where a format has variants, what gives the names for the fields
    of the first line (None: no such variant). words: the columns that hold text. delimiter
    None: any white space. header: the first line is not a row. line_of_frame: there is a
    line per frame, and a blank one is refused, see `count_rows`. comment: lines that begin so are
    left out. No rows for an empty file.
    Raises BadFile with file and line for rows of another length and for values that are not
    numbers; NaN and infinity pass.
    """
    if line_of_frame:
        count_rows(path)
    kept = _kept_lines(path, comment)
    lines = [line for _, line in kept]
    first = [field.strip() for field in lines[0].split(delimiter)] if lines else []
    names = columns(first) if callable(columns) else columns
    if names is None:
        shown = lines[0][:80] if lines else ""
        raise BadFile(f"{path}:1: no known format has {len(first)} values a row: {shown!r}")
    kinds = [(name, f"U{MAX_WORD_LENGTH}" if name in words else "f8") for name in names]
    if len(lines) <= header:
        return TextTable(path, np.zeros(0, dtype=kinds), header)
    try:
        rows = np.loadtxt(lines[header:], dtype=kinds, delimiter=delimiter, comments=None, ndmin=1)
    except ValueError as error:
        reason = _first_fault(kept[header:], names, delimiter, words) or f" {error}"
        raise BadFile(f"{path}:{reason}") from None
    numbers = None if comment is None else tuple(number for number, _ in kept[header:])
    return TextTable(path, rows, header, numbers)


def _kept_lines(path: Path, comment: str | None) -> list[tuple[int, str]]:
    """The lines that hold something and are no comments, with their numbers."""
    numbered = enumerate(read_text(path).split("\n"), 1)
    filled = [(number, line) for number, line in numbered if line.strip()]
    if comment is None:
        return filled
    return [(number, line) for number, line in filled if not line.lstrip().startswith(comment)]


def count_rows(path: Path) -> int:
    """How many rows a file has that holds one line per frame.

    BadFile for a blank line between them: with it left out, all later frames were one too early.
    """
    lines = read_text(path).rstrip().split("\n")
    for number, line in enumerate(lines, 1):
        if len(lines) > 1 and not line.strip():
            filled = sum(1 for line in lines if line.strip())
            raise BadFile(
                f"{path}:{number}: a blank line where frame {number - 1} belongs, {filled} of "
                f"{len(lines)} lines hold values; put there what was lost, interpolated from its "
                "neighbours, for otherwise all later frames come too early"
            )
    return len(lines) if lines != [""] else 0


def _first_fault(
    numbered_lines: Sequence[tuple[int, str]],
    names: Sequence[str],
    delimiter: str | None,
    words: Sequence[str],
) -> str | None:
    """The first bad line and what is wrong with it; None when nothing is found."""
    shown_names = " ".join(names[:MAX_SHOWN_NAMES])
    if len(names) > MAX_SHOWN_NAMES:
        shown_names += f" ... ({len(names)} columns)"
    layout = f"a row is {shown_names}, separated by {repr(delimiter) if delimiter else 'spaces'}"
    for number, line in numbered_lines:
        values = line.split(delimiter)
        if len(values) != len(names):
            shown = line.strip()[:80]
            return f"{number}: {len(values)} values where {len(names)} belong: {shown!r}; {layout}"
        for name, value in zip(names, values, strict=True):
            if name not in words and not is_number(value):
                return f"{number}: {name} is {value.strip()!r}, which is no number; {layout}"
    return None


def is_number(value: str) -> bool:
    """Whether a text is a number as files write them: ASCII, without underscores."""
    try:
        float(value)
    except ValueError:
        return False
    return value.isascii() and "_" not in value


def _shown(value: object) -> str:
    return f"{value:.9g}" if isinstance(value, float) else str(value)
