"""The findings of many drives as tables: by event, by cause, drive by drive, case by case."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pyarrow.csv as pacsv
import pyarrow.parquet as pq

from mot_sim.diagnosis.attribution import EITHER_SOURCE, ONE_SOURCE, VERDICTS
from mot_sim.diagnosis.context_events import EVENT_KINDS, bin_names
from mot_sim.diagnosis.cuboid_errors_around import ALL_ROWS, OTHER_ROWS, CuboidCounts
from mot_sim.diagnosis.findings import CONTEXT_SECONDS, NO_EVENT, Case, EventCounts, Findings
from mot_sim.diagnosis.rates import mean_count, rate
from mot_sim.experiments.result_file import Result, made_here, write_result
from mot_sim.files.writing import whole_file
from mot_sim.tables import Cell, Column, Row, Table, few_seeds_note, with_ends

ALL, A_DRIVE = "all", "a drive"
RATE, BROKEN_RATE = "switches per event", "fragments per event"
SHARES = ("switch share", "fragment share")
# For the terminal: what is left out, and what is shown in percent under another title.
UNPRINTED = SHARES
PRINTED_TITLES = {RATE: "per 100", BROKEN_RATE: " per 100", "share": "percent"}


def event_table(found: Sequence[Findings]) -> Table:
    """A row a kind of event, its bins after it; the shares of the kinds add up to the last row."""
    columns = (
        "around", "events", "switches", *with_ends(RATE), "fragments", *with_ends(BROKEN_RATE),
        *SHARES,
    )  # fmt: skip
    known = [kind for kind in EVENT_KINDS if any(kind in each.known for each in found)]
    rows = [_event_row(found, name) for kind in known for name in bin_names(kind)]
    rows = [row for row in rows if row[1] or row[0] in known]
    rows.append(_event_row(found, NO_EVENT))
    switches = sum(each.switches for each in found)
    fragments = sum(each.fragments for each in found)
    nothing = (None, None, None)
    rows.append((ALL, None, switches, *nothing, fragments, *nothing, switches, fragments))
    note = (
        "A switch or fragment may be around several kinds of event: the shares divide it among "
        "them. Intervals: 95 %, over drives."
    )
    lacking = [kind for kind in EVENT_KINDS if kind not in known]
    if lacking:
        note += f" The data do not tell of: {', '.join(lacking)}."
    title = "Switches and fragments by what happened around them"
    return Table.of("events", title, columns, rows, _with_few(note, found))


def _with_few(note: str, found: Sequence[Findings]) -> str:
    """The note, and that there are few drives."""
    return f"{note} {few_seeds_note([len(found)], 'drive')}".strip()


def _event_row(found: Sequence[Findings], name: str) -> Row:
    """The counts and rates of one name."""
    counts = [each.counts.get(name, EventCounts()) for each in found]
    events = np.array([each.events for each in counts], float)

    def per_event(get: Callable[[EventCounts], int]) -> Row:
        return rate(np.array([get(each) for each in counts], float), events).cells

    return (
        name,
        None if name == NO_EVENT else int(events.sum()),
        sum(each.switches for each in counts),
        *per_event(lambda each: each.switches),
        sum(each.fragments for each in counts),
        *per_event(lambda each: each.fragments),
        sum(each.switch_share for each in counts),
        sum(each.fragment_share for each in counts),
    )


def cause_table(found: Sequence[Findings]) -> Table:
    """A row a source: the switches that hang on it; then those that no single source explains.

    alone: only this source removes them. share: with an equal part of those that several sources
    remove, each alone.
    """
    columns = ("hangs on", "alone", "one of several", "switches", *with_ends("share"))
    switched = [[case for case in each.cases if case.switched] for each in found]
    whole = np.array([len(cases) for cases in switched], float)
    named = [name for cases in switched for case in cases for name in case.sources]
    rows: list[Row] = []
    for source in sorted(set(named), key=lambda name: -_parts(switched, name).sum()):
        parts = _parts(switched, source)
        mine = [case for cases in switched for case in cases if source in case.sources]
        alone = sum(case.verdict == ONE_SOURCE for case in mine)
        some = sum(case.verdict == EITHER_SOURCE for case in mine)
        rows.append((source, alone, some, float(parts.sum()), *rate(parts, whole, 1.0).cells))
    for verdict in (verdict for verdict in VERDICTS if verdict not in (ONE_SOURCE, EITHER_SOURCE)):
        counts = [sum(case.verdict == verdict for case in cases) for cases in switched]
        parts = np.array(counts, float)
        row = (f"unexplained: {verdict}", None, None, float(parts.sum()))
        rows.append((*row, *rate(parts, whole, 1.0).cells))
    rows.append((ALL, None, None, float(whole.sum()), None, None, None))
    note = _with_few(_control_note(switched), found)
    return Table.of("causes", "What the switches hang on", columns, rows, note)


def _parts(switched: Sequence[Sequence[Case]], source: str) -> np.ndarray:
    """A source's part of the switches of each drive."""
    return np.array(
        [sum(1.0 / len(c.sources) for c in cases if source in c.sources) for cases in switched]
    )


