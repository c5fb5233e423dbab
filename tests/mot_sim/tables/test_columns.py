"""Values as a reader wants them."""

import numpy as np
import pytest

from mot_sim.tables import Cell, Column, Table, is_count, is_rate, show_value, with_ends


@pytest.mark.parametrize(
    ("value", "told"),
    [(None, ""), (True, "yes"), ("<b>", "<b>"), (3, "3"), (12345, "12,345"), (0.5, "0.5"),
     (0.123456, "0.123"), (1234.56, "1,235"), (123.456, "123.5"), (-2.0, "-2")],
)  # fmt: skip
def test_a_value_has_the_digits_that_count(value: Cell, told: str) -> None:
    assert show_value(value) == told


def test_parts_are_in_percent_and_signs_are_shown_on_request() -> None:
    assert show_value(0.12345, is_part=True) == "12.35"
    assert Column("", "rate", is_signed=True).show(0.1) == "+10.00"
    assert Column("", "count", is_signed=True).show(2) == "+2"


@pytest.mark.parametrize(
    ("ends", "told"),
    [
        ((0.5, 0.4, 0.6), "0.50 ±0.10"),
        ((6.0, -2.96, 14.96), "6.0 ±9.0"),
        ((0.656, 0.469, 1.06), "0.656 [0.469, 1.06]"),
        ((2.0, 1.5, None), "2 [1.5, …]"),
        ((2.0, None, None), "2"),
        ((3.0, 3.0, 3.0), "3.00 ±0.00"),
        ((None, None, None), ""),
    ],
)
def test_an_interval_is_half_of_it_or_its_ends(ends: tuple[Cell, Cell, Cell], told: str) -> None:
    assert show_value(*ends) == told


def test_digits_are_the_same_in_all_rows_where_they_are_given() -> None:
    mean = Column("IDSW", "count", digits=1)
    assert mean.show(3.0, 1.0, 5.0) == "3.0 ±2.0"
    assert mean.show(3.0, 0.0, 7.25) == "3.0 [0.0, 7.2]"
    assert Column("rate", "rate").show(0.9279, 0.5, 1.0) == "92.79 [50.00, 100.00]"
    assert Column("per 100", "rate", digits=0, shows_ends=True).show(0.5, 0.4, 0.6) == "50 [40, 60]"


def test_a_name_stands_for_its_title_and_its_kind() -> None:
    assert Column.named("CLR_FP") == Column("FP", "count", "CLR_FP")
    assert Column.named("HOTA").kind == Column.named("MOTA - all").kind == "rate"
    assert [each.name for each in with_ends("IDF1")] == ["IDF1", "IDF1 low", "IDF1 high"]
    assert {each.kind for each in with_ends("IDF1")} == {"rate"}
    assert is_count("FP")
    assert is_count("CLR_FP")
    assert not is_rate("CLR_FP")
    assert not is_count("HOTA")


def test_the_ends_of_an_interval_stand_with_its_value() -> None:
    columns = (Column("row", "name"), *with_ends("MOTA"), "drives", "low")
    table = Table.of("t", "", columns, [("all", 0.88, 0.86, 0.9, np.int64(50), 1.0)])
    assert type(table.rows[0][4]) is int
    assert [each.column.name for each in table.shown_columns] == ["row", "MOTA", "drives", "low"]
    assert [each.is_number for each in table.shown_columns] == [False, True, True, True]
    assert table.shown_rows() == [("all", "88.00 ±2.00", "50", "1")]
