"""Files that appear whole or not at all."""

import os
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryFile
from uuid import uuid4

from tracker.errors import BadOutput


@contextmanager
def whole_file(path: Path) -> Iterator[Path]:
    """Gives a path beside the file to write to, then moves that into place; parents are made.

    A crash leaves the old file or none. A link is followed; a pipe or a device is written to
    itself. Raises BadOutput when the folder cannot be written to, or the disk is full.
    """
    path = path.resolve() if path.is_symlink() else path
    if is_stream(path):
        try:
            yield path
        except OSError as error:
            raise BadOutput(f"{path}: cannot be written: {error.strerror or error}") from None
        return
    half = path.with_name(f".{path.name}.{os.getpid()}-{uuid4().hex[:12]}.half")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        yield half
        os.replace(half, path)
    except OSError as error:
        raise BadOutput(f"{path}: cannot be written: {error.strerror or error}") from None
    finally:
        if half.parent.is_dir():
            half.unlink(missing_ok=True)


def is_stream(path: Path) -> bool:
    """Whether a pipe or a device stands there, which takes text but cannot be replaced."""
    return path.exists() and not path.is_file() and not path.is_dir()


def write_lines(path: Path, lines: Iterable[str]) -> None:
    """Write the lines to a file, as a whole or not at all; see `whole_file`."""
    with whole_file(path) as half:
        half.write_text("".join(f"{line}\n" for line in lines), encoding="utf-8", newline="\n")


def write_bytes(path: Path, content: bytes) -> None:
    """Write the bytes to a file, as a whole or not at all; see `whole_file`."""
    with whole_file(path) as half:
        half.write_bytes(content)


def require_writable(path: Path) -> None:
    """Raise BadOutput when `write_lines` would not be able to write there; leaves nothing."""
    if path.is_dir():
        raise BadOutput(f"{path}: cannot be written: Is a directory")
    if path.is_symlink():
        return require_writable(path.resolve())
    if is_stream(path):
        if not os.access(path, os.W_OK):
            raise BadOutput(f"{path}: cannot be written: Permission denied")
        return None
    place = path.parent
    while not place.exists() and place != place.parent:
        place = place.parent
    try:  # not os.access: to root it allows all, and file systems have rules of their own
        with TemporaryFile(dir=place):
            return None
    except OSError:
        told = f"{path}: cannot be written: {place} is no folder that can be written to"
        raise BadOutput(told) from None
