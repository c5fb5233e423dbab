"""What is kept in the user's cache folder between runs: how much, until when, and how it goes."""

import os
import re
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from shutil import rmtree

from tracker.errors import BadConfig
from tracker.user_cache import user_cache

DEFAULT_LIMIT = "4 GB"  # of recorded truths: a run of 200 frames takes about 3 MB
LIMIT_VARIABLE = "MOT_SIM_CACHE_LIMIT"
UNITS = {"B": 1, "kB": 10**3, "MB": 10**6, "GB": 10**9, "TB": 10**12}


@dataclass(frozen=True)
class Kept:
    """What a folder holds."""

    folder: Path
    """The folder; it need not be there."""
    files: int
    """Number of files in it and below."""
    size: int
    """Bytes of all of them."""

    @classmethod
    def of(cls, folder: Path) -> "Kept":
        """What a folder holds now."""
        sizes = [size for _, _, size in files_in(folder)]
        return cls(folder, len(sizes), sum(sizes))


def files_in(folder: Path) -> list[tuple[float, Path, int]]:
    """When each file below a folder was last used, the file, and its bytes; the oldest first."""
    found = []
    for path in folder.rglob("*"):
        try:
            told = path.lstat()
        except OSError:  # another process has just removed it
            continue
        if not path.is_dir() or path.is_symlink():
            found.append((told.st_mtime, path, told.st_size))
    return sorted(found)


def mark_used(path: Path) -> None:
    """Let a file be the last that is removed; a cache that cannot be written to stays as it is."""
    try:
        os.utime(path)
    except OSError:
        return


def keep_within(folder: Path, limit: int, spare: Iterable[Path] = ()) -> int:
    """Remove what was used longest ago until a folder holds at most so many bytes.

    spare: files that stay in any case. Gives the bytes that were removed.
    """
    kept, removed = set(spare), 0
    files = files_in(folder)
    excess = sum(size for _, _, size in files) - limit
    for _, path, size in files:
        if removed >= excess:
            break
        if path not in kept:
            path.unlink(missing_ok=True)
            removed += size
    return removed


def clear(folders: Iterable[Path]) -> int:
    """Remove folders with all that is in them; gives the bytes. OSError where that is forbidden."""
    removed = 0
    for folder in folders:
        if folder.is_dir():
            removed += Kept.of(folder).size
            rmtree(folder)
    return removed


def limit_file() -> Path:
    """Where the limit stands that `mot-sim cache --limit` sets."""
    return user_cache("limit.txt")


def size_limit() -> int:
    """How many bytes of recorded truths are kept. BadConfig for what is no size, with its place.

    $MOT_SIM_CACHE_LIMIT, else what `mot-sim cache --limit` has set, else 4 GB.
    """
    named, file = os.environ.get(LIMIT_VARIABLE), limit_file()
    if named:
        return read_size(named, f"${LIMIT_VARIABLE}")
    try:
        return read_size(file.read_text(), str(file))
    except (OSError, UnicodeDecodeError):
        return read_size(DEFAULT_LIMIT, "the default")


def read_size(text: str, place: str) -> int:
    """Bytes, of words like 500 MB or 2GB. BadConfig for others; place: where they stand."""
    found = re.fullmatch(r"\s*(\d+(?:\.\d+)?)\s*([kMGT]?B)\s*", text)
    if found is None:
        raise BadConfig(f"{place}: {text.strip()!r} is no size: give e.g. '500 MB' or 2GB")
    return round(float(found[1]) * UNITS[found[2]])


def shown_size(size: int) -> str:
    """A number of bytes for people."""
    unit = next((unit for unit in ("TB", "GB", "MB", "kB") if size >= UNITS[unit]), "B")
    return f"{size / UNITS[unit]:.3g} {unit}" if unit != "B" else f"{size} B"
