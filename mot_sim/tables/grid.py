"""Tables from one list of rows: for the terminal, Markdown, CSV and JSON."""

import csv
import io
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

from rich import box
from rich.console import Console, ConsoleOptions
from rich.measure import Measurement
from rich.table import Table as RichTable

from mot_sim.metrics import Scores

Value = str | float | int | None

UNBOUNDED = 10_000  # columns, wider than any terminal: to ask how much a table wants

# Title, and TrackEval's name of the score.
RATES = {
    "HOTA": "HOTA",
    "DetA": "DetA",
    "AssA": "AssA",
    "MOTA": "MOTA",
    "MOTP": "MOTP",
    "IDF1": "IDF1",
    "recall": "CLR_Re",
    "precision": "CLR_Pr",
}
COUNTS = {
    "TP": "CLR_TP",
    "FP": "CLR_FP",
    "FN": "CLR_FN",
    "IDSW": "IDSW",
    "Frag": "Frag",
    "MT": "MT",
    "PT": "PT",
    "ML": "ML",
}


@dataclass(frozen=True)
class Column:
    """A column: its title, and how its values are shown.

    kind: rates are fractions, shown in percent; CSV and JSON keep every value as it is.
    """

    title: str
    kind: Literal["text", "rate", "count"] = "text"

    def show(self, value: Value) -> str:
        """The value as text."""
        if value is None:
            return ""
        if self.kind == "rate":
            return f"{100.0 * float(value):.2f}"
        return f"{value}" if self.kind == "text" else f"{float(value):,.0f}"


@dataclass(frozen=True, eq=False)
class Table:
    """Rows under columns; the first column names the row.

    sums: how many of the last rows are set apart, because they sum up the others.
    """

    columns: tuple[Column, ...]
    rows: tuple[tuple[Value, ...], ...]
    title: str = ""
    sums: int = 0

    def __rich_console__(self, console: Console, options: ConsoleOptions) -> Iterator[RichTable]:
        """One table where it fits; else the rates above the counts, so that nothing is lost."""
        whole = self._rich(self.columns, self.title)
        rates, counts = (
            tuple(column for column in self.columns if column.kind == kind)
            for kind in ("rate", "count")
        )
        wanted = Measurement.get(console, options.update(width=UNBOUNDED), whole).maximum
        fits = wanted <= options.max_width
        if fits or not (rates and counts):
            yield whole
            return
        yield self._rich((self.columns[0], *rates), self.title)
        yield self._rich((self.columns[0], *counts))

    def as_markdown(self) -> str:
        """A GitHub table."""
        lines = [
            [column.title for column in self.columns],
            ["---" if column.kind == "text" else "---:" for column in self.columns],
            *([cell.replace("|", r"\|") for cell in self._shown(row)] for row in self.rows),
        ]
        return "".join(f"| {' | '.join(line)} |\n" for line in lines)

    def as_csv(self) -> str:
        """Comma-separated values with a header; rates as fractions, nothing rounded."""
        text = io.StringIO()
        writer = csv.writer(text, lineterminator="\n")
        writer.writerow(column.title for column in self.columns)
        writer.writerows(self.rows)
        return text.getvalue()

    def as_records(self) -> list[dict[str, Value]]:
        """One dictionary a row, for JSON; rates as fractions, nothing rounded."""
        titles = [column.title for column in self.columns]
        return [dict(zip(titles, row, strict=True)) for row in self.rows]

    def _shown(self, row: Sequence[Value]) -> list[str]:
        return [column.show(value) for column, value in zip(self.columns, row, strict=True)]

    def _rich(self, columns: Sequence[Column], title: str = "") -> RichTable:
        table = RichTable(
            box=box.SIMPLE_HEAD,
            title=title or None,
            title_justify="left",
            collapse_padding=True,
            pad_edge=False,
        )
        for column in columns:
            text = column.kind == "text"
            table.add_column(column.title, justify="left" if text else "right", no_wrap=not text)
        places = [self.columns.index(column) for column in columns]
        for number, row in enumerate(self.rows):
            if number == len(self.rows) - self.sums:
                table.add_section()
            shown = self._shown(row)
            table.add_row(*(shown[place] for place in places))
        return table


def score_grid(
    scores: Mapping[str, Scores], first: str = "sequence", title: str = "", sums: int = 0
) -> Table:
    """A row for each of the scores; what their rules do not know has no column."""
    known = {name for each in scores.values() for name in each.numbers()}
    rates = {rate: name for rate, name in RATES.items() if name in known}
    columns = (
        Column(first),
        *(Column(rate, "rate") for rate in rates),
        *(Column(count, "count") for count in COUNTS),
    )
    rows: tuple[tuple[Value, ...], ...] = tuple(
        (
            name,
            *(float(each[rate]) for rate in rates.values()),
            *(int(each[count]) for count in COUNTS.values()),
        )
        for name, each in scores.items()
    )
    return Table(columns, rows, title, sums)