def _control_note(switched: Sequence[Sequence[Case]]) -> str:
    """How the table is meant, and what the control said."""
    note = (
        "A source explains a switch when the switch is gone with this source alone off around it, "
        "all other draws equal."
    )
    asked = [c.by_control for cases in switched for c in cases if c.by_control is not None]
    if asked:
        note += (
            f" Control: {sum(asked)} of {len(asked)} switches with one source also vanish when it "
            "is off only before that."
        )
    return note


def cuboid_table(found: Sequence[Findings]) -> Table | None:
    """What is wrong with cuboids around each kind of event; None where there are none."""
    known = [name for each in found for name in each.cuboids]
    if not known:
        return None
    named = [name for kind in EVENT_KINDS for name in bin_names(kind) if name in known]
    rows: list[Row] = []
    for name in (*named, OTHER_ROWS, ALL_ROWS):
        parts = [each.cuboids.get(name, CuboidCounts()) for each in found]
        counts = sum(parts, start=CuboidCounts())
        if not counts.rows and name not in EVENT_KINDS:
            continue
        shares = (counts.near, counts.wrong, counts.backwards)
        parts_of = [part / counts.rows for part in shares] if counts.rows else [None] * 3
        mean = counts.metres / counts.rows if counts.rows else None
        rows.append((name, counts.rows, mean, *parts_of))
    columns = (
        "around", Column("rows", "count"), Column("centre, mean m", "value", digits=2),
        Column("within 2 m", "rate"), Column("heading > 30°", "rate"), Column("> 90°", "rate"),
    )  # fmt: skip
    note = (
        f"Rows that meet a label in the image, from {CONTEXT_SECONDS:g} s before an event of their "
        "car to as long after it; around several events they count for each."
    )
    return Table.of("cuboids", "Where cuboids are wrong", columns, rows, note)


def drive_table(found: Sequence[Findings]) -> Table:
    """A row a drive, and the mean over drives with its interval."""
    columns = ("drive", "frames", "cars", *with_ends("switches"), *with_ends("fragments"))
    none = (None, None)
    rows: list[Row] = [
        (each.drive, each.frames, each.cars, each.switches, *none, each.fragments, *none)
        for each in found
    ]
    means = [
        mean_count([getattr(each, name) for each in found]) for name in ("switches", "fragments")
    ]
    rows.append((A_DRIVE, None, None, *means[0].cells, *means[1].cells))
    return Table.of("drives", "Drive by drive", columns, rows, _with_few("", found))


def case_table(found: Sequence[Findings]) -> Table:
    """A row a switch or fragment."""
    columns = (
        "drive", "before", "frame", "car", "old name", "name", "switch", "fragment", "weight",
        "around", "verdict", "hangs on",
    )  # fmt: skip
    rows = [
        (
            case.drive, case.before, case.frame, case.car, case.old_track_id, case.track_id,
            int(case.switched), int(case.broken), case.weight, "; ".join(case.around), case.verdict,
            " or ".join(case.sources),
        )
        for each in found
        for case in each.cases
    ]  # fmt: skip
    return Table.of("cases", "Every switch and fragment", columns, rows)


def tables_of(found: Sequence[Findings], attributed: bool) -> tuple[Table, ...]:
    """All tables. attributed: whether causes were asked for."""
    causes = (cause_table(found),) if attributed else ()
    cuboids = cuboid_table(found)
    of_cuboids = () if cuboids is None else (cuboids,)
    return (event_table(found), *causes, *of_cuboids, drive_table(found), case_table(found))


def for_terminal(table: Table) -> Table:
    """A table for the terminal: rates in percent, intervals by their ends.

    The bins of a kind of event stand below it; shares among kinds are left to the files.
    """
    columns = [
        replace(column, title=PRINTED_TITLES[column.name], kind="rate", digits=0, shows_ends=True)
        if column.name in PRINTED_TITLES
        else replace(column, digits=1, shows_ends=True)
        for column in table.columns
    ]
    kept = [place for place, column in enumerate(columns) if column.name not in UNPRINTED]
    rows = tuple(tuple(_without_kind(row[place]) for place in kept) for row in table.rows)
    return replace(table, columns=tuple(columns[place] for place in kept), rows=rows, sums=1)


def _without_kind(cell: Cell) -> Cell:
    """A bin without the name of its kind; anything else as it is."""
    kind, comma, name = cell.partition(", ") if isinstance(cell, str) else ("", "", "")
    return f"  {name}" if comma and kind in EVENT_KINDS else cell


def write_tables(
    folder: Path,
    title: str,
    tables: Sequence[Table],
    files: Sequence[str] = (),
    *,
    finished: bool = True,
    drives: tuple[int, int] | None = None,
) -> None:
    """Write NAME.parquet and NAME.csv of every table, and `result.json` for the report.

    files: pictures, relative to the folder. drives: done and wanted. Raises BadOutput.
    """
    for table in tables:
        content = table.as_arrow()
        with whole_file(folder / f"{table.name}.parquet") as half:
            pq.write_table(content, half)
        with whole_file(folder / f"{table.name}.csv") as half:
            pacsv.write_csv(content, half)
    made = made_here(finished=finished, trials=drives)
    write_result(folder, Result("diagnosis", title, made, tuple(tables), tuple(files)))
