"""Tables on a terminal: folded into groups of columns, so that nothing is ever cut."""

from collections.abc import Callable, Iterator, Sequence

from rich import box
from rich.console import Console, ConsoleOptions
from rich.measure import Measurement
from rich.segment import Segment
from rich.table import Table as RichTable
from rich.text import Text

from mot_sim.tables.columns import Row, ShownColumn

MAX_COLUMNS = 100_000  # wider than any terminal: to ask how much a table wants
MIN_TEXT_COLUMNS = 16  # that a column of free text keeps when it is folded


def folded(
    columns: Sequence[ShownColumn], rows: Sequence[Row], sums: int, console: Console,
    options: ConsoleOptions,
) -> Iterator[Segment]:  # fmt: skip
    """What is too wide becomes several tables below one another.

    Each has the columns that name the rows, and some of the others: rates first. Free text is
    folded at words. Numbers and names are never cut: a table that cannot be narrower than the
    terminal is wider than it.
    """

    def needed(group: Sequence[ShownColumn]) -> int:
        narrow = rich_table(group, rows, text_width=MIN_TEXT_COLUMNS)
        return Measurement.get(console, options.update(width=MAX_COLUMNS), narrow).maximum

    for group in _groups(columns, lambda some: needed(some) <= options.max_width):
        room = options.update(width=max(needed(group), options.max_width))
        yield from console.render(rich_table(group, rows, sums), room)


def _groups(
    shown: Sequence[ShownColumn], fits: Callable[[Sequence[ShownColumn]], bool]
) -> Iterator[Sequence[ShownColumn]]:
    """The columns that stand side by side: all of them, or the names with some of the others."""
    names = [each for each in shown if _is_name(each)]
    others = [each for each in shown if not _is_name(each)]
    if not others or fits(shown):
        yield shown
        return
    for is_rate in (True, False):
        group: list[ShownColumn] = []
        for each in others:
            if (each.column.kind == "rate") != is_rate:
                continue
            if group and not fits([*names, *group, each]):
                yield [*names, *group]
                group = []
            group.append(each)
        if group:
            yield [*names, *group]


def _is_name(shown: ShownColumn) -> bool:
    """Whether a column says what the rows are of."""
    return shown.place == 0 or shown.column.kind == "name"


def _is_text(shown: ShownColumn) -> bool:
    """Whether a column may be folded at words."""
    return shown.column.kind == "text" and not _is_name(shown)


def rich_table(
    group: Sequence[ShownColumn], rows: Sequence[Row], sums: int = 0, text_width: int | None = None
) -> RichTable:
    """Some columns of a table as rich draws them. text_width: at most, of free text."""
    drawn = RichTable(box=box.SIMPLE_HEAD, collapse_padding=True, pad_edge=False)
    for each in group:
        is_text = _is_text(each)
        drawn.add_column(
            Text(each.column.title), justify="right" if each.is_number else "left",
            no_wrap=not is_text, overflow="fold", max_width=text_width if is_text else None,
        )  # fmt: skip
    for number, row in enumerate(rows):
        if number == len(rows) - sums:
            drawn.add_section()
        drawn.add_row(*(Text(each.text(row)) for each in group))
    return drawn
