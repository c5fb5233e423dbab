"""The page in headless Chromium: drawn, quiet, alone, legible in every light and width."""

from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import pytest

from mot_sim.experiments.result_file import Result, write_result
from mot_sim.plotting import write_video
from mot_sim.report.page import write_report
from tests.mot_sim.report.page.made import EVERY, EVIL, MADE, sweep_result

playwright = pytest.importorskip("playwright.sync_api", reason="playwright is not installed")
pytestmark = pytest.mark.browser

CHARTS = 12  # of a result of every kind
# Text and what is behind it, as far as both are plain colours: their ratio of contrast.
CONTRAST = """
() => {
  const rgb = (text) => (text.match(/[\\d.]+/g) ?? []).map(Number);
  const light = (colour) => {
    const [r, g, b] = colour.slice(0, 3).map((x) => x / 255)
      .map((x) => x <= 0.03928 ? x / 12.92 : ((x + 0.055) / 1.055) ** 2.4);
    return 0.2126 * r + 0.7152 * g + 0.0722 * b;
  };
  const behind = (element) => {
    for (let at = element; at; at = at.parentElement) {
      const colour = rgb(getComputedStyle(at).backgroundColor);
      if (colour.length === 3 || colour[3] > 0) return colour;
    }
    return [255, 255, 255];
  };
  const found = {};
  const kinds = "h1,h2,h3,h4,p,li,a,td,th,dt,dd,pre,span,figcaption";
  for (const each of document.querySelectorAll(kinds)) {
    if (!each.textContent.trim() || each.closest("svg")) continue;
    const [a, b] = [light(rgb(getComputedStyle(each).color)), light(behind(each))];
    const ratio = (Math.max(a, b) + 0.05) / (Math.min(a, b) + 0.05);
    const name = each.tagName + "." + each.className;
    found[name] = Math.min(found[name] ?? 99, ratio);
  }
  return found;
}
"""


@dataclass
class Watched:
    """A page and all that it said, or asked for, besides itself."""

    page: "playwright.Page"
    said: list[str] = field(default_factory=list)
    asked: list[str] = field(default_factory=list)

    def draw_all(self) -> None:
        """Scroll every chart into sight and wait until it is drawn."""
        for panel in self.page.locator("figure.panel").all():
            panel.scroll_into_view_if_needed()
            panel.locator(".js-plotly-plot .main-svg").first.wait_for(timeout=60_000)


@pytest.fixture(scope="module")
def visit(chromium) -> Iterator:
    """Opens a file in a browser without a network; gives the page, loaded."""
    contexts = []

    def open_file(path: Path, **options) -> Watched:
        context = chromium.new_context(offline=True, **options)
        contexts.append(context)
        watched = Watched(context.new_page())
        own = path.as_uri()

        def handle(route) -> None:
            url = route.request.url
            if url == own or url.startswith("data:"):
                route.continue_()
            else:
                watched.asked.append(url)
                route.abort()

        context.route("**/*", handle)
        watched.page.on("console", lambda message: watched.said.append(message.text))
        watched.page.on("pageerror", lambda error: watched.said.append(str(error)))
        watched.page.on("dialog", lambda dialog: watched.said.append(dialog.message))
        watched.page.goto(own)
        return watched

    yield open_file
    for context in contexts:
        context.close()


@pytest.fixture(scope="module")
def drawn(visit, every: Path) -> Watched:
    """That page with every chart drawn: the library starts slowly, so the tests share it."""
    watched = visit(every, color_scheme="light")
    watched.draw_all()
    return watched


def test_every_chart_is_drawn_without_a_word_or_a_request(drawn: Watched) -> None:
    page = drawn.page
    assert page.locator(".js-plotly-plot").count() == CHARTS
    for panel in page.locator("figure.panel").all():
        assert panel.locator(".js-plotly-plot .trace path").count() > 0
        assert not panel.locator("img.still").is_visible()
    assert drawn.said == []
    assert drawn.asked == []


