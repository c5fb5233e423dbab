"""The page without a browser: what it holds, what it does not, and what is refused."""

import json
from collections import Counter
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import plotly.graph_objects as go
import pytest

from mot_sim.experiments.result_file import RESULT_KINDS, Made, Result, write_result
from mot_sim.report.page import page as page_module
from mot_sim.report.page import write_report
from mot_sim.report.page.sections import KIND_WORDS, badges_of
from mot_sim.report.page.sources import ResultSource
from mot_sim.report.page.verdicts import verdicts_of
from mot_sim.tables import Table
from tests.mot_sim.report.page.made import (
    EVERY,
    EVIL,
    MADE,
    stress_result,
    sweep_result,
)
from tests.mot_sim.report.page.pages import Page
from tracker.errors import BadConfig, BadOutput, OutputExists


@pytest.fixture(scope="module")
def every_text(every: Path) -> str:
    """The page of a result of every kind, as text."""
    return every.read_text()


@pytest.fixture
def one(tmp_path: Path) -> Path:
    """A folder with a stress test."""
    write_result(tmp_path / "stress", stress_result())
    return tmp_path / "stress"


def plots(text: str) -> dict[str, list]:
    """The charts that the page's script draws."""
    (script,) = Page(text).root.every("script", id="plots")
    return json.loads(script.own)


def test_every_kind_of_result_has_words_and_a_section(every_text: str) -> None:
    assert set(KIND_WORDS) == set(RESULT_KINDS)
    page = Page(every_text).root
    sections = page.every("section", class_="result")
    assert [section.every("h2")[0].text.strip() for section in sections] == [
        result.title for result in EVERY
    ]
    targets = {each.attributes["href"][1:] for each in page.every("article")[0].every("a")}
    assert targets == {"result-1"}
    assert {each.attributes["id"] for each in sections} == {f"result-{k + 1}" for k in range(7)}


def test_a_stress_test_that_only_measured_keeps_and_breaks_no_bound() -> None:
    asked = stress_result()
    table, _ = asked.tables
    at = table.names.index("verdict")
    rows = tuple((*row[:at], None, *row[at + 1 :]) for row in table.rows)
    said = [each.text for each in verdicts_of(replace(asked, tables=(replace(table, rows=rows),)))]
    assert "Measured only: no bounds were asked for." in said
    assert not any("bounds are kept" in text or "must be" in text for text in said)


def test_tables_that_only_show_their_form_say_nothing_else(tmp_path: Path) -> None:
    found = next(result for result in EVERY if result.kind == "tables")
    shown = replace(found, made=replace(found.made, form_only=True))
    (said,) = verdicts_of(shown)
    assert said.text == "It shows the form of the tables; what was measured is no result."
    source = ResultSource(tmp_path, shown, sha256="")
    badge = "".join(badges_of(source))
    assert "form only, no result" in badge
    assert "finished" not in badge


def test_the_summary_says_what_came_of_each(every_text: str) -> None:
    cards = [" ".join(card.text.split()) for card in Page(every_text).root.every("article")]
    assert "default: HOTA from 50.00 ±2.00 at max_gap=3 to 90.00 ±2.00 at jitter=0." in cards[0]
    assert "Differences to the first: paper is below at 5 and above at 0 of 5 points" in cards[0]
    assert "default: 2 trials failed." in cards[0]
    assert "2 of 3 bounds are kept." in cards[1]
    assert "fog, default: IDSW is 2.4 ±1.0, must be at most 1.8." in cards[1]
    assert "1 of 2 scores are as good as the baseline." in cards[1]
    assert "fog, default: IDSW is 2.4 ±1.0, the baseline 1.20 ±0.80." in cards[1]
    assert "default: 2.3 [2.1, 2.7]. paper: none up to 4." in cards[2]
    assert "By HOTA: default 88.00, iou 70.00. mine failed: exit code 3" in cards[3]
    assert "most MOTA: * the paper 91.40" in cards[4]
    assert "Weights: volume 0.6, reprojection 0.4. HOTA by the mean weights: 91.00." in cards[5]
    assert "(switches): occlusion 7, crossing 3. What they hang on (share, %): misses" in cards[6]


