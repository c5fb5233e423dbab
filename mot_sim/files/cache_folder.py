"""Folders of results by the hash of everything that decides them: made once, then read."""

import json
from collections.abc import Callable
from dataclasses import dataclass
from hashlib import sha256
from pathlib import Path
from typing import Any, TypeVar

from mot_sim.files.documents import read_json
from mot_sim.files.writing import write_lines
from tracker.errors import BadFile

Content = TypeVar("Content")


@dataclass(frozen=True)
class CacheFolder:
    """JSON files by key, each with the SHA-256 of its content.

    A file is whole or it is not there; one that is damaged counts as not there.
    """

    folder: Path
    """Where they lie."""
    name: str
    """Name of the entry that holds the content."""

    def path(self, key: str) -> Path:
        """Where the content lies, or will lie."""
        return self.folder / key[:2] / f"{key}.json"

    def read(self, key: str, parse: Callable[[Any], Content]) -> Content | None:
        """What `parse` makes of the content; None where there is none that is whole."""
        return read_hashed(self.path(key), self.name, parse)

    def write(self, key: str, content: Any, **head: Any) -> None:
        """Keep the content; head: entries beside it, for a person who opens the file."""
        write_hashed(self.path(key), self.name, content, **head)


def read_hashed(path: Path, name: str, parse: Callable[[Any], Content]) -> Content | None:
    """What `parse` makes of the content that `write_hashed` wrote; None where it is not whole."""
    try:
        whole = read_json(path)
        return parse(whole[name]) if whole["sha256"] == _hash(whole[name]) else None
    except (BadFile, ValueError, TypeError, KeyError, AttributeError):
        return None


def write_hashed(path: Path, name: str, content: Any, **head: Any) -> None:
    """Write plain values and their SHA-256 as JSON, as a whole or not at all."""
    whole = {**head, "sha256": _hash(content), name: content}
    write_lines(path, [json.dumps(whole)])


def read_or_make(
    path: Path, read: Callable[[Path], Content], make: Callable[[Path], None]
) -> Content:
    """What a file holds, which is made where there is none that is whole (`read` says BadFile)."""
    try:
        return read(path)
    except BadFile:
        make(path)
        return read(path)


def _hash(content: Any) -> str:
    return sha256(json.dumps(content, sort_keys=True).encode()).hexdigest()
