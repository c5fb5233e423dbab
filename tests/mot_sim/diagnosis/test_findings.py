"""Breaks and events: who is around whom, and sums that come out."""

import json
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pyarrow.parquet as pq
import pytest

from mot_sim.diagnosis.attribution import EITHER_SOURCE, NO_NOISE, ONE_SOURCE
from mot_sim.diagnosis.context_events import EVENT_KINDS, ContextEvents, EventRow
from mot_sim.diagnosis.diagnosed_sequence import DiagnosedSequence
from mot_sim.diagnosis.findings import (
    NO_EVENT,
    Case,
    EventCounts,
    Findings,
    at_risk,
    events_around,
    read_findings,
    tally,
    write_findings,
)
from mot_sim.diagnosis.tables import (
    cause_table,
    event_table,
    for_terminal,
    tables_of,
    write_tables,
)
from mot_sim.diagnosis.tasks import SceneTask
from mot_sim.diagnosis.work import diagnose
from mot_sim.experiments.result_file import read_result
from mot_sim.metrics.breaks import Breaks
from tests.mot_sim.diagnosis.conftest import Crossing
from tests.mot_sim.metrics.test_breaks import tracks
from tracker.errors import BadConfig
from tracker.types import Tracks

NAN = float("nan")


def breaks_at(*rows: tuple[int, int, int, bool, bool]) -> Breaks:
    """Rows (before, frame, car, switched, broken)."""
    before, frames, cars, switched, broken = (np.array(c) for c in zip(*rows, strict=True))
    ones = np.ones(len(rows), np.int64)
    return Breaks(before, frames, cars, ones, ones + 1, switched, broken, ones)


def test_a_break_is_around_what_touches_it_in_time() -> None:
    rows: list[EventRow] = [
        ("occlusion", 10, 19, 1, 2, 3.0),  # of this car, touching
        ("occlusion", 40, 50, 1, 2, 3.0),  # too late
        ("crossing", 18, 25, 3, 1, NAN),  # as the second car
        ("car turns", 10, 30, 7, -2, NAN),  # another car
    ]
    table = ContextEvents.of(rows)
    (found,) = events_around(breaks_at((12, 21, 1, True, False)), table, 10.0)
    assert {kind: int(table.firsts[row]) for kind, row in found.items()} == {
        "occlusion": 10, "crossing": 18,
    }  # fmt: skip


def test_of_two_of_a_kind_the_one_that_shares_most_frames_is_taken() -> None:
    table = ContextEvents.of([("occlusion", 0, 8, 1, 2, 1.0), ("occlusion", 11, 20, 1, 2, 9.0)])
    (found,) = events_around(breaks_at((7, 21, 1, True, True)), table, 10.0)
    assert int(table.firsts[found["occlusion"]]) == 11


def test_shares_add_up_to_the_switches_and_fragments() -> None:
    rng = np.random.default_rng(3)
    rows: list[EventRow] = [
        (str(rng.choice(EVENT_KINDS)), first, first + int(rng.integers(0, 30)),
         int(rng.integers(0, 4)), -2, NAN)
        for first in rng.integers(0, 90, 40).tolist()
    ]  # fmt: skip
    table = ContextEvents.of(rows)
    breaks = breaks_at(
        *(
            (frame, frame + 3, int(rng.integers(0, 4)), bool(number % 2), bool(number % 3))
            for number, frame in enumerate(rng.integers(0, 90, 30).tolist())
        )
    )
    around = events_around(breaks, table, 10.0)
    cars = tracks([(frame, car, 0.0) for frame in (0, 130) for car in range(4)])
    found = tally(breaks, table, around, at_risk(table, cars, around))
    parts = [found.get(name, EventCounts()) for name in (*EVENT_KINDS, NO_EVENT)]
    assert np.isclose(sum(each.switch_share for each in parts), breaks.switched.sum())
    assert np.isclose(sum(each.fragment_share for each in parts), breaks.broken.sum())
    for kind in ("occlusion", "detector gap"):
        lengths = [
            c for n, c in found.items() if n.startswith(f"{kind}, ") and n.endswith((" s", "frame"))
        ]
        assert sum(each.events for each in lengths) == found[kind].events
        assert sum(each.switches for each in lengths) == found[kind].switches


