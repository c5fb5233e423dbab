"""Which breaks were at which happenings, and how many happenings there were to break at."""

import json
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, field, replace
from hashlib import sha256
from pathlib import Path
from typing import Any

import numpy as np
from jaxtyping import Bool, Int
from numpy import ndarray as Array

from mot_sim.diagnosis.attribution import Cause
from mot_sim.diagnosis.context_events import ContextEvents, by_id
from mot_sim.diagnosis.diagnosed_sequence import DiagnosedSequence
from mot_sim.files.writing import write_lines
from mot_sim.metrics.breaks import Breaks, Matches, counted_cars
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


FORMAT = 1  # of the files of finished drives


@dataclass(frozen=True)
class Case:
    """One break, see `Breaks`. around: names of kinds and bins, see `ContextEvents.bins_of`.

    verdict, sources, by_control: of a switch that was attributed, see `Cause`; else "" and none.
    """

    drive: str
    before: int
    frame: int
    car: int
    old_name: int
    name: int
    switched: bool
    broken: bool
    weight: int
    around: tuple[str, ...]
    verdict: str = ""
    sources: tuple[str, ...] = ()
    by_control: bool | None = None


@dataclass(frozen=True)
class Findings:
    """Of one drive. cars: that count, as ids; none: nothing can break. known: kinds, see `DiagnosedSequence`.

    counts: by name of `bin_names` and NOTHING.
    """

    drive: str
    frames: int
    cars: int
    known: tuple[str, ...]
    counts: dict[str, EventCounts] = field(default_factory=dict)
    cases: tuple[Case, ...] = ()

    @property
    def switches(self) -> int:
        """IDSW."""
        return sum(case.switched for case in self.cases)

    @property
    def fragments(self) -> int:
        """Frag."""
        return sum(case.broken for case in self.cases)


def findings_of(
    watched: DiagnosedSequence, output: Tracks, judge: Callable[[Breaks], list[Cause]] | None = None
) -> Findings:
    """What an output broke. judge: says what the switches hang on; None: nobody does."""
    count = watched.stream.frame_count
    breaks = Breaks.of(Matches.of(watched.truth, output, count))
    cars = counted_cars(watched.truth, count)
    around = events_around(breaks, watched.happenings, watched.stream.frame_rate)
    could = at_risk(watched.happenings, cars, around)
    rows = np.flatnonzero(breaks.switched).tolist()
    causes = judge(breaks.switches) if judge is not None and rows else []
    found = dict(zip(rows, causes, strict=True)) if causes else {}
    cases = tuple(
        _case(watched, breaks, row, around[row], found.get(row)) for row in range(len(breaks))
    )
    counts = tally(breaks, watched.happenings, around, could)
    return Findings(
        watched.name, len(watched.stream.frames), len(np.unique(cars.ids)), watched.known, counts,
        cases,
    )  # fmt: skip


def _case(
    watched: DiagnosedSequence, breaks: Breaks, row: int, at: dict[str, int], cause: Cause | None
) -> Case:
    """A row of the breaks in plain values."""
    names = tuple(name for kind in at for name in watched.happenings.bins_of(at[kind]))
    plain = Case(
        watched.name, int(breaks.before[row]), int(breaks.frames[row]), int(breaks.cars[row]),
        int(breaks.old_track_ids[row]), int(breaks.track_ids[row]), bool(breaks.switched[row]),
        bool(breaks.broken[row]), int(breaks.weight[row]), names,
    )  # fmt: skip
    if cause is None:
        return plain
    return replace(plain, verdict=cause.verdict, sources=cause.sources, by_control=cause.by_control)


def write_findings(path: Path, findings: Findings) -> None:
    """Keep the findings of a drive in a file, as a whole or not at all."""
    content = asdict(findings)
    whole = {"format": FORMAT, "sha256": _hash(content), "findings": content}
    write_lines(path, [json.dumps(whole)])


def read_findings(path: Path) -> Findings | None:
    """The findings in a file; None where there is none that is whole."""
    try:
        whole = json.loads(path.read_text(encoding="utf-8"))
        content = whole["findings"]
        if whole["format"] != FORMAT or whole["sha256"] != _hash(content):
            return None
        cases = tuple(_read_case(each) for each in content.pop("cases"))
        counts = {name: EventCounts(**each) for name, each in content.pop("counts").items()}
        known = tuple(content.pop("known"))
        return Findings(**content, known=known, counts=counts, cases=cases)
    except (OSError, ValueError, TypeError, KeyError, AttributeError):
        return None


def _read_case(content: dict[str, Any]) -> Case:
    lists = {name: tuple(content[name]) for name in ("around", "sources")}
    return Case(**{**content, **lists})


def _hash(content: dict[str, Any]) -> str:
    return sha256(json.dumps(content, sort_keys=True).encode()).hexdigest()
