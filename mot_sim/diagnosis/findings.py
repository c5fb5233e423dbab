"""What was found in one drive: every break with the events around it and its cause.

A break is a switch or a fragment, see `Breaks`. How often an event is followed by a break is
counted over the events at risk: those at which the car's track id could have been lost.
"""

from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from jaxtyping import Bool, Int
from numpy import ndarray as Array

from mot_sim.diagnosis.attribution import Cause
from mot_sim.diagnosis.context_events import PAIR_KINDS, ContextEvents, by_id
from mot_sim.diagnosis.cuboid_errors_around import CuboidCounts, counts_around
from mot_sim.diagnosis.diagnosed_sequence import DiagnosedSequence
from mot_sim.files.cache_folder import read_hashed, write_hashed
from mot_sim.metrics.breaks import Breaks, Matches, counted_cars
from mot_sim.metrics.cuboid_errors import cuboid_errors
from tracker.types import Tracks

# An event is around a break if at most so much time lies between them.
CONTEXT_SECONDS = 0.5
NO_EVENT = "none of these"


@dataclass(frozen=True)
class EventCounts:
    """How often one kind of event was followed by a break in one drive.

    A break near events of several kinds is divided equally among them in the shares, which so add
    up to IDSW and Frag.
    """

    events: int = 0
    """Number of events at risk: those at which the car's track id could have been lost."""
    switches: int = 0
    """Number of switches around which such an event was."""
    switch_share: float = 0.0
    """The switches, each divided among the kinds of events around it."""
    fragments: int = 0
    """Number of fragments around which such an event was."""
    fragment_share: float = 0.0
    """The fragments, each divided among the kinds of events around it."""

    def __add__(self, other: "EventCounts") -> "EventCounts":
        mine, theirs = vars(self), vars(other)
        return EventCounts(**{name: mine[name] + theirs[name] for name in mine})


Tally = Mapping[str, EventCounts]  # by `bin_names`, and NOTHING


def events_around(breaks: Breaks, events: ContextEvents, frame_rate: float) -> list[dict[str, int]]:
    """For each break the event of each kind that was around it: kind, row of `events`.

    Of several of one kind it is the one that shares most frames with the break, then the latest.
    """
    margin = round(CONTEXT_SECONDS * frame_rate)
    pairs = np.isin(events.kinds, PAIR_KINDS)
    found = []
    for before, now, car in zip(
        breaks.before.tolist(), breaks.frames.tolist(), breaks.cars.tolist(), strict=True
    ):
        mine = (events.ids == car) | (pairs & (events.others == car))
        near = (events.firsts - margin <= now) & (events.lasts + margin >= before)
        best: dict[str, tuple[int, int, int]] = {}
        for row in np.flatnonzero(mine & near).tolist():
            first, last = int(events.firsts[row]), int(events.lasts[row])
            shared = min(last, now) - max(first, before)
            kind = str(events.kinds[row])
            best[kind] = max(best.get(kind, (shared, first, row)), (shared, first, row))
        found.append({kind: row for kind, (_, _, row) in best.items()})
    return found


def at_risk(events: ContextEvents, cars: Tracks, around: list[dict[str, int]]) -> Bool[Array, " n"]:
    """Which events are at risk: the car counts in their first and last frame, or they did break.

    cars: the labels that count. around: see `events_around`.
    """
    spans = {
        car: (int(cars.frames[rows[0]]), int(cars.frames[rows[-1]]))
        for car, rows in by_id(cars.ids)
    }

    def has(car: int, first: int, last: int) -> bool:
        begins, ends = spans.get(car, (last + 1, last))
        return begins <= first and ends >= last

    risky = np.zeros(len(events), bool)
    columns = events.kinds, events.firsts, events.lasts, events.ids, events.others
    rows = zip(*(column.tolist() for column in columns), strict=True)
    for row, (kind, first, last, car, other) in enumerate(rows):
        risky[row] = has(car, first, last) or (kind in PAIR_KINDS and has(other, first, last))
    did: Int[Array, " k"] = np.array([row for each in around for row in each.values()], np.int64)
    risky[did] = True
    return risky


def tally(
    breaks: Breaks, events: ContextEvents, around: list[dict[str, int]], risky: Bool[Array, " n"]
) -> dict[str, EventCounts]:
    """The counts of one drive, by the names of kinds and of their bins. risky: see `at_risk`."""
    found: dict[str, EventCounts] = {}

    def add(name: str, counts: EventCounts) -> None:
        found[name] = found.get(name, EventCounts()) + counts

    for row in np.flatnonzero(risky).tolist():
        for name in events.bins_of(row):
            add(name, EventCounts(events=1))
    for row, at in enumerate(around):
        switch, fragment = int(breaks.switched[row]), int(breaks.broken[row])
        share = 1.0 / max(len(at), 1)
        counts = EventCounts(0, switch, switch * share, fragment, fragment * share)
        for kind in at:
            for name in events.bins_of(at[kind]):
                add(name, counts)
        if not at:
            add(NO_EVENT, counts)
    return found