def test_tables_need_no_script(every_text: str) -> None:
    page = Page(every_text).root
    tables = page.every("table")
    assert len(tables) == sum(len(result.tables) for result in EVERY)
    for table in tables:
        assert table.every("caption")[0].text.strip()
        assert {each.attributes["scope"] for each in table.every("th")} <= {"col", "row"}
        width = len(table.every("thead")[0].every("th"))
        for row in table.every("tbody")[0].every("tr"):
            assert len(row.inside) == width
    means = tables[0]
    heads = [each.text.strip() for each in means.every("thead")[0].every("th")]
    assert heads[2:5] == ["tracker", "HOTA, %", "IDSW"]
    first = [" ".join(cell.text.split()) for cell in means.every("tbody")[0].every("tr")[0].inside]
    assert first == ["0", "", "default", "90.00 ±2.00", "2.00 ±0.50", "4", "0"]
    verdicts = [cell.text for cell in page.every("td", class_="bad")]
    assert [word.strip() for word in verdicts] == ["FAIL"]


def test_every_chart_has_a_still_picture_with_its_values_in_words(every_text: str) -> None:
    page = Page(every_text).root
    panels = page.every("figure", class_="panel")
    assert len(panels) == len(plots(every_text)) == 12
    for panel in panels:
        (still,) = panel.every("img", class_="still")
        assert still.attributes["src"].startswith("data:image/svg+xml;base64,")
        assert len(still.attributes["alt"]) > 20
        assert panel.attributes["data-panel"] in plots(every_text)


def test_headings_leave_no_level_out_and_ids_are_unique(every_text: str) -> None:
    page = Page(every_text).root
    levels = []

    def walk(element) -> None:
        if element.name in {"h1", "h2", "h3", "h4"}:
            levels.append(int(element.name[1]))
        for each in element.inside:
            walk(each)

    walk(page)
    assert levels[0] == 1
    assert levels.count(1) == 1
    assert all(below <= above + 1 for above, below in pairwise(levels))

    def ids(element) -> list[str]:
        own = [element.attributes["id"]] if "id" in element.attributes else []
        return own + [each for inner in element.inside for each in ids(inner)]

    assert max(Counter(ids(page)).values()) == 1
    assert page.every("html")[0].attributes["lang"] == "en"
    assert page.every("title")[0].own == "mot-sim report"


def test_nothing_is_asked_of_anybody(every_text: str) -> None:
    page = Page(every_text).root
    for name, key in (("script", "src"), ("link", "href"), ("img", "src"), ("video", "src")):
        for each in page.every(name):
            assert each.attributes.get(key, "data:").startswith("data:")
    (policy,) = [
        each.attributes["content"]
        for each in page.every("meta")
        if each.attributes.get("http-equiv") == "Content-Security-Policy"
    ]
    assert policy.startswith("default-src 'none'")
    assert "unsafe-inline" not in policy.partition("script-src")[2]
    assert "http" not in policy
    (style,) = page.every("style")
    assert "url(" not in style.own
    assert "@import" not in style.own


def test_plotly_takes_every_chart_as_it_is(every_text: str) -> None:
    for charts in plots(every_text).values():
        for chart in charts:
            figure = go.Figure(chart["plot"])  # raises for what Plotly does not know
            assert len(figure.data) >= 1
            assert chart["about"]


def test_how_it_was_made_stands_there_exactly(every_text: str, tmp_path: Path) -> None:
    section = Page(every_text).root.every("section", id="result-1")[0]
    assert section.every("pre")[0].own == "mot-sim sweep --axis 'a b'"
    facts = " ".join(section.every("dl")[0].text.split())
    assert "hash of the code " + MADE.code in facts
    assert "python 3.11.9, numpy 2.1" in facts


def test_text_of_results_is_text_wherever_it_stands(tmp_path: Path) -> None:
    plain = MADE.command
    made = replace(MADE, command=f"mot-sim {EVIL}", code=EVIL, versions={EVIL: EVIL})
    result = sweep_result(EVIL, made, (f"{EVIL}.png".replace("/", "-"),))
    table = Table.of(EVIL, EVIL, (EVIL, "b"), ((EVIL, 1), (EVIL + "2", 2)), EVIL)
    write_result(tmp_path / "a<b>", replace(result, tables=(*result.tables, table)))
    report = write_report([tmp_path / "a<b>"], tmp_path / "r.html", title=EVIL)
    text = report.path.read_text()
    page = Page(text).root
    assert len(page.every("script")) == 3
    (data,) = page.every("script", id="plots")
    assert "<" not in data.own
    assert "alert" in data.own
    assert page.every("title")[0].own == EVIL
    assert page.every("pre")[0].own == f"mot-sim {EVIL}"
    assert plain not in text
    assert any(cell.own == EVIL for cell in page.every("th", scope="row"))
    assert "<script>alert" not in text.replace("\\u003cscript", "")


