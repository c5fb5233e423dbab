"""The findings of many drives as tables: by event, by cause, drive by drive, case by case."""

from collections.abc import Callable, Sequence

import numpy as np

from mot_sim.diagnosis.attribution import EITHER_SOURCE, ONE_SOURCE, VERDICTS
from mot_sim.diagnosis.context_events import KINDS, bin_names
from mot_sim.diagnosis.findings import NO_EVENT, Case, EventCounts, Findings
from mot_sim.diagnosis.rates import mean_count, rate
from mot_sim.experiments.results.result_file import Cell, ResultTable
from mot_sim.experiments.sweep.summary import Interval
from mot_sim.tables.grid import Column, Table, Value

ALL, A_DRIVE = "all", "a drive"
RATE, BROKEN_RATE = "switches per event", "fragments per event"
SHARES = ("switch share", "fragment share")
# For the terminal: what is left out, and what others are called and multiplied with.
UNSHOWN = SHARES
SHOWN_AS = {RATE: ("per 100", 100.0), BROKEN_RATE: (" per 100", 100.0), "share": ("percent", 100.0)}


def ends(name: str) -> tuple[str, str, str]:
    """The columns of a value and of the ends of its interval."""
    return name, f"{name} low", f"{name} high"


def _cells(interval: Interval) -> tuple[Cell, ...]:
    return interval.mean, interval.low, interval.high


def event_table(found: Sequence[Findings]) -> ResultTable:
    """A row a kind of event, its bins after it; the shares of the kinds add up to the last row."""
    columns = (
        "around", "events", "switches", *ends(RATE), "fragments", *ends(BROKEN_RATE),
        *SHARES,
    )  # fmt: skip
    known = [kind for kind in KINDS if any(kind in each.known for each in found)]
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
    lacking = [kind for kind in KINDS if kind not in known]
    if lacking:
        note += f" The data do not tell of: {', '.join(lacking)}."
    return ResultTable(
        "events", "Switches and fragments by what happened around them", columns, tuple(rows), note
    )


def _event_row(found: Sequence[Findings], name: str) -> tuple[Cell, ...]:
    """The counts and rates of one name."""
    counts = [each.counts.get(name, EventCounts()) for each in found]
    events = np.array([each.events for each in counts], float)

    def per_event(get: Callable[[EventCounts], int]) -> tuple[Cell, ...]:
        return _cells(rate(np.array([get(each) for each in counts], float), events))

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


def cause_table(found: Sequence[Findings]) -> ResultTable:
    """A row a source: the switches that hang on it; then those that no single source explains.

    alone: only this source removes them. share: with an equal part of those that several sources
    remove, each alone.
    """
    columns = ("hangs on", "alone", "one of several", "switches", *ends("share"))
    switched = [[case for case in each.cases if case.switched] for each in found]
    whole = np.array([len(cases) for cases in switched], float)
    named = [name for cases in switched for case in cases for name in case.sources]
    rows: list[tuple[Cell, ...]] = []
    for source in sorted(set(named), key=lambda name: -_parts(switched, name).sum()):
        parts = _parts(switched, source)
        mine = [case for cases in switched for case in cases if source in case.sources]
        alone = sum(case.verdict == ONE_SOURCE for case in mine)
        some = sum(case.verdict == EITHER_SOURCE for case in mine)
        rows.append((source, alone, some, float(parts.sum()), *_cells(rate(parts, whole, 1.0))))
    for verdict in (verdict for verdict in VERDICTS if verdict not in (ONE_SOURCE, EITHER_SOURCE)):
        counts = [sum(case.verdict == verdict for case in cases) for cases in switched]
        parts = np.array(counts, float)
        row = (f"unexplained: {verdict}", None, None, float(parts.sum()))
        rows.append((*row, *_cells(rate(parts, whole, 1.0))))
    rows.append((ALL, None, None, float(whole.sum()), None, None, None))
    return ResultTable("causes", "What the switches hang on", columns, tuple(rows), _note(switched))


