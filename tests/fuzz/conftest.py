"""A folder for the files that are fuzzed: in memory where the system has such a place."""

import tempfile
from collections.abc import Iterator
from pathlib import Path

import pytest

MEMORY = Path("/dev/shm")


@pytest.fixture
def folder() -> Iterator[Path]:
    """An empty folder, removed in the end."""
    place = MEMORY if MEMORY.is_dir() else None
    with tempfile.TemporaryDirectory(prefix="mot-sim-fuzz-", dir=place) as made:
        yield Path(made)
