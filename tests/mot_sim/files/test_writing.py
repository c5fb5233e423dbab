"""Text files that appear whole or not at all."""

import errno
from collections.abc import Iterator
from pathlib import Path

import pytest

from mot_sim.files.writing import require_writable, write_bytes, write_lines
from tracker.errors import BadOutput


def test_parents_are_made_and_nothing_else_stays(tmp_path: Path) -> None:
    path = tmp_path / "a" / "b.txt"
    write_lines(path, ["one", "two"])
    assert path.read_bytes() == b"one\ntwo\n"
    assert list(path.parent.iterdir()) == [path]


def test_a_crash_while_writing_leaves_the_old_file(tmp_path: Path) -> None:
    path = tmp_path / "b.txt"
    write_lines(path, ["old"])

    def lines() -> Iterator[str]:
        yield "new"
        raise RuntimeError("killed")

    with pytest.raises(RuntimeError):
        write_lines(path, lines())
    assert path.read_text() == "old\n"
    assert list(tmp_path.iterdir()) == [path]


def test_a_place_that_cannot_be_written_to_is_named(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(BadOutput, match=r"file/b.txt: cannot be written: "):
        write_lines(tmp_path / "file" / "b.txt", ["x"])
    (tmp_path / "folder").mkdir()
    with pytest.raises(BadOutput, match=r"folder: cannot be written: "):
        write_lines(tmp_path / "folder", ["x"])
    assert [path.name for path in tmp_path.iterdir() if "half" in path.name] == []


def test_a_place_that_cannot_be_written_is_known_before(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    require_writable(tmp_path / "new" / "folder" / "rows.txt")
    assert not (tmp_path / "new").exists()
    for bad in (tmp_path, tmp_path / "file" / "rows.txt"):
        with pytest.raises(BadOutput, match="cannot be written"):
            require_writable(bad)


@pytest.mark.skipif(not Path("/proc/self").is_dir(), reason="needs Linux's /proc")
def test_a_folder_that_takes_files_from_nobody_is_told_before_the_work() -> None:
    """Root is allowed to write to it, as `os.access` says, and cannot."""
    with pytest.raises(BadOutput, match="/proc is no folder that can be written to"):
        require_writable(Path("/proc/new/rows.txt"))


def test_asking_whether_a_file_can_be_written_leaves_nothing_behind(tmp_path: Path) -> None:
    require_writable(tmp_path / "new" / "rows.txt")
    require_writable(tmp_path / "rows.txt")
    assert not list(tmp_path.iterdir())


def test_a_full_disk_is_told_and_leaves_the_old_file(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "b.bin"
    write_bytes(path, b"old")

    def full(*_: object) -> None:
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(Path, "write_bytes", full)
    with pytest.raises(BadOutput, match=r"b.bin: cannot be written: No space left on device"):
        write_bytes(path, b"new")
    assert path.read_bytes() == b"old"
    assert list(tmp_path.iterdir()) == [path]