def test_a_result_without_anything_is_a_page(tmp_path: Path) -> None:
    empty = Table.of("means", "", ("axis", "tracker", "HOTA", "HOTA low", "HOTA high"), ())
    for kind in RESULT_KINDS:
        nothing = Result(kind, "", Made("", {}, "", False, (0, 400)), (empty,))
        write_result(tmp_path / kind, nothing)
    report = write_report([tmp_path], tmp_path / "r.html")
    page = Page(report.path.read_text()).root
    assert len(page.every("section", class_="result")) == len(RESULT_KINDS)
    assert "0 of 400 trials are finished; there is nothing to show yet." in page.text
    assert not page.every("script")  # no charts: the library is left out
    assert report.size < 60_000


def test_a_long_table_is_cut_with_a_word_about_it(tmp_path: Path) -> None:
    table = Table.of("cases", "Cases", ("car", "frame"), tuple((k, k) for k in range(1000)))
    write_result(tmp_path, Result("diagnosis", "long", MADE, (table,)))
    page = Page(write_report([tmp_path], tmp_path / "r.html").path.read_text()).root
    assert len(page.every("tbody")[0].every("tr")) == 400
    assert "400 of 1,000 rows; all stand in result.json." in page.every("caption")[0].text


def test_the_same_results_give_the_same_page(one: Path, tmp_path: Path) -> None:
    first = write_report([one], tmp_path / "a.html").path.read_bytes()
    assert write_report([one], tmp_path / "b.html").path.read_bytes() == first


def test_figures_are_written_for_papers(one: Path, tmp_path: Path) -> None:
    report = write_report([one], tmp_path / "r.html", figures=tmp_path / "figures")
    names = sorted(path.name for path in (tmp_path / "figures").iterdir())
    assert names == [
        f"result-1-stress-{panel}-{metric}.{ending}"
        for panel in ("1-stress", "2-baseline")
        for metric in ("HOTA", "IDSW")
        for ending in ("pdf", "png", "svg")
    ]
    assert len(report.figures) == 12
    with pytest.raises(OutputExists, match="not empty"):
        write_report([one], tmp_path / "s.html", figures=tmp_path / "figures")


def test_what_is_there_stays_unless_it_may_go(one: Path, tmp_path: Path) -> None:
    out = tmp_path / "r.html"
    out.write_text("mine")
    with pytest.raises(OutputExists, match="--overwrite"):
        write_report([one], out)
    assert out.read_text() == "mine"
    write_report([one], out, overwrite=True)
    assert out.read_text().startswith("<!doctype html>")


def test_places_that_cannot_be_written_are_refused(one: Path, tmp_path: Path) -> None:
    with pytest.raises(BadConfig, match=r"ends in \.html"):
        write_report([one], tmp_path / "report.pdf")
    (tmp_path / "folder.html").mkdir()
    with pytest.raises(BadOutput, match="Is a directory"):
        write_report([one], tmp_path / "folder.html")
    (tmp_path / "file").write_text("")
    with pytest.raises(BadOutput):
        write_report([one], tmp_path / "file" / "r.html")


def test_a_page_that_would_be_too_large_leaves_files_out(
    one: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    names = ("a.png", "b.png", "c.mp4")
    write_result(one, replace(stress_result(), files=names))
    for name, size in zip(names, (30_000, 3_000_000, 60_000), strict=True):
        (one / name).write_bytes(b"avc1" * (size // 4))
    bare = 5_300_000
    monkeypatch.setattr(page_module, "MAX_PAGE_BYTES", bare + 300_000)
    report = write_report([one], tmp_path / "r.html")
    assert report.size <= bare + 300_000
    assert report.left_out == (one / "b.png",)
    page = Page(report.path.read_text()).root
    assert "3.0 MB: the page would be too large" in page.text
    assert len(page.every("video")) == 1
    assert page.every("video")[0].attributes["src"].startswith("data:video/mp4;base64,YXZj")
    (picture,) = [each for each in page.every("img") if each.attributes.get("loading") == "lazy"]
    assert picture.attributes["alt"] == "picture: a"