def test_only_a_car_with_a_name_to_lose_is_exposed() -> None:
    rows: list[EventRow] = [
        ("occlusion", 3, 6, 1, 2, 1.0),
        ("occlusion", 3, 6, 9, 2, 1.0),
        ("occlusion", 8, 12, 1, 2, 1.0),
        ("crossing", 4, 6, 9, 1, NAN),
    ]
    table = ContextEvents.of(rows)
    cars = tracks([(frame, 1, 0.0) for frame in range(10)])
    could = at_risk(table, cars, [])
    named = zip(table.firsts.tolist(), table.ids.tolist(), could.tolist(), strict=True)
    assert sorted(named) == [(3, 1, True), (3, 9, False), (4, 9, True), (8, 1, False)]
    # Where a name was lost, there was one to lose.
    late = int(np.flatnonzero(table.firsts == 8)[0])
    assert at_risk(table, cars, [{"occlusion": late}])[late]


def test_nothing_is_around_nothing() -> None:
    none = ContextEvents.of([])
    breaks = breaks_at((1, 2, 1, True, False))
    assert events_around(breaks, none, 10.0) == [{}]
    assert tally(breaks, none, [{}], np.zeros(0, bool)) == {
        NO_EVENT: EventCounts(0, 1, 1.0, 0, 0.0)
    }


def case(frame: int, verdict: str, *sources: str, drive: str = "a") -> Case:
    """A switch, and a fragment."""
    around = ("occlusion", "occlusion, up to 0.5 s")
    return Case(drive, frame - 2, frame, 7, 1, 2, True, True, 5, around, verdict, sources)


def found(drive: str, *cases: Case) -> Findings:
    """A drive with two occlusions, at which all its switches are."""
    n = len(cases)
    counts = {"occlusion": EventCounts(2, n, float(n), n, float(n)), NO_EVENT: EventCounts()}
    return Findings(drive, 40, 9, EVENT_KINDS, counts, cases)


ONE_DRIVE = found("a", case(9, ONE_SOURCE, "misses"), case(19, EITHER_SOURCE, "misses", "jitter"))
OTHER = found("b", case(9, NO_NOISE, drive="b"))


@dataclass(frozen=True)
class Counted:
    """A task that says how often it was done. log: a file with a line each time."""

    name: str
    log: Path
    fails: bool = False

    @property
    def key(self) -> str:
        """Its name."""
        return self.name

    def run(self) -> Findings:
        """A drive of this name."""
        if self.fails:
            raise KeyboardInterrupt
        with self.log.open("a") as file:
            file.write(f"{self.name}\n")
        return found(self.name)

    def track(self) -> tuple[DiagnosedSequence, Tracks]:
        """Nobody looks."""
        raise NotImplementedError


def test_findings_are_read_back(tmp_path: Path) -> None:
    path = tmp_path / "a.json"
    write_findings(path, ONE_DRIVE)
    assert read_findings(path) == ONE_DRIVE
    assert (ONE_DRIVE.switches, ONE_DRIVE.fragments) == (2, 2)


