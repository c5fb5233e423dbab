"""What is kept between runs: sizes, limits, and who goes first."""

import os
from pathlib import Path

import pytest

from mot_sim.files import kept
from tracker.errors import BadConfig


def filled(folder: Path, **sizes: int) -> Path:
    """A folder with files of so many bytes, the first used longest ago."""
    for when, (name, size) in enumerate(sizes.items()):
        path = folder / "inner" / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(bytes(size))
        os.utime(path, (1000.0 + when, 1000.0 + when))
    return folder


def names(folder: Path) -> set[str]:
    return {path.name for _, path, _ in kept.files_in(folder)}


def test_sizes_of_all_files_add_up(tmp_path: Path) -> None:
    assert kept.Kept.of(filled(tmp_path, a=5, b=7)) == kept.Kept(tmp_path, 2, 12)
    assert kept.Kept.of(tmp_path / "none") == kept.Kept(tmp_path / "none", 0, 0)


def test_what_was_used_longest_ago_goes_first(tmp_path: Path) -> None:
    filled(tmp_path, a=5, b=5, c=5)
    assert kept.keep_within(tmp_path, 15) == 0
    kept.mark_used(tmp_path / "inner" / "a")
    assert kept.keep_within(tmp_path, 10) == 5
    assert names(tmp_path) == {"a", "c"}
    assert kept.keep_within(tmp_path, 0, [tmp_path / "inner" / "c"]) == 5
    assert names(tmp_path) == {"c"}


@pytest.mark.parametrize(
    ("words", "size"),
    [("0B", 0), ("500 MB", 500_000_000), ("1.5GB", 1_500_000_000), ("2 kB", 2000)],
)
def test_sizes_are_read(words: str, size: int) -> None:
    assert kept.read_size(words, "here") == size


@pytest.mark.parametrize("words", ["", "2", "GB", "-1 GB", "2 gb", "nan GB", "1e9 B"])
def test_what_is_no_size_is_refused(words: str) -> None:
    with pytest.raises(BadConfig, match=r"here: .* is no size: give e.g. '500 MB'"):
        kept.read_size(words, "here")


def test_sizes_are_shown() -> None:
    shown = [kept.shown_size(size) for size in (0, 999, 1500, 12_345_678, 3 * 10**12)]
    assert shown == ["0 B", "999 B", "1.5 kB", "12.3 MB", "3 TB"]


def test_the_limit_is_that_of_the_environment_or_of_the_file(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    monkeypatch.delenv("MOT_SIM_CACHE_LIMIT", raising=False)
    assert kept.size_limit() == 4 * 10**9
    kept.limit_file().parent.mkdir()
    kept.limit_file().write_text("1 GB\n")
    assert kept.size_limit() == 10**9
    monkeypatch.setenv("MOT_SIM_CACHE_LIMIT", "7 MB")
    assert kept.size_limit() == 7 * 10**6
    monkeypatch.delenv("MOT_SIM_CACHE_LIMIT")
    kept.limit_file().write_text("plenty")
    with pytest.raises(BadConfig, match=r"limit\.txt: 'plenty' is no size"):
        kept.size_limit()
