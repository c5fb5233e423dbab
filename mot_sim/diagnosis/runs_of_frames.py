"""Frames in a row, and rows by id."""

from collections.abc import Iterator
from itertools import pairwise

import numpy as np
from jaxtyping import Int
from numpy import ndarray as Array


def runs_of_frames(frames: Int[Array, " n"], most_apart: int = 1) -> Iterator[slice]:
    """The parts of increasing frames whose neighbours are at most so many frames apart."""
    cuts = np.flatnonzero(np.diff(frames) > most_apart) + 1
    ends = [0, *cuts.tolist(), len(frames)]
    for first, last in pairwise(ends):
        if last > first:
            yield slice(first, last)


def by_id(ids: Int[Array, " n"]) -> Iterator[tuple[int, Int[Array, " k"]]]:
    """Every id with its rows, in the order of ids; rows keep their order."""
    if not len(ids):
        return
    order = np.argsort(ids, kind="stable")
    every, starts = np.unique(ids[order], return_index=True)
    yield from zip(every.tolist(), np.split(order, starts[1:]), strict=True)


__all__ = ["by_id", "runs_of_frames"]
