"""Values as a reader wants them."""

import pytest

from mot_sim.experiments.results.result_file import Cell, ResultTable
from mot_sim.report.page.cells import number, shown_columns, with_ends, word
from mot_sim.report.page.markup import element, escaped, joined, raw


@pytest.mark.parametrize(
    ("value", "told"),
    [(None, ""), (True, "yes"), ("<b>", "<b>"), (3, "3"), (12345, "12,345"), (0.5, "0.5"),
     (0.123456, "0.123"), (1234.56, "1,235"), (123.456, "123.5"), (-2.0, "-2")],
)  # fmt: skip
def test_a_value_has_the_digits_that_count(value: Cell, told: str) -> None:
    assert word(value) == told


def test_parts_are_in_percent_and_signs_are_shown_on_request() -> None:
    assert number(0.12345, is_part=True) == "12.35"
    assert number(0.1, is_part=True, sign="+") == "+10.00"
    assert number(2, sign="+") == "+2"


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
    assert with_ends(*ends) == told


def test_the_ends_of_an_interval_stand_with_its_value_and_empty_columns_nowhere() -> None:
    table = ResultTable(
        "t", "", ("suite", "HOTA", "HOTA low", "HOTA high", "CLR_FP", "error", "low"),
        (("a", 0.5, 0.4, 0.6, 3, None, 1.0),),
    )  # fmt: skip
    shown = shown_columns(table)
    assert [each.title for each in shown] == ["suite", "HOTA, %", "FP", "low"]
    assert [each.low for each in shown] == [None, "HOTA low", None, None]
    assert [each.is_number for each in shown] == [False, True, True, True]


def test_whatever_is_no_markup_is_escaped() -> None:
    assert element("p", "<b>", raw("<i></i>"), None, 3, class_='a"b', data_x="1", hidden=True) == (
        '<p class="a&quot;b" data-x="1" hidden>&lt;b&gt;<i></i>3</p>'
    )
    assert element("img", src="a", alt=None) == '<img src="a">'
    assert escaped("a\x00b\x1b") == "a\ufffdb\ufffd"
    assert joined("&", raw("&amp;")) == "&amp;&amp;"
