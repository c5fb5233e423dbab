"""Which breaks were at which happenings, and how many happenings there were to break at."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Int
from numpy import ndarray as Array

from mot_sim.diagnosis.context_events import ContextEvents
from mot_sim.diagnosis.runs_of_frames import by_id
from mot_sim.metrics.breaks import Breaks
from tracker.types import Tracks

# Seconds that a happening may be away from a break and still be around it.
CONTEXT_SECONDS = 0.5
PAIR_KINDS = ("crossing", "look-alike")
NO_EVENT = "none of these"


@dataclass(frozen=True)
class EventCounts:
    """At one kind of happening in one drive. events: how many there were.

    switches, fragments: around them; one may be around several kinds. Their shares are divided
    equally among the kinds that each was around, and so add up to IDSW and Frag.
    """

    events: int = 0
    switches: int = 0
    switch_share: float = 0.0
    fragments: int = 0
    fragment_share: float = 0.0

    def __add__(self, other: "EventCounts") -> "EventCounts":
        mine, theirs = vars(self), vars(other)
        return EventCounts(**{name: mine[name] + theirs[name] for name in mine})


Tally = Mapping[str, EventCounts]  # by `bin_names`, and NOTHING


def events_around(
    breaks: Breaks, happenings: ContextEvents, frame_rate: float
) -> list[dict[str, int]]:
    """For each break the happening of each kind that it was around: kind, row.

    Of several of a kind the one that shares most frames with the break, then the latest.
    """
    margin = round(CONTEXT_SECONDS * frame_rate)
    pairs = np.isin(happenings.kinds, PAIR_KINDS)
    found = []
    for before, now, car in zip(
        breaks.before.tolist(), breaks.frames.tolist(), breaks.cars.tolist(), strict=True
    ):
        mine = (happenings.ids == car) | (pairs & (happenings.others == car))
        near = (happenings.firsts - margin <= now) & (happenings.lasts + margin >= before)
        best: dict[str, tuple[int, int, int]] = {}
        for row in np.flatnonzero(mine & near).tolist():
            first, last = int(happenings.firsts[row]), int(happenings.lasts[row])
            shared = min(last, now) - max(first, before)
            kind = str(happenings.kinds[row])
            best[kind] = max(best.get(kind, (shared, first, row)), (shared, first, row))
        found.append({kind: row for kind, (_, _, row) in best.items()})
    return found


def at_risk(
    happenings: ContextEvents, cars: Tracks, around: list[dict[str, int]]
) -> Bool[Array, " n"]:
    """Which happenings could break a name: a label that counts at both ends, or they did break one.

    cars: the labels that count.
    """
    spans = {
        car: (int(cars.frames[rows[0]]), int(cars.frames[rows[-1]]))
        for car, rows in by_id(cars.ids)
    }

    def has(car: int, first: int, last: int) -> bool:
        begins, ends = spans.get(car, (last + 1, last))
        return begins <= first and ends >= last

    could = np.zeros(len(happenings), bool)
    rows = zip(
        happenings.kinds.tolist(), happenings.firsts.tolist(), happenings.lasts.tolist(),
        happenings.ids.tolist(), happenings.others.tolist(), strict=True,
    )  # fmt: skip
    for row, (kind, first, last, car, other) in enumerate(rows):
        could[row] = has(car, first, last) or (kind in PAIR_KINDS and has(other, first, last))
    did: Int[Array, " k"] = np.array([row for each in around for row in each.values()], np.int64)
    could[did] = True
    return could


def tally(
    breaks: Breaks,
    happenings: ContextEvents,
    around: list[dict[str, int]],
    could: Bool[Array, " n"],
) -> dict[str, EventCounts]:
    """The counts of one drive, by the names of kinds and of their bins."""
    found: dict[str, EventCounts] = {}

    def add(name: str, counts: EventCounts) -> None:
        found[name] = found.get(name, EventCounts()) + counts

    for row in np.flatnonzero(could).tolist():
        for name in happenings.bins_of(row):
            add(name, EventCounts(events=1))
    for row, at in enumerate(around):
        switch, fragment = int(breaks.switched[row]), int(breaks.broken[row])
        share = 1.0 / max(len(at), 1)
        counts = EventCounts(0, switch, switch * share, fragment, fragment * share)
        for kind in at:
            for name in happenings.bins_of(at[kind]):
                add(name, counts)
        if not at:
            add(NO_EVENT, counts)
    return found


__all__ = [
    "CONTEXT_SECONDS",
    "NO_EVENT",
    "EventCounts",
    "Tally",
    "at_risk",
    "events_around",
    "tally",
]
