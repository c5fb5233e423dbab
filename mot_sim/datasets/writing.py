"""Text files that appear whole or not at all."""

import os
from collections.abc import Iterable
from pathlib import Path

from tracker.errors import BadOutput


def write_lines(path: Path, lines: Iterable[str]) -> None:
    """Write the lines to a file beside it, then move it into place; parents are made.

    A crash leaves the old file or none. Raises BadOutput when the folder cannot be written to.
    """
    half = path.with_name(f".{path.name}.{os.getpid()}.half")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        half.write_text("".join(f"{line}\n" for line in lines), encoding="utf-8", newline="\n")
        os.replace(half, path)
    except OSError as error:
        raise BadOutput(f"{path}: cannot be written: {error.strerror}") from None
    finally:
        if half.parent.is_dir():
            half.unlink(missing_ok=True)


def require_writable(path: Path) -> None:
    """Raise BadOutput when `write_lines` would not be able to write there; writes nothing."""
    if path.is_dir():
        raise BadOutput(f"{path}: cannot be written: Is a directory")
    place = path.parent
    while not place.exists() and place != place.parent:
        place = place.parent
    if not place.is_dir() or not os.access(place, os.W_OK | os.X_OK):
        raise BadOutput(f"{path}: cannot be written: {place} is no folder that can be written to")
