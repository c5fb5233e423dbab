"""Tables of a result as HTML that needs no script."""

from mot_sim.experiments.results.result_file import Cell, ResultTable
from mot_sim.report.page.cells import ShownColumn, is_fraction, shown_columns, with_ends, word
from mot_sim.report.page.markup import Child, Markup, element, joined

MOST_ROWS = 400  # of a table; the rest stands in the folder
TALL = 18  # rows from which a table scrolls in a window of its own
LONG = 60  # letters from which a cell keeps its lines
OF_METRIC = ("bound", "reached")  # columns whose rows are each of the metric beside them
TONES = {"pass": "good", "FAIL": "bad"}


def table_markup(table: ResultTable) -> Markup:
    """The table with its caption; values with their intervals in one cell."""
    columns = shown_columns(table)
    if not columns:
        return Markup("")
    head = element(
        "tr",
        *(
            element("th", column.title, scope="col", class_=_kind(column) or None)
            for column in columns
        ),
    )
    rows = [_row(table, row, columns) for row in table.rows[:MOST_ROWS]]
    if not rows:
        rows = [element("tr", element("td", "no rows", colspan=len(columns), class_="faint"))]
    notes = [part for part in (table.note, _left_out(table)) if part]
    caption = element(
        "caption", table.title or table.name,
        element("span", " ".join(notes), class_="faint") if notes else None,
    )  # fmt: skip
    content = element("table", caption, element("thead", head), element("tbody", *rows))
    tall = " tall" if len(rows) > TALL else ""
    return element(
        "div", content, class_=f"scroll{tall}", role="region", tabindex=0,
        aria_label=table.title or table.name,
    )  # fmt: skip


def _left_out(table: ResultTable) -> str:
    """What is said of rows that are not shown."""
    more = len(table.rows) - MOST_ROWS
    return f"{MOST_ROWS} of {len(table.rows):,} rows; all stand in result.json." if more > 0 else ""


def _row(table: ResultTable, row: tuple[Cell, ...], columns: list[ShownColumn]) -> Markup:
    """A row; its first cell names it."""
    values = dict(zip(table.columns, row, strict=True))
    cells = []
    for place, column in enumerate(columns):
        text = _text(table, values, column)
        tone = TONES.get(text) if column.name == "verdict" else None
        long = "long" if len(text) > LONG or "\n" in text else None
        class_ = " ".join(part for part in (_kind(column) or "text", tone, long) if part)
        if place == 0 and not column.is_number:
            cells.append(element("th", text, scope="row"))
        else:
            cells.append(element("td", _with_faint_spread(text, column), class_=class_))
    return element("tr", joined(*cells))


def _text(table: ResultTable, values: dict[str, Cell], column: ShownColumn) -> str:
    """A cell, with its interval where it has one."""
    value = values[column.name]
    is_part = column.is_fraction
    if column.name in OF_METRIC and isinstance(values.get("metric"), str):
        is_part = is_fraction(str(values["metric"]), table)
    sign = "+" if table.name == "differences" and column.low is not None else ""
    if column.low is None or column.high is None:
        return word(value, is_part, sign)
    return with_ends(value, values[column.low], values[column.high], is_part, sign)


def _with_faint_spread(text: str, column: ShownColumn) -> Child:
    """The cell with its interval set apart, which leaves the value to be read first."""
    value, space, spread = text.partition(" ")
    if column.low is None or not space:
        return text
    return joined(value, " ", element("span", spread, class_="spread"))


def _kind(column: ShownColumn) -> str:
    return "number" if column.is_number else ""


__all__ = ["table_markup"]
