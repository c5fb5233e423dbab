"""What was found in one drive: every break with what was around it and what it hangs on."""

from collections.abc import Callable
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from mot_sim.diagnosis.attribution import Cause
from mot_sim.diagnosis.diagnosed_sequence import DiagnosedSequence
from mot_sim.diagnosis.event_matching import EventCounts, at_risk, events_around, tally
from mot_sim.files.cache_folder import read_hashed, write_hashed
from mot_sim.metrics.breaks import Breaks, Matches, counted_cars
from tracker.types import Tracks


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
    write_hashed(path, "findings", asdict(findings))


def read_findings(path: Path) -> Findings | None:
    """The findings in a file; None where there is none that is whole."""
    return read_hashed(path, "findings", _parse)


def _parse(content: dict[str, Any]) -> Findings:
    """Findings of plain values. Raises KeyError, TypeError and AttributeError for what is none."""
    cases = tuple(_read_case(each) for each in content.pop("cases"))
    counts = {name: EventCounts(**each) for name, each in content.pop("counts").items()}
    known = tuple(content.pop("known"))
    return Findings(**content, known=known, counts=counts, cases=cases)


def _read_case(content: dict[str, Any]) -> Case:
    lists = {name: tuple(content[name]) for name in ("around", "sources")}
    return Case(**{**content, **lists})


__all__ = ["Case", "Findings", "findings_of", "read_findings", "write_findings"]