def test_another_score_is_shown_over_every_axis_at_once(drawn: Watched) -> None:
    panels = drawn.page.locator("#result-1 figure.panel")
    titles = panels.locator(".ytitle")
    assert titles.all_text_contents() == ["HOTA, %", "HOTA, %"]
    panels.nth(0).locator("select").select_option(label="IDSW")
    playwright.expect(titles).to_have_text(["IDSW, mean of a run"] * 2)
    assert panels.nth(1).locator("select").input_value() == "1"
    assert drawn.said == []


def test_without_scripting_tables_and_still_charts_are_there(visit, every: Path) -> None:
    page = visit(every, java_script_enabled=False).page
    assert page.locator("table").count() == sum(len(result.tables) for result in EVERY)
    assert page.locator("select").count() == 0
    stills = page.locator("img.still")
    assert stills.count() == CHARTS
    for still in stills.all():
        box = still.bounding_box()
        assert box is not None
        assert box["height"] > 100


@pytest.mark.parametrize("width", [340, 390, 768, 1400])
def test_the_page_fits_every_width(drawn: Watched, width: int) -> None:
    drawn.page.set_viewport_size({"width": width, "height": 900})
    # charts follow a new width a moment later
    drawn.page.wait_for_function("w => document.documentElement.scrollWidth <= w", arg=width)


@pytest.mark.parametrize("light", ["light", "dark"])
def test_text_stands_out_from_the_paper(drawn: Watched, light: str) -> None:
    drawn.page.emulate_media(color_scheme=light)
    paper = drawn.page.evaluate("getComputedStyle(document.body).backgroundColor")
    assert paper == {"light": "rgb(255, 255, 255)", "dark": "rgb(20, 23, 26)"}[light]
    ratios = drawn.page.evaluate(CONTRAST)
    assert len(ratios) > 10
    assert {name: ratio for name, ratio in ratios.items() if ratio < 4.5} == {}


def test_charts_follow_the_light(drawn: Watched) -> None:
    tick = drawn.page.locator(".js-plotly-plot .xtick text").first
    for light, colour in (("dark", "rgb(230, 232, 234)"), ("light", "rgb(26, 29, 33)")):
        drawn.page.emulate_media(color_scheme=light)
        playwright.expect(tick).to_have_css("fill", colour)


def test_on_paper_the_still_charts_are_printed(drawn: Watched) -> None:
    drawn.page.emulate_media(media="print")
    assert drawn.page.locator("img.still").first.is_visible()
    assert not drawn.page.locator(".plot").first.is_visible()
    drawn.page.emulate_media(media="screen")


def test_markup_in_results_stays_text(visit, tmp_path: Path) -> None:
    evil = EVIL + "<img src=x onerror=alert(1)><a href='javascript:alert(2)'>b</a>"
    write_result(tmp_path / "evil", sweep_result(evil))
    watched = visit(write_report([tmp_path], tmp_path / "r.html", title=evil).path)
    watched.draw_all()
    plot = watched.page.locator(".js-plotly-plot").first
    assert "<script>alert('x')</script>" in (plot.text_content() or "")
    assert watched.page.locator("img[src=x], a[href^=javascript]").count() == 0
    assert watched.said == []
    assert watched.asked == []


def test_a_clip_plays_inside_the_page(visit, tmp_path: Path) -> None:
    grey = np.linspace(0, 255, 64, dtype=np.uint8)
    rows = [np.roll(grey, 4 * k)[None, :, None] for k in range(20)]
    frames = [np.full((48, 64, 3), row, np.uint8) for row in rows]
    folder = tmp_path / "clips"
    write_result(folder, Result("run", "a run", MADE, (), ("moment.mp4",)))
    write_video(folder / "moment.mp4", frames, 10.0)
    report = write_report([folder], tmp_path / "r.html")
    assert report.left_out == ()
    watched = visit(report.path)
    clip = watched.page.locator("video")
    clip.evaluate(
        """video => new Promise((done) => {
          video.ontimeupdate = () => { if (video.currentTime > 0.2) done(); };
          video.play();
        })"""
    )
    size = clip.evaluate("video => [video.videoWidth, video.videoHeight, video.duration]")
    assert size == pytest.approx([64, 48, 2.0], abs=0.15)
    assert watched.said == []
    assert watched.asked == []
