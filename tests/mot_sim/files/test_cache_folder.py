"""Entries by key: read back whole or not at all, and made where there are none."""

from pathlib import Path

import pytest

from mot_sim.files.cache_folder import CacheFolder, read_or_make
from tracker.errors import BadFile


def test_an_entry_comes_back_and_a_damaged_one_is_none(tmp_path: Path) -> None:
    cache = CacheFolder(tmp_path, "numbers")
    assert cache.read("abcd", list) is None
    cache.write("abcd", [1, 2], about={"why": "test"})
    assert cache.path("abcd") == tmp_path / "ab" / "abcd.json"
    assert cache.read("abcd", list) == [1, 2]
    assert CacheFolder(tmp_path, "letters").read("abcd", list) is None
    cache.path("abcd").write_text(cache.path("abcd").read_text().replace("[1", "[3"))
    assert cache.read("abcd", list) is None


def test_what_is_there_is_read_and_what_is_not_is_made(tmp_path: Path) -> None:
    made: list[Path] = []

    def read(path: Path) -> str:
        if not path.is_file() or "damaged" in path.read_text():
            raise BadFile(f"{path}: damaged")
        return path.read_text()

    def make(path: Path) -> None:
        made.append(path)
        path.write_text("whole")

    file = tmp_path / "file"
    assert [read_or_make(file, read, make) for _ in range(2)] == ["whole"] * 2
    file.write_text("damaged")
    assert read_or_make(file, read, make) == "whole"
    assert made == [file, file]
    with pytest.raises(BadFile):
        read_or_make(tmp_path / "other", read, lambda path: None)