@dataclass(frozen=True)
class Case:
    """One break, a switch or a fragment of a car; see `Breaks`."""

    drive: str
    """The drive's name."""
    before: int
    """Last frame in which the car was matched before the break."""
    frame: int
    """First frame in which the car is matched after the break."""
    car: int
    """Label id of the car."""
    old_track_id: int
    """Track id before the break."""
    track_id: int
    """Track id after the break."""
    switched: bool
    """Whether the break counts in IDSW."""
    broken: bool
    """Whether the break counts in Frag."""
    weight: int
    """Matched frames since the car's last switch or until its next one, whichever are fewer."""
    around: tuple[str, ...]
    """The kinds and bins of the events around it; see `ContextEvents.bins_of`."""
    verdict: str = ""
    """One of VERDICTS for a switch whose cause was sought, else empty."""
    sources: tuple[str, ...] = ()
    """The sources each of which, switched off alone, removes the switch."""
    by_control: bool | None = None
    """See `Attribution`."""


@dataclass(frozen=True)
class Findings:
    """What was found in one drive."""

    drive: str
    """The drive's name."""
    frames: int
    """Number of delivered frames."""
    cars: int
    """Number of label ids that count in the scores."""
    known: tuple[str, ...]
    """The kinds of events that can be found in a drive like this one."""
    counts: dict[str, EventCounts] = field(default_factory=dict)
    """Counts by the names of `bin_names` and NO_EVENT; names without an event or break are
    absent."""
    cases: tuple[Case, ...] = ()
    """All breaks, by frame, then by car."""
    cuboids: dict[str, CuboidCounts] = field(default_factory=dict)
    """What is wrong with cuboids, by the same names and of all rows; empty where the tracker gives
    none."""

    @property
    def switches(self) -> int:
        """IDSW."""
        return sum(case.switched for case in self.cases)

    @property
    def fragments(self) -> int:
        """Frag."""
        return sum(case.broken for case in self.cases)


def findings_of(
    diagnosed: DiagnosedSequence,
    output: Tracks,
    attribute: Callable[[Breaks], list[Cause]] | None = None,
) -> Findings:
    """What broke in a tracker's output. attribute: finds the causes of switches, if given."""
    count = diagnosed.stream.frame_count
    breaks = Breaks.of(Matches.of(diagnosed.truth, output, count))
    cars = counted_cars(diagnosed.truth, count)
    around = events_around(breaks, diagnosed.events, diagnosed.stream.frame_rate)
    risky = at_risk(diagnosed.events, cars, around)
    rows = np.flatnonzero(breaks.switched).tolist()
    causes = attribute(breaks.switches) if attribute is not None and rows else []
    found = dict(zip(rows, causes, strict=True)) if causes else {}
    cases = tuple(
        _case(diagnosed, breaks, row, around[row], found.get(row)) for row in range(len(breaks))
    )
    counts = tally(breaks, diagnosed.events, around, risky)
    frames, car_count = len(diagnosed.stream.frames), len(np.unique(cars.ids))
    cuboids = {}
    if _has_places(output) and _has_places(diagnosed.truth):
        errors = cuboid_errors(diagnosed.truth, output, count)
        margin = round(CONTEXT_SECONDS * diagnosed.stream.frame_rate)
        cuboids = counts_around(errors, diagnosed.events, margin)
    return Findings(diagnosed.name, frames, car_count, diagnosed.known, counts, cases, cuboids)


def _has_places(tracks: Tracks) -> bool:
    """Whether any row says where its car stands."""
    return tracks.cuboids is not None and bool(np.isfinite(tracks.cuboids.base).any())


def _case(
    diagnosed: DiagnosedSequence, breaks: Breaks, row: int, at: dict[str, int], cause: Cause | None
) -> Case:
    """A row of the breaks in plain values."""
    return Case(
        drive=diagnosed.name,
        before=int(breaks.before[row]),
        frame=int(breaks.frames[row]),
        car=int(breaks.cars[row]),
        old_track_id=int(breaks.old_track_ids[row]),
        track_id=int(breaks.track_ids[row]),
        switched=bool(breaks.switched[row]),
        broken=bool(breaks.broken[row]),
        weight=int(breaks.weight[row]),
        around=tuple(name for kind in at for name in diagnosed.events.bins_of(at[kind])),
        verdict="" if cause is None else cause.verdict,
        sources=() if cause is None else cause.sources,
        by_control=None if cause is None else cause.by_control,
    )


def write_findings(path: Path, findings: Findings) -> None:
    """Keep the findings of a drive in a file, as a whole or not at all."""
    write_hashed(path, "findings", asdict(findings))


def read_findings(path: Path) -> Findings | None:
    """The findings in a file; None where there is none that is whole."""
    return read_hashed(path, "findings", _parse)


def _parse(content: dict[str, Any]) -> Findings:
    """Findings of plain values. Raises KeyError, TypeError and AttributeError for what is none."""
    cases = tuple(_read_case(each) for each in content.pop("cases"))
    counts = {name: EventCounts(**each) for name, each in content.pop("counts").items()}
    known = tuple(content.pop("known"))
    cuboids = {name: CuboidCounts(**each) for name, each in content.pop("cuboids").items()}
    return Findings(**content, known=known, counts=counts, cases=cases, cuboids=cuboids)


def _read_case(content: dict[str, Any]) -> Case:
    lists = {name: tuple(content[name]) for name in ("around", "sources")}
    return Case(**{**content, **lists})
