"""The one table type: rows under typed columns, and a writer for each format."""

import csv
import io
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

from rich.console import Console, ConsoleOptions, RenderableType
from rich.segment import Segment
from rich.text import Text

from mot_sim.metrics import Scores
from mot_sim.tables.columns import COLUMN_KINDS, Cell, Column, Row, ShownColumn
from mot_sim.tables.folding import folded
from mot_sim.tables.score_names import COUNTS, RATES
from tracker.errors import BadConfig, UnknownName

if TYPE_CHECKING:
    import pyarrow as pa

MAX_DIGITS = 15  # behind the point


@dataclass(frozen=True)
class Table:
    """Rows under columns, as they were computed: rates are fractions, nothing is rounded.

    The 95 % interval of a column X stands in the columns "X low" and "X high"; people see it
    beside the value. Raises BadConfig for a column that stands twice, and for rows of another
    length.
    """

    columns: tuple[Column, ...]
    """The columns; the first one names the rows."""
    rows: tuple[Row, ...]
    """One value per column, None where there is none."""
    title: str = ""
    """What is shown above the table."""
    sums: int = 0
    """How many of the last rows are set apart, because they sum up the others."""
    name: str = ""
    """A short word that a program finds the table by."""
    note: str = ""
    """What is said below the table."""

    def __post_init__(self) -> None:
        if len(set(self.names)) != len(self.names):
            raise BadConfig(f"table {self.name}: two columns of one name: {list(self.names)}")
        for number, row in enumerate(self.rows, 1):
            if len(row) != len(self.columns):
                raise BadConfig(
                    f"table {self.name}, row {number}: {len(row)} values where "
                    f"{len(self.columns)} belong: {list(row)!r:.80}"
                )
        plain = tuple(tuple(_plain(cell) for cell in row) for row in self.rows)
        object.__setattr__(self, "rows", plain)

    @classmethod
    def of(
        cls, name: str, title: str, columns: Sequence[str | Column], rows: Sequence[Row],
        note: str = "",
    ) -> "Table":  # fmt: skip
        """A table as files hold it; columns by their names are what these stand for."""
        typed = (Column.named(each) if isinstance(each, str) else each for each in columns)
        return cls(tuple(typed), tuple(rows), title, name=name, note=note)

    @cached_property
    def names(self) -> tuple[str, ...]:
        """The names of the columns."""
        return tuple(column.name for column in self.columns)

    def has(self, *names: str) -> bool:
        """Whether there are columns of all these names."""
        return set(names) <= set(self.names)

    def column(self, name: str) -> tuple[Cell, ...]:
        """The values of a column. Raises UnknownName."""
        place = self._place(name)
        return tuple(row[place] for row in self.rows)

    def typed(self, name: str) -> Column:
        """A column's title and kind. Raises UnknownName."""
        return self.columns[self._place(name)]

    def _place(self, name: str) -> int:
        if name not in self.names:
            raise UnknownName.of(f"column of table {self.name}", name, self.names)
        return self.names.index(name)

    @cached_property
    def shown_columns(self) -> tuple[ShownColumn, ...]:
        """The columns as people see them, with the ends of an interval in that of its value."""
        places = {name: place for place, name in enumerate(self.names)}
        ends = {
            name: (places[f"{name} low"], places[f"{name} high"])
            for name in self.names
            if {f"{name} low", f"{name} high"} <= places.keys()
        }
        inside = {place for pair in ends.values() for place in pair}
        shown = []
        for place, column in enumerate(self.columns):
            if place not in inside:
                low, high = ends.get(column.name, (None, None))
                is_number = low is not None or self._is_number(place)
                shown.append(ShownColumn(column, place, low, high, is_number))
        return tuple(shown)

    def _is_number(self, place: int) -> bool:
        values = [row[place] for row in self.rows if row[place] is not None]
        if not values:
            return self.columns[place].kind in ("rate", "count")
        return all(isinstance(each, float | int) and not isinstance(each, bool) for each in values)

    def shown_rows(self) -> list[tuple[str, ...]]:
        """The cells of every row as text, intervals beside their values."""
        return [tuple(each.text(row) for each in self.shown_columns) for row in self.rows]

    def __rich_console__(
        self, console: Console, options: ConsoleOptions
    ) -> Iterable[RenderableType | Segment]:
        """The title, the table folded to the width of the terminal, the note."""
        if self.title:
            yield Text(self.title, style="table.title")
        yield from folded(self.shown_columns, self.rows, self.sums, console, options)
        if self.note:
            yield Text(f"{self.note}\n")

    def as_markdown(self) -> str:
        """A GitHub table, and its note."""
        shown = self.shown_columns
        lines = [
            [each.column.title for each in shown],
            ["---:" if each.is_number else "---" for each in shown],
            *([cell.replace("|", r"\|") for cell in row] for row in self.shown_rows()),
        ]
        text = "".join(f"| {' | '.join(line)} |\n" for line in lines)
        return f"{text}\n{self.note}\n" if self.note else text

    def as_csv(self) -> str:
        """Comma-separated values with a header; rates as fractions, nothing rounded."""
        text = io.StringIO()
        writer = csv.writer(text, lineterminator="\n")
        writer.writerow(self.names)
        writer.writerows(self.rows)
        return text.getvalue()

    def as_records(self) -> list[dict[str, Cell]]:
        """One dictionary a row; rates as fractions, nothing rounded."""
        return [dict(zip(self.names, row, strict=True)) for row in self.rows]

    def as_arrow(self) -> "pa.Table":
        """Columns of one type each, for Parquet: words, whole numbers or fractions."""
        import pyarrow as pa

        columns = {}
        for name in self.names:
            cells = self.column(name)
            kinds = {type(cell) for cell in cells if cell is not None}
            kind = pa.string() if str in kinds else pa.float64() if float in kinds else pa.int64()
            columns[name] = pa.array(cells, kind)
        return pa.table(columns)

    def as_content(self) -> dict[str, Any]:
        """What a `result.json` holds of it; see `table_of`."""
        return {
            "name": self.name, "title": self.title, "columns": list(self.names),
            "kinds": [column.kind for column in self.columns],
            "titles": [column.title for column in self.columns],
            "digits": [column.digits for column in self.columns],
            "rows": self.rows, "note": self.note,
        }  # fmt: skip


