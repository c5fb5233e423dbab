"""Events that may cost a car its track id: a table with one row per event, and its bins."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from jaxtyping import Float, Int, Shaped
from numpy import ndarray as Array

from tracker.types import Rows

EVENT_KINDS = ("occlusion", "crossing", "car turns", "camera turns", "look-alike", "detector gap")
# Those that are as much about the second car.
PAIR_KINDS = ("crossing", "look-alike")
# In the column `others`: no second car; the occluder is not a car.
NO_PARTNER = -2
SCENERY = -1
# Upper ends of the bins and their names: seconds of an occlusion or a gap, metres by which the
# occluder is nearer than the car. At 10 Hz a gap of one frame lasts 0.1 s.
DURATION_BINS: dict[str, tuple[tuple[float, str], ...]] = {
    "occlusion": (
        (0.5, "up to 0.5 s"),
        (1.0, "0.6 to 1 s"),
        (2.0, "1.1 to 2 s"),
        (np.inf, "longer than 2 s"),
    ),
    "detector gap": (
        (0.1, "1 frame"),
        (0.3, "0.2 to 0.3 s"),
        (1.0, "0.4 to 1 s"),
        (np.inf, "longer than 1 s"),
    ),
}
DEPTH_BINS = (
    (2.0, "occluder up to 2 m nearer"),
    (5.0, "2 to 5 m nearer"),
    (10.0, "5 to 10 m nearer"),
    (np.inf, "more than 10 m nearer"),
)
BEHIND_SCENERY = "behind no car"
BEHIND_UNKNOWN = "behind something unknown"
ROUNDING_SECONDS = 1e-6  # durations are sums of steps

# Kind, first frame, last frame, car, other, metres.
EventRow = tuple[str, int, int, int, int, float]


@dataclass(frozen=True, eq=False)
class ContextEvents(Rows):
    """Events that may cost a car its track id: one row per event, sorted by first frame."""

    kinds: Shaped[Array, " n"]
    """Kind of each event, one of EVENT_KINDS."""
    firsts: Int[Array, " n"]
    """First frame of each event."""
    lasts: Int[Array, " n"]
    """Last frame of each event."""
    ids: Int[Array, " n"]
    """Label id of the car of each event."""
    others: Int[Array, " n"]
    """Id of the second car of a crossing or look-alike pair, of the occluder (SCENERY: no car);
    else NO_PARTNER."""
    depths: Float[Array, " n"]
    """Metres by which the occluder is nearer to the camera than the car; NaN where unknown."""
    seconds: Float[Array, " n"]
    """Duration of each event, s, first and last frame included."""

    @classmethod
    def of(cls, rows: Iterable[EventRow], frame_rate: float = 10.0) -> "ContextEvents":
        """The table of rows in any order. frame_rate: Hz."""
        ordered = sorted(rows, key=lambda row: (row[1], row[0], row[3], row[4]))
        kinds, firsts, lasts, ids, others, depths = (
            zip(*ordered, strict=True) if ordered else ((),) * 6
        )
        begin, end = np.array(firsts, np.int64), np.array(lasts, np.int64)
        return cls(
            np.array(kinds, "<U12"),
            begin,
            end,
            np.array(ids, np.int64),
            np.array(others, np.int64),
            np.array(depths, float),
            (end - begin + 1) / frame_rate,
        )

    def bins_of(self, row: int) -> tuple[str, ...]:
        """The names of an event: its kind, and the bins of the kind that it lies in."""
        kind = str(self.kinds[row])
        found = [kind]
        if kind in DURATION_BINS:
            found.append(
                f"{kind}, {_bin(DURATION_BINS[kind], float(self.seconds[row]) - ROUNDING_SECONDS)}"
            )
        if kind == "occlusion":
            found.append(f"{kind}, {self._depth_bin(row)}")
        return tuple(found)

    def _depth_bin(self, row: int) -> str:
        if self.others[row] == SCENERY:
            return BEHIND_SCENERY
        depth = float(self.depths[row])
        return BEHIND_UNKNOWN if np.isnan(depth) else _bin(DEPTH_BINS, depth)


def _bin(ends: tuple[tuple[float, str], ...], value: float) -> str:
    return next(name for end, name in ends if value <= end)


def bin_names(kind: str) -> list[str]:
    """All names that an event of a kind may have, the kind first."""
    found = [kind, *(f"{kind}, {name}" for _, name in DURATION_BINS.get(kind, ()))]
    if kind == "occlusion":
        depths = [*(name for _, name in DEPTH_BINS), BEHIND_SCENERY, BEHIND_UNKNOWN]
        found += [f"{kind}, {name}" for name in depths]
    return found


def runs_of_frames(frames: Int[Array, " n"], max_step: int = 1) -> Iterator[slice]:
    """The parts of increasing frames in which neighbours are at most `max_step` apart."""
    cuts = np.flatnonzero(np.diff(frames) > max_step) + 1
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
