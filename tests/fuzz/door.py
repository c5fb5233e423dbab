"""The property of every reader: it returns, or raises one of our own errors, and nothing else."""

import os
import re
import signal
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from random import Random
from typing import Any

from tracker.errors import TrackingError

# Inputs a reader is given; `make fuzz` asks for more.
INPUTS = int(os.environ.get("MOT_SIM_FUZZ", "1000"))
BATCH = 25  # inputs
SECONDS = 60  # in which a batch must be read; a reader that hangs is stopped then

Spoil = Callable[[bytes, Random], bytes]


class Hung(BaseException):
    """A reader takes too long. No `except` of the reader's own may swallow it."""


class LetThrough(AssertionError):
    """A reader let through what is none of our errors; says which input did it."""


def fuzz(
    path: Path,
    good: bytes | list[bytes],
    spoil: Spoil,
    read: Callable[[Path], Any],
    inputs: int = INPUTS,
) -> None:
    """Give a reader so many bad files at `path`.

    Files come in batches, each made from its number alone: random bytes, which are the first file
    and the seed of the others, spoiled copies of the good ones. At least one of the good files
    must be read. Where MOT_SIM_FUZZ_FOLDER names a folder, the number of finished batches is kept
    there for each test, and a later run goes on behind them.
    """
    seeds = good if isinstance(good, list) else [good]
    for seed in seeds:
        path.write_bytes(seed)
        read(path)
    kept = _kept_count()
    done = 0 if kept is None or not kept.is_file() else int(kept.read_text())
    for batch in range(done, -(-inputs // BATCH)):
        drawn = Random(batch)
        first = drawn.randbytes(drawn.randrange(65))
        with _at_most(SECONDS):
            check(path, first, read)
            for number in range(1, BATCH):
                rng = Random(f"{batch} {number}")
                check(path, spoil(rng.choice(seeds), rng), read)
        if kept is not None:
            kept.write_text(str(batch + 1))


def _kept_count() -> Path | None:
    """The file with the number of this test's finished batches; None where none is kept."""
    folder = os.environ.get("MOT_SIM_FUZZ_FOLDER")
    if not folder:
        return None
    test = os.environ["PYTEST_CURRENT_TEST"].rpartition(" ")[0]
    Path(folder).mkdir(parents=True, exist_ok=True)
    return Path(folder) / f"{re.sub('[^A-Za-z0-9]+', '_', test)}-by-{BATCH}.txt"


def check(path: Path, content: bytes, read: Callable[[Path], Any]) -> None:
    """Read one file. Raises LetThrough for any exception that is none of ours."""
    path.write_bytes(content)
    try:
        read(path)
    except TrackingError:
        return
    except Exception as error:
        shown = content if len(content) < 3000 else content[:1500] + b" ... " + content[-1500:]
        raise LetThrough(f"{type(error).__name__}: {error}\nof {path.name}: {shown!r}") from error


@contextmanager
def _at_most(seconds: int) -> Iterator[None]:
    """Raises Hung when the time is over."""

    def stop(*_: object) -> None:
        raise Hung(f"a batch was not read in {seconds} s")

    before = signal.signal(signal.SIGALRM, stop)
    signal.alarm(seconds)
    try:
        yield
    finally:
        signal.alarm(0)
        signal.signal(signal.SIGALRM, before)
