"""Tables of a result as HTML that needs no script."""

from dataclasses import replace

from mot_sim.report.page.markup import Child, Markup, element, joined
from mot_sim.tables import Row, ShownColumn, Table, is_rate

MAX_ROWS = 400  # of a table; the rest stands in the folder
MAX_ROWS_UNSCROLLED = 18  # longer tables scroll in a window of their own
MAX_LETTERS_UNBROKEN = 60  # longer cells keep their lines
OF_METRIC = ("bound", "reached")  # columns whose rows are each of the metric beside them
TONES = {"pass": "good", "FAIL": "bad"}


def shown_columns(table: Table) -> list[ShownColumn]:
    """The columns of a table but those of nothing, such as the errors where there are none."""
    return [
        each
        for each in table.shown_columns
        if each.low is not None
        or not table.rows
        or any(row[each.place] is not None for row in table.rows)
    ]


def heading(shown: ShownColumn) -> str:
    """The title of a column; of rates in percent."""
    title, is_part = shown.column.title, shown.is_number and shown.column.kind == "rate"
    return f"{title.removesuffix(' %')}, %" if is_part else title


def table_markup(table: Table) -> Markup:
    """The table with its caption; values with their intervals in one cell."""
    columns = shown_columns(table)
    if not columns:
        return Markup("")
    head = element(
        "tr",
        *(
            element("th", heading(column), scope="col", class_=_kind(column) or None)
            for column in columns
        ),
    )
    rows = [_row(table, row, columns) for row in table.rows[:MAX_ROWS]]
    if not rows:
        rows = [element("tr", element("td", "no rows", colspan=len(columns), class_="faint"))]
    notes = [part for part in (table.note, _left_out(table)) if part]
    caption = element(
        "caption", table.title or table.name,
        element("span", " ".join(notes), class_="faint") if notes else None,
    )  # fmt: skip
    content = element("table", caption, element("thead", head), element("tbody", *rows))
    tall = " tall" if len(rows) > MAX_ROWS_UNSCROLLED else ""
    return element(
        "div", content, class_=f"scroll{tall}", role="region", tabindex=0,
        aria_label=table.title or table.name,
    )  # fmt: skip


def _left_out(table: Table) -> str:
    """What is said of rows that are not shown."""
    more = len(table.rows) - MAX_ROWS
    return f"{MAX_ROWS} of {len(table.rows):,} rows; all stand in result.json." if more > 0 else ""


def _row(table: Table, row: Row, columns: list[ShownColumn]) -> Markup:
    """A row; its first cell names it."""
    cells = []
    for place, column in enumerate(columns):
        text = _text(table, row, column)
        tone = TONES.get(text) if column.column.name == "verdict" else None
        long = "long" if len(text) > MAX_LETTERS_UNBROKEN or "\n" in text else None
        class_ = " ".join(part for part in (_kind(column) or "text", tone, long) if part)
        if place == 0 and not column.is_number:
            cells.append(element("th", text, scope="row"))
        else:
            cells.append(element("td", _with_faint_spread(text, column), class_=class_))
    return element("tr", joined(*cells))


def _text(table: Table, row: Row, shown: ShownColumn) -> str:
    """A cell, with its interval where it has one."""
    column = shown.column
    metric = row[table.names.index("metric")] if table.has("metric") else None
    if column.name in OF_METRIC and isinstance(metric, str):
        column = replace(column, kind="rate" if is_rate(metric) else "value")
    is_signed = table.name == "differences" and shown.low is not None
    return replace(shown, column=replace(column, is_signed=is_signed)).text(row)


def _with_faint_spread(text: str, column: ShownColumn) -> Child:
    """The cell with its interval set apart, which leaves the value to be read first."""
    value, space, spread = text.partition(" ")
    if column.low is None or not space:
        return text
    return joined(value, " ", element("span", spread, class_="spread"))


def _kind(column: ShownColumn) -> str:
    return "number" if column.is_number else ""
