"""Trackers side by side on the same drives: quality and speed in one run."""

import logging
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

from mot_sim.datasets.recorded import RecordedSequence
from mot_sim.experiments.guests.sequence_trackers import (
    SequenceTracker,
    TrackedSequences,
    require_different_names,
)
from mot_sim.foreign.failure import ExternalTrackerFailed
from mot_sim.foreign.processes import one_core
from mot_sim.metrics import Evaluation, evaluate
from mot_sim.tables import Column, Row, Table
from tracker.errors import BadConfig, TrackingError
from tracker.types import Tracks

RATES = ("MOTA", "HOTA", "AssA", "IDF1")
COUNTS = {"FP": "CLR_FP", "FN": "CLR_FN", "IDSW": "IDSW", "Frag": "Frag"}
# What every tracker's tracks are passed on to, with its name.
Keep = Callable[[str, Mapping[str, Tracks]], None]

log = logging.getLogger(__name__)


@dataclass(frozen=True, eq=False)
class Entry:
    """The result of a tracker that ran through."""

    evaluation: Evaluation
    """Its scores, of every drive and of all drives together."""
    frames_per_second: float | None
    """Frames per second of CPU time, the tracker's calls alone; None: it reported no time."""
    min_score: float
    """Detector score, 0..1, below which boxes were not used."""


@dataclass(frozen=True)
class Failure:
    """The result of a tracker that failed."""

    reason: str
    """The message of the error."""
    stderr: str = ""
    """The last lines that a guest wrote to stderr; empty for our own trackers."""


@dataclass(frozen=True, eq=False)
class Comparison:
    """The results of all trackers that were compared."""

    entries: dict[str, Entry | Failure]
    """An Entry or a Failure by the tracker's name, in the order in which they ran."""

    @property
    def failures(self) -> dict[str, Failure]:
        """The trackers that failed."""
        return {name: one for name, one in self.entries.items() if isinstance(one, Failure)}

    def as_dict(self) -> dict[str, object]:
        """Plain numbers, ready for JSON; a failure has `error` and `stderr`."""
        return {name: _described(one) for name, one in self.entries.items()}

    def table(self, title: str = "") -> Table:
        """A row a tracker; the cells of one that failed are empty."""
        columns = (
            Column("tracker", "name"),
            Column("score from", "rate"),
            *(Column(rate, "rate") for rate in RATES),
            *(Column(count, "count") for count in COUNTS),
            Column("frames / CPU s", "value", digits=0),
        )
        rows = tuple((name, *_cells(one)) for name, one in self.entries.items())
        return Table(columns, rows, title)

    def tables(self) -> tuple[Table, ...]:
        """The trackers side by side; those that failed, and why; the scores of every drive."""
        scores = replace(self.table("All drives together"), name="scores")
        failed = [(name, each.reason, each.stderr) for name, each in self.failures.items()]
        columns = (Column.named("tracker", "name"), "reason", "stderr")
        failures = Table.of("failures", "Trackers that failed", columns, failed)
        names = (*RATES, *COUNTS.values())
        rows: list[Row] = []
        for tracker, entry in self.entries.items():
            if isinstance(entry, Entry):
                for drive, each in entry.evaluation.sequences.items():
                    numbers = each.numbers()
                    rows.append((drive, tracker, *(numbers.get(name) for name in names)))
        by_drive = Table.of("drives", "Drive by drive", ("drive", "tracker", *names), rows)
        return (scores, *([failures] if failed else []), by_drive)


def run_comparison(
    contestants: Sequence[SequenceTracker],
    drives: Sequence[RecordedSequence],
    truths: Mapping[str, Tracks],
    rules: str = "trackeval",
    keep: Keep | None = None,
) -> Comparison:
    """Every tracker over all drives, one after the other on one core.

    drives: with detections of one class. truths: the labels of each drive. keep: is given the
    tracks. A tracker that fails with an error of ours is noted down, and the others go on.
    """
    require_different_names(drives)
    if not drives:
        raise BadConfig("nothing to compare on: give at least one drive with labels")
    kinds = drives[0].kinds
    if len(kinds) > 1:
        raise BadConfig(
            f"{', '.join(kinds)}: guests know no classes; compare on one: --classes "
            f"{kinds[0].lower()}"
        )
    frames = sum(len(drive) for drive in drives)
    entries: dict[str, Entry | Failure] = {}
    for contestant in contestants:
        try:
            with one_core():
                outcome = contestant.track(drives)
            entries[contestant.name] = _entry(outcome, drives, truths, rules, frames)
        except TrackingError as error:
            stderr = error.stderr if isinstance(error, ExternalTrackerFailed) else ""
            entries[contestant.name] = Failure(str(error), stderr)
            continue
        if keep is not None:
            keep(contestant.name, outcome.tracks)
        log.info("%s: done", contestant.name)
    return Comparison(entries)


def _entry(
    outcome: TrackedSequences,
    drives: Sequence[RecordedSequence],
    truths: Mapping[str, Tracks],
    rules: str,
    frames: int,
) -> Entry:
    """The scores and the speed of one outcome."""
    given = {
        drive.name: (truths[drive.name], outcome.tracks[drive.name], drive.frame_count)
        for drive in drives
    }
    seconds = sum(outcome.seconds.values()) if outcome.seconds is not None else 0.0
    speed = frames / seconds if seconds > 0.0 else None
    return Entry(evaluate(given, rules, drives[0].kinds[0]), speed, outcome.min_score)


def _cells(one: Entry | Failure) -> Row:
    if isinstance(one, Failure):
        return (None,) * (2 + len(RATES) + len(COUNTS))
    numbers = one.evaluation.combined.numbers()
    rates = [float(numbers[rate]) if rate in numbers else None for rate in RATES]
    counts = [int(numbers[name]) if name in numbers else None for name in COUNTS.values()]
    return (one.min_score, *rates, *counts, one.frames_per_second)


def _described(one: Entry | Failure) -> dict[str, object]:
    if isinstance(one, Failure):
        return {"error": one.reason, "stderr": one.stderr}
    return {
        "min_score": one.min_score,
        "frames_per_cpu_second": one.frames_per_second,
        **one.evaluation.as_dict(),
    }