@pytest.mark.parametrize("spoil", ["cut", "changed", "missing", "other"])
def test_a_damaged_file_is_no_findings(tmp_path: Path, spoil: str) -> None:
    path = tmp_path / "a.json"
    write_findings(path, ONE_DRIVE)
    text = path.read_text()
    spoilt = {
        "cut": text[: len(text) // 2], "changed": text.replace('"cars": 9', '"cars": 8'),
        "other": "[]", "missing": "",
    }  # fmt: skip
    path.write_text(spoilt[spoil])
    if spoil == "missing":
        path.unlink()
    assert read_findings(path) is None


def test_finished_drives_are_not_done_again(tmp_path: Path) -> None:
    log = tmp_path / "log"
    tasks = [Counted("a", log), Counted("b", log)]
    told: list[tuple[str, int, int]] = []
    diagnose(tasks[:1], tmp_path / "out")
    again = diagnose(tasks, tmp_path / "out", progress=lambda *each: told.append(each))
    assert log.read_text().split() == ["a", "b"]
    assert [each.drive for each in again] == ["a", "b"]
    assert told == [("drives", 1, 2), ("drives", 2, 2)]


def test_what_was_finished_before_an_interrupt_is_kept(tmp_path: Path) -> None:
    log = tmp_path / "log"
    with pytest.raises(KeyboardInterrupt):
        diagnose([Counted("a", log), Counted("b", log, fails=True)], tmp_path / "out")
    diagnose([Counted("a", log), Counted("b", log)], tmp_path / "out")
    assert log.read_text().split() == ["a", "b"]


def test_a_number_of_jobs_that_cannot_be_is_refused() -> None:
    with pytest.raises(BadConfig, match="--jobs 0"):
        diagnose([], jobs=0)


@pytest.mark.slow
def test_processes_find_the_same(crossing: Crossing) -> None:
    tasks = [crossing.task(), replace(crossing.task(), seed=1)]
    assert diagnose(tasks, jobs=2) == diagnose(tasks)


def test_the_key_of_a_task_hangs_on_what_decides_it(crossing: Crossing) -> None:
    task = crossing.task()
    others: list[SceneTask] = [
        replace(task, seed=1),
        replace(task, attribute=True),
        replace(task, conditions=crossing.conditions.with_level("detector.jitter", 2.0)),
        replace(task, tracker_spec=replace(task.tracker_spec, settings={})),
    ]
    keys = [task.key, *(each.key for each in others)]
    assert len(set(keys)) == len(keys)
    assert replace(task, recordings=Path("elsewhere")).key == task.key


def test_the_table_of_events_ends_with_all_switches() -> None:
    table = event_table([ONE_DRIVE, OTHER])
    names = table.column("around")
    assert names[-2:] == (NO_EVENT, "all")
    assert table.column("switches")[-1] == 3
    kinds = [row for row, name in enumerate(names) if name in (*EVENT_KINDS, NO_EVENT)]
    shares = [table.column("switch share")[row] for row in kinds]
    assert sum(shares) == 3  # type: ignore[arg-type]
    occlusion = names.index("occlusion")
    assert table.column("events")[occlusion] == 4
    assert table.column("switches per event")[occlusion] == 0.75
    assert event_table([]).rows[-1][2] == 0


def test_kinds_that_the_data_do_not_tell_of_are_named() -> None:
    table = event_table([replace(OTHER, known=("occlusion",))])
    assert "crossing" not in table.column("around")
    assert "do not tell of: crossing" in table.note


def test_the_table_of_causes_divides_what_several_sources_explain() -> None:
    table = cause_table([ONE_DRIVE, OTHER])
    rows = {row[0]: row[1:5] for row in table.rows}
    assert rows["misses"][:3] == (1, 1, 1.5)
    assert rows["jitter"][:3] == (0, 1, 0.5)
    assert rows[f"unexplained: {NO_NOISE}"][2] == 1.0
    assert sum(row[3] for row in table.rows[:-1]) == table.rows[-1][3] == 3.0  # type: ignore[misc]
    assert cause_table([]).rows[-1][3] == 0.0


def test_the_control_is_said_in_the_note() -> None:
    cases = [
        replace(case(9, ONE_SOURCE, "misses"), by_control=told) for told in (True, False, None)
    ]
    assert "Control: 1 of 2 switches" in cause_table([found("a", *cases)]).note


def test_tables_are_shown_and_written(tmp_path: Path) -> None:
    tables = tables_of([ONE_DRIVE, OTHER], attributed=True)
    assert [table.name for table in tables] == ["events", "causes", "drives", "cases"]
    events = for_terminal(tables[0]).shown_rows()
    assert events[0][0] == "occlusion"
    assert events[0][3].startswith("75 [")
    assert (
        tables[0].as_csv().splitlines()[0].startswith("around,events,switches,switches per event")
    )
    write_tables(tmp_path, "why", tables, ["moments/sheet.png"], drives=(2, 2))
    assert read_result(tmp_path).tables == tables
    assert read_result(tmp_path).kind == "diagnosis"
    cases = pq.read_table(tmp_path / "cases.parquet").to_pylist()
    assert [row["hangs on"] for row in cases] == ["misses", "misses or jitter", ""]
    assert len((tmp_path / "cases.csv").read_text().splitlines()) == 4
    assert [table.name for table in tables_of([OTHER], attributed=False)][1] == "drives"
    for table in tables_of([], attributed=True):  # nothing at all is no error either
        for_terminal(table)
        write_tables(tmp_path / "empty", "nothing", [table])


def test_findings_files_are_plain_json(tmp_path: Path) -> None:
    write_findings(tmp_path / "a.json", ONE_DRIVE)
    assert json.loads((tmp_path / "a.json").read_text())["findings"]["drive"] == "a"
