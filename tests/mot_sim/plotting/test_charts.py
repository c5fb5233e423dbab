"""Charts as figures: by the file's ending, the same bytes every time, whatever the user's style."""

from pathlib import Path
from xml.etree import ElementTree

import cv2
import matplotlib as mpl
import pytest

from mot_sim.plotting.charts import (
    FIGURE_ENDINGS,
    Chart,
    Kind,
    Series,
    figure_of,
    require_figure,
    save_figure,
    svg_of,
)
from tracker.errors import BadConfig, BadOutput

LINE = Series("default", (0.0, 1, 2.5), (80.0, 70.0, 50.0), (79.0, None, 45.0), (81.0, None, 55.0))
BEGINNINGS = {".png": b"\x89PNG", ".svg": b"<?xml", ".pdf": b"%PDF"}


def chart(kind: Kind = "lines", series: tuple[Series, ...] = (LINE,)) -> Chart:
    """A chart of HOTA."""
    return Chart("hota", "HOTA over jitter", "jitter", "HOTA, %", series, kind, mark=60.0)


@pytest.mark.parametrize("ending", FIGURE_ENDINGS)
def test_the_ending_says_what_is_written_and_twice_the_same(tmp_path: Path, ending: str) -> None:
    first = save_figure(figure_of([[chart()]]), tmp_path / f"a{ending}").read_bytes()
    with mpl.rc_context({"font.size": 30.0, "lines.linewidth": 9.0}):
        again = save_figure(figure_of([[chart()]]), tmp_path / f"b{ending}").read_bytes()
    assert first.startswith(BEGINNINGS[ending])
    assert first == again
    assert sorted(path.name for path in tmp_path.iterdir()) == [f"a{ending}", f"b{ending}"]


@pytest.mark.parametrize("kind", ["lines", "points", "rows", "bars"])
def test_every_kind_is_drawn_in_the_colour_of_its_series(tmp_path: Path, kind: Kind) -> None:
    series = (
        LINE if kind in ("lines", "points")
        else Series("default", ("fog", "night", "fog 2"), LINE.y, LINE.low, LINE.high)
    )  # fmt: skip
    path = save_figure(figure_of([[chart(kind, (series,))]]), tmp_path / "a.png")
    image = cv2.imread(str(path)).astype(int)
    blue = abs(image - (0xB2, 0x72, 0x00)).max(axis=2) < 12
    assert blue.sum() > 200


def test_a_still_holds_its_words_as_text() -> None:
    root = ElementTree.fromstring(svg_of(chart()))
    words = {"".join(each.itertext()).strip() for each in root.iter() if each.tag.endswith("text")}
    assert {"HOTA over jitter", "jitter", "HOTA, %"} <= words
    assert len(svg_of(chart())) < 40_000


def test_one_legend_names_all_panels() -> None:
    other = Series("paper", (0.0, 1.0), (60.0, 50.0), place=1)
    figure = figure_of([[chart(series=(LINE, other)), chart()], [chart(series=(other,))]])
    (legend,) = figure.legends
    assert [text.get_text() for text in legend.get_texts()] == ["default", "paper"]
    assert [axes.get_visible() for axes in figure.axes] == [True, True, True, False]


def test_levels_far_apart_are_on_a_logarithmic_axis() -> None:
    far = Series("default", (0.01, 1.0), (60.0, 50.0))
    assert chart(series=(far,)).is_logarithmic
    assert not chart().is_logarithmic
    (axes,) = figure_of([[chart(series=(far,))]]).axes
    assert axes.get_xscale() == "log"


def test_a_series_without_any_value_is_drawn_as_nothing() -> None:
    empty = Series("default", (1.0,), (None,))
    assert list(empty.points()) == []
    assert svg_of(chart(series=(empty,))).startswith(b"<?xml")


def test_other_endings_and_places_are_refused(tmp_path: Path) -> None:
    with pytest.raises(BadConfig, match=r"ends in \.png, \.svg, \.pdf"):
        require_figure(tmp_path / "a.jpg")
    (tmp_path / "file").write_text("")
    with pytest.raises(BadOutput):
        require_figure(tmp_path / "file" / "a.png")