def _parts(switched: Sequence[Sequence[Case]], source: str) -> np.ndarray:
    """A source's part of the switches of each drive."""
    return np.array(
        [sum(1.0 / len(c.sources) for c in cases if source in c.sources) for cases in switched]
    )


def _note(switched: Sequence[Sequence[Case]]) -> str:
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


def drive_table(found: Sequence[Findings]) -> ResultTable:
    """A row a drive, and the mean over drives with its interval."""
    columns = ("drive", "frames", "cars", *ends("switches"), *ends("fragments"))
    none = (None, None)
    rows: list[tuple[Cell, ...]] = [
        (each.drive, each.frames, each.cars, each.switches, *none, each.fragments, *none)
        for each in found
    ]
    means = [
        mean_count([getattr(each, name) for each in found]) for name in ("switches", "fragments")
    ]
    rows.append((A_DRIVE, None, None, *_cells(means[0]), *_cells(means[1])))
    return ResultTable("drives", "Drive by drive", columns, tuple(rows))


def case_table(found: Sequence[Findings]) -> ResultTable:
    """A row a switch or fragment."""
    columns = (
        "drive", "before", "frame", "car", "old name", "name", "switch", "fragment", "weight",
        "around", "verdict", "hangs on",
    )  # fmt: skip
    rows = tuple(
        (
            case.drive, case.before, case.frame, case.car, case.old_track_id, case.track_id,
            int(case.switched), int(case.broken), case.weight, "; ".join(case.around), case.verdict,
            " or ".join(case.sources),
        )
        for each in found
        for case in each.cases
    )  # fmt: skip
    return ResultTable("cases", "Every switch and fragment", columns, rows)


def tables_of(found: Sequence[Findings], attributed: bool) -> tuple[ResultTable, ...]:
    """All tables. attributed: whether causes were asked for."""
    causes = (cause_table(found),) if attributed else ()
    return (event_table(found), *causes, drive_table(found), case_table(found))


def shown(table: ResultTable) -> Table:
    """A table for the terminal: an interval stands beside its value, rates in percent.

    The bins of a kind of event stand below it; shares among kinds are left to the files.
    """
    columns: list[Column] = []
    parts: list[tuple[Value, ...]] = []
    for place, name in enumerate(table.columns):
        is_end = name.removesuffix(" low").removesuffix(" high") in table.columns[:place]
        if is_end or name in UNSHOWN:
            continue
        cells = table.column(name)
        title, scale = SHOWN_AS.get(name, (name, 1.0))
        if f"{name} low" in table.columns:
            low, high = table.column(f"{name} low"), table.column(f"{name} high")
            cells = tuple(_shown(*row, scale) for row in zip(cells, low, high, strict=True))
        columns.append(Column(title))
        parts.append(tuple(_word(cell) for cell in cells))
    return Table(tuple(columns), tuple(zip(*parts, strict=True)), table.title, sums=1)


def csv_of(table: ResultTable) -> str:
    """The whole table as comma-separated values, nothing rounded."""
    return Table(tuple(Column(name) for name in table.columns), table.rows).as_csv()


def _word(cell: Cell) -> Value:
    """A bin without the name of its kind, a fraction with one digit, anything else as it is."""
    if isinstance(cell, float):
        return round(cell, 1)
    kind, comma, name = cell.partition(", ") if isinstance(cell, str) else ("", "", "")
    return f"  {name}" if comma and kind in KINDS else cell


def _shown(mean: Cell, low: Cell, high: Cell, scale: float) -> Cell:
    """A mean and its interval in one word."""
    if not isinstance(mean, int | float):
        return None
    digits = 1 if scale == 1.0 and isinstance(mean, float) else 0
    if not isinstance(low, int | float) or not isinstance(high, int | float):
        return f"{scale * mean:.{digits}f}"
    return f"{scale * mean:.{digits}f} [{scale * low:.{digits}f}, {scale * high:.{digits}f}]"


__all__ = [
    "case_table",
    "cause_table",
    "csv_of",
    "drive_table",
    "event_table",
    "shown",
    "tables_of",
]
