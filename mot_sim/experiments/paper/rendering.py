"""Tables of measured rows beside quoted ones, and of means with intervals."""

from collections.abc import Mapping, Sequence

from mot_sim.experiments.paper.made_rows import PairedScores
from mot_sim.experiments.paper.quoted import Quoted
from mot_sim.metrics import Scores
from mot_sim.tables import (
    NO_INTERVAL,
    SHARES,
    Column,
    Row,
    Table,
    few_seeds_note,
    is_rate,
    mean_column,
    title_of,
    with_ends,
)

QUOTED_MARK = "* "  # before a row that the paper prints


def score_rows(
    title: str,
    names: Sequence[str],
    ours: Mapping[str, Scores],
    theirs: Mapping[str, Quoted] | None = None,
) -> Table:
    """A row a measurement, then those that are quoted, which are marked."""
    rows = [(name, *(scores[column] for column in names)) for name, scores in ours.items()]
    quoted = quoted_rows(title, names, theirs or {})
    return Table(quoted.columns, (*rows, *quoted.rows), quoted.title, len(quoted.rows))


def quoted_rows(title: str, names: Sequence[str], rows: Mapping[str, Quoted]) -> Table:
    """Rows of the paper; rates there are percentages already."""
    columns = (
        Column("", "name"),
        *(Column(_title(name), "rate" if is_rate(name) else "count") for name in names),
    )
    cells: list[Row] = []
    for row, values in rows.items():
        scaled = (
            value / 100.0 if value is not None and is_rate(name) else value
            for name, value in zip(names, values, strict=True)
        )
        cells.append((QUOTED_MARK + row, *scaled))
    told = f"{title}; {QUOTED_MARK.strip()} quoted, not reproduced" if rows else title
    return Table(columns, tuple(cells), told)


def interval_table(
    title: str, pooled: PairedScores, names: Sequence[str], against: str | None = None
) -> Table:
    """A row a tracker: means with half of the 95 % interval, and differences of MOTA and IDSW.

    against: the tracker that is taken off, drive by drive.
    """
    compared = [name for name in ("MOTA", "IDSW") if against and name in names]
    means = [mean_column(name, _title(name)) for name in names]
    differences = [mean_column(name, f"{name} - {against}", is_signed=True) for name in compared]
    columns = (
        Column("", "name"),
        *(each for column in (*means, *differences) for each in with_ends(column)),
        Column("drives", "count"),
    )
    rows: list[Row] = []
    for tracker, drives in pooled.rows.items():
        found = [pooled.mean(tracker, name) for name in names]
        found += [
            NO_INTERVAL if tracker == against else pooled.less(tracker, str(against), name)
            for name in compared
        ]
        rows.append((tracker, *(cell for each in found for cell in each.cells), len(drives)))
    note = few_seeds_note(map(len, pooled.rows.values()), "drive")
    told = f"{title}; mean ± half of the 95 % interval, or its ends, rates in %"
    return Table(columns, tuple(rows), told, note=note)


def _title(name: str) -> str:
    return SHARES.get(name) or title_of(name)