def table_of(content: Mapping[str, Any]) -> Table:
    """The table that `Table.as_content` gave; kinds, titles and digits may be absent.

    Python's own errors for what does not fit, BadConfig as `Table`.
    """
    names = content["columns"]
    kinds = content.get("kinds") or [None] * len(names)
    for kind in kinds:
        if kind is not None and kind not in COLUMN_KINDS:
            raise ValueError(f"{kind!r:.40} is no kind of column")
    columns = [Column.named(name, kind) for name, kind in zip(names, kinds, strict=True)]
    titles = content.get("titles") or [column.title for column in columns]
    digits = content.get("digits") or [None] * len(names)
    for title, digit in zip(titles, digits, strict=True):
        if not isinstance(title, str):
            raise TypeError(f"{title!r:.40} is no title of a column")
        if digit is not None and (type(digit) is not int or not 0 <= digit <= MAX_DIGITS):
            raise ValueError(f"{digit!r:.40} is no number of digits, 0 to {MAX_DIGITS}")
    columns = [
        replace(column, title=title, digits=digit)
        for column, title, digit in zip(columns, titles, digits, strict=True)
    ]
    return Table.of(content["name"], content["title"], columns, content["rows"], content["note"])


def with_ends(column: str | Column) -> tuple[Column, Column, Column]:
    """A column, or the one that a name stands for, with the ends of its interval."""
    given = Column.named(column) if isinstance(column, str) else column
    low, high = (Column.named(f"{given.name} {end}", given.kind) for end in ("low", "high"))
    return given, low, high


def mean_column(metric: str, title: str = "", is_signed: bool = False) -> Column:
    """How a mean of a score over seeds is printed: rates with two digits, others with one."""
    plain = Column.named(metric)
    digits = None if plain.kind == "rate" else 1
    return Column(title or plain.title, plain.kind, title or metric, digits, is_signed)


def score_table(
    scores: Mapping[str, Scores], first: str = "sequence", title: str = "", sums: int = 0
) -> Table:
    """A row for each of the scores; what their rules do not know has no column."""
    known = {name for each in scores.values() for name in each.numbers()}
    rates = {rate: name for rate, name in RATES.items() if name in known}
    columns = (
        Column(first, "name"),
        *(Column(rate, "rate") for rate in rates),
        *(Column(count, "count") for count in COUNTS),
    )
    rows: list[Row] = []
    for name, each in scores.items():
        values = (float(each[rate]) for rate in rates.values())
        rows.append((name, *values, *(int(each[count]) for count in COUNTS.values())))
    return Table(columns, tuple(rows), title, sums)


def _plain(cell: Any) -> Cell:
    """A number of Python instead of NumPy's."""
    return cell.item() if hasattr(cell, "item") else cell
