"""One list of rows, four ways to write it."""

import io

import pytest
from rich.console import Console

from mot_sim.metrics import evaluate_sequence
from mot_sim.tables import COUNTS, RATES, Column, Table, score_table
from tracker import Tracks

TABLE = Table(
    (Column("who"), Column("rate", "rate"), Column("boxes", "count")),
    (("a|b", 0.123456, 1234), ("c", None, 7)),
)


def shown(table: Table, width: int) -> list[str]:
    """The words of the table's lines on a terminal of this width."""
    text = io.StringIO()
    Console(file=text, width=width).print(table)
    return [line.split() for line in text.getvalue().split("\n") if line.strip()]


def test_text_shows_percent_and_thousands() -> None:
    assert shown(TABLE, 60)[0] == ["who", "rate", "boxes"]
    assert shown(TABLE, 60)[2] == ["a|b", "12.35", "1,234"]


def test_markdown_keeps_its_columns() -> None:
    assert TABLE.as_markdown().split("\n")[:4] == [
        "| who | rate | boxes |",
        "| --- | ---: | ---: |",
        r"| a\|b | 12.35 | 1,234 |",
        "| c |  | 7 |",
    ]


def test_csv_and_records_round_nothing() -> None:
    assert TABLE.as_csv() == "who,rate,boxes\na|b,0.123456,1234\nc,,7\n"
    assert TABLE.as_records()[1] == {"who": "c", "rate": None, "boxes": 7}


@pytest.mark.parametrize("rules", ["trackeval", "devkit2018"])
def test_scores_that_the_rules_do_not_know_have_no_column(rules: str) -> None:
    nothing = evaluate_sequence(Tracks.empty(), Tracks.empty(), 1, rules)
    titles = [column.title for column in score_table({"x": nothing}).columns]
    assert ("HOTA" in titles) == (rules == "trackeval")
    assert titles[0] == "sequence"
    assert titles[-len(COUNTS) :] == list(COUNTS)


def test_a_narrow_terminal_gets_two_tables_and_loses_nothing() -> None:
    scores = {"combined": evaluate_sequence(Tracks.empty(), Tracks.empty(), 1)}
    wide, narrow = shown(score_table(scores), 150), shown(score_table(scores), 80)
    assert wide[0] == ["sequence", *RATES, *COUNTS]
    assert narrow[0] == ["sequence", *RATES]
    assert ["sequence", *COUNTS] in narrow


def test_a_table_without_rows_is_its_header() -> None:
    empty = Table((Column("who"), Column("n", "count")), ())
    assert shown(empty, 40)[0] == ["who", "n"]
    assert empty.as_csv() == "who,n\n"
