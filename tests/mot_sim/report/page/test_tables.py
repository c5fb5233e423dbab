"""Tables of the page, and the markup that they are made of."""

from mot_sim.report.page.markup import element, escaped, joined, raw
from mot_sim.report.page.tables import heading, shown_columns
from mot_sim.tables import Table


def test_the_ends_of_an_interval_stand_with_its_value_and_empty_columns_nowhere() -> None:
    table = Table.of(
        "t", "", ("suite", "HOTA", "HOTA low", "HOTA high", "CLR_FP", "error", "low"),
        (("a", 0.5, 0.4, 0.6, 3, None, 1.0),),
    )  # fmt: skip
    shown = shown_columns(table)
    assert [heading(each) for each in shown] == ["suite", "HOTA, %", "FP", "low"]
    assert [each.low and table.names[each.low] for each in shown] == [None, "HOTA low", None, None]
    assert [each.is_number for each in shown] == [False, True, True, True]


def test_whatever_is_no_markup_is_escaped() -> None:
    assert element("p", "<b>", raw("<i></i>"), None, 3, class_='a"b', data_x="1", hidden=True) == (
        '<p class="a&quot;b" data-x="1" hidden>&lt;b&gt;<i></i>3</p>'
    )
    assert element("img", src="a", alt=None) == '<img src="a">'
    assert escaped("a\x00b\x1b") == "a\ufffdb\ufffd"
    assert joined("&", raw("&amp;")) == "&amp;&amp;"
