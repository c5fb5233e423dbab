"""The property of every reader: it returns, or raises one of our own errors, and nothing else."""

import os
import signal
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from random import Random
from typing import Any

from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import strategies as st

from tracker.errors import TrackingError

# Inputs a reader is given; `make fuzz` asks for 100,000.
INPUTS = int(os.environ.get("MOT_SIM_FUZZ", "1000"))
BATCH = 25 if INPUTS <= 1000 else 100  # inputs an example of hypothesis
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

    Each example draws some bytes: they are the first file, and the seed of the others, which are
    spoiled copies of the good ones. At least one of the good files must be read.
    """
    seeds = good if isinstance(good, list) else [good]
    for seed in seeds:
        path.write_bytes(seed)
        read(path)
    examples = -(-inputs // BATCH)

    @settings(
        max_examples=examples,
        phases=(Phase.generate,),
        suppress_health_check=list(HealthCheck),
        deadline=None,
        database=None,
        derandomize=INPUTS <= 1000,
    )
    @given(st.binary(max_size=64))
    def run(drawn: bytes) -> None:
        with _at_most(SECONDS):
            check(path, drawn, read)
            for number in range(1, BATCH):
                rng = Random(drawn + bytes([number]))
                check(path, spoil(rng.choice(seeds), rng), read)

    run()


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
