"""The fuzzing itself: it finds what is let through, and goes on where it was."""

from pathlib import Path
from random import Random

import pytest

from tests.fuzz.door import BATCH, LetThrough, fuzz
from tracker.errors import BadFile


def spoiled(good: bytes, rng: Random) -> bytes:
    """The good file with a number behind it."""
    return good + str(rng.random()).encode()


def test_what_is_none_of_our_errors_is_let_through(folder: Path) -> None:
    def read(path: Path) -> None:
        if path.read_bytes() != b"good":
            raise KeyError("ours?")

    with pytest.raises(LetThrough, match="KeyError: 'ours\\?'"):
        fuzz(folder / "a", b"good", spoiled, read, 2 * BATCH)


def test_an_interrupted_run_goes_on_where_it_was(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("MOT_SIM_FUZZ_FOLDER", str(folder / "kept"))
    seen: list[bytes] = []

    def read(path: Path) -> None:
        seen.append(path.read_bytes())
        if len(seen) == stop:
            raise KeyboardInterrupt
        if seen[-1] != b"good":
            raise BadFile("as it should")

    stop = 1 + 2 * BATCH + 3  # after the good file and two batches
    with pytest.raises(KeyboardInterrupt):
        fuzz(folder / "a", b"good", spoiled, read, 4 * BATCH)
    finished, stop = seen[1 : 1 + 2 * BATCH], 0
    seen.clear()
    fuzz(folder / "a", b"good", spoiled, read, 4 * BATCH)
    assert len(seen) == 1 + 2 * BATCH
    rest = list(seen[1:])
    seen.clear()
    monkeypatch.delenv("MOT_SIM_FUZZ_FOLDER")
    fuzz(folder / "a", b"good", spoiled, read, 4 * BATCH)
    assert seen[1:] == finished + rest
