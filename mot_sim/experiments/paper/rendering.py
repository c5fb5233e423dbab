"""Tables of measured rows beside quoted ones, and of means with intervals."""

from collections.abc import Mapping, Sequence
from typing import Literal

from mot_sim.experiments.paper.made_rows import PairedScores
from mot_sim.experiments.paper.quoted import Quoted
from mot_sim.experiments.sweep.summary_tables import TITLES, shown
from mot_sim.metrics import Scores
from mot_sim.tables.grid import RATES, Column, Table, Value

QUOTED = "* "  # before a row that the paper prints
SHARES = {"MTR": "MT %", "PTR": "PT %", "MLR": "ML %"}


def score_rows(
    title: str,
    names: Sequence[str],
    ours: Mapping[str, Scores],
    theirs: Mapping[str, Quoted] | None = None,
) -> Table:
    """A row a measurement, then those that are quoted, which are marked."""
    rows: list[tuple[Value, ...]] = [
        (name, *(scores[column] for column in names)) for name, scores in ours.items()
    ]
    quoted = quoted_rows(title, names, theirs or {})
    return Table(quoted.columns, (*rows, *quoted.rows), quoted.title, len(quoted.rows))


def quoted_rows(title: str, names: Sequence[str], rows: Mapping[str, Quoted]) -> Table:
    """Rows of the paper; rates there are percentages already."""
    columns = (Column(""), *(Column(_title(name), _kind(name)) for name in names))
    cells: list[tuple[Value, ...]] = []
    for row, values in rows.items():
        scaled = (
            value / 100.0 if value is not None and _kind(name) == "rate" else value
            for name, value in zip(names, values, strict=True)
        )
        cells.append((QUOTED + row, *scaled))
    told = f"{title}; {QUOTED.strip()} quoted, not reproduced" if rows else title
    return Table(columns, tuple(cells), told)


def interval_table(
    title: str, pooled: PairedScores, names: Sequence[str], against: str | None = None
) -> Table:
    """A row a tracker: means with half of the 95 % interval, and differences of MOTA and IDSW.

    against: the tracker that is taken off, drive by drive.
    """
    compared = [name for name in ("MOTA", "IDSW") if against and name in names]
    columns = (
        Column(""),
        *(Column(_title(name)) for name in names),
        *(Column(f"{name} - {against}") for name in compared),
        Column("drives", "count"),
    )
    rows: list[tuple[Value, ...]] = []
    for tracker in pooled.rows:
        means = [shown(pooled.mean(tracker, name), name) for name in names]
        less = [
            ""
            if tracker == against
            else shown(pooled.less(tracker, str(against), name), name, True)
            for name in compared
        ]
        rows.append((tracker, *means, *less, len(pooled.rows[tracker])))
    return Table(columns, tuple(rows), f"{title}; mean ± half of the 95 % interval, rates in %")


def _kind(name: str) -> Literal["rate", "count"]:
    return "rate" if name in RATES.values() or name in SHARES else "count"


def _title(name: str) -> str:
    return SHARES.get(name) or TITLES.get(name, name)
