"""Work on frame after frame by several processes of this machine, in order."""

import os
import signal
import warnings
from collections import deque
from collections.abc import Callable, Generator
from concurrent.futures import Future, ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from multiprocessing import get_context
from typing import Any, TypeVar

import cv2

from tracker.errors import BadConfig, WorkersLost

Result = TypeVar("Result")

BLOCK_FRAMES = 4  # that a process does one after the other: neighbours see the same place
BLOCKS_AHEAD = 2  # a process, so that what nobody has asked for yet does not fill the memory
_work: list[Callable[[int], Any]] = []  # what this process does, where it is one of several


def core_count(jobs: int) -> int:
    """So many processes: 1 or more, or -1 for one per core. BadConfig for others."""
    if jobs == 0 or jobs < -1:
        raise BadConfig(f"--jobs {jobs}: give 1 or more, or -1 for all cores")
    return jobs if jobs > 0 else os.cpu_count() or 1


def frame_by_frame(
    work: Callable[[int], Result], count: int, jobs: int = 1
) -> Generator[Result, None, None]:
    """What work gives for frames 0, 1, ...; with several jobs, processes are a little ahead.

    They are forked from this one: nothing is sent to them, and the results can be pickled. In one
    process where there is no fork. Raises what work raises, of the first frame that fails, and
    WorkersLost for a process that ended. Closed, it ends the processes.
    """
    jobs = min(core_count(jobs), -(-count // BLOCK_FRAMES))
    if jobs < 2 or not hasattr(os, "fork"):
        yield from map(work, range(count))
        return
    threads = cv2.getNumThreads()
    cv2.setNumThreads(1)  # threads that wait for work would be missing in a copy of this process
    pool = ProcessPoolExecutor(jobs, get_context("fork"), _begin, (work,))
    waiting: deque[Future[list[Result]]] = deque()
    try:
        for first in range(0, count, BLOCK_FRAMES):
            with warnings.catch_warnings():
                warnings.simplefilter("ignore", DeprecationWarning)  # that we have other threads
                waiting.append(pool.submit(_do, first, min(first + BLOCK_FRAMES, count)))
            if len(waiting) > BLOCKS_AHEAD * jobs:
                yield from waiting.popleft().result()
        while waiting:
            yield from waiting.popleft().result()
    except BrokenProcessPool:
        raise WorkersLost(
            f"one of {jobs} processes ended while it worked, killed perhaps for its memory: try "
            "again with --jobs 1"
        ) from None
    finally:
        pool.shutdown(cancel_futures=True)
        cv2.setNumThreads(threads)


def _begin(work: Callable[[int], Any]) -> None:
    """In a new process: Ctrl-C is for the one that asks."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    _work[:] = [work]


def _do(first: int, end: int) -> list[Any]:
    return [_work[0](frame) for frame in range(first, end)]
