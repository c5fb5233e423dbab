"""The report: one HTML file that contains everything it shows, and loads nothing."""

import json
from base64 import b64encode
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from hashlib import sha256
from importlib import resources
from importlib.metadata import version
from pathlib import Path

from mot_sim.files.settings import holds_something
from mot_sim.files.writing import require_writable, write_bytes
from mot_sim.plotting.charts import FIGURE_ENDINGS, Panel, figure_of, save_figure
from mot_sim.report.page.markup import Markup, element, joined, raw
from mot_sim.report.page.panels import panels_of
from mot_sim.report.page.plots import plot_of
from mot_sim.report.page.sections import anchor, card_of, charts_of, section_of
from mot_sim.report.page.sources import Medium, ResultSource, find_sources, load_media
from tracker.errors import BadConfig, OutputExists

MAX_PAGE_BYTES = 10_000_000  # clips and pictures that would exceed it are left out
PAGE_ENDINGS = (".html", ".htm")
MAX_CHARTS = 12  # of one result; the tables have the rest
DEFAULT_TITLE = "mot-sim report"


@dataclass(frozen=True)
class WrittenReport:
    """A report that was written."""

    path: Path
    """The HTML file."""
    size: int
    """Size of the file, bytes."""
    sources: tuple[ResultSource, ...]
    """The results that it shows."""
    left_out: tuple[Path, ...]
    """Files of the results that it does not hold."""
    figures: tuple[Path, ...] = ()
    """Files of the charts that were written besides."""


def write_report(
    folders: Sequence[Path],
    out: Path,
    *,
    title: str = DEFAULT_TITLE,
    figures: Path | None = None,
    overwrite: bool = False,
) -> WrittenReport:
    """Write the report on some folders to an HTML file.

    figures: a folder that gets every chart as PNG, SVG and PDF too. Raises BadConfig, BadFile for
    folders that hold nothing of ours or what is damaged, OutputExists, BadOutput.
    """
    if out.suffix.lower() not in PAGE_ENDINGS:
        raise BadConfig(f"--out {out}: give a file that ends in .html")
    require_writable(out)
    if out.exists() and not overwrite:
        raise OutputExists(f"{out}: is there already; --overwrite replaces it")
    if figures is not None and not overwrite and holds_something(figures):
        raise OutputExists(f"{figures}: not empty; choose another folder, or --overwrite")
    sources = find_sources(folders)
    panels = [panels_of(source.result)[:MAX_CHARTS] for source in sources]
    text, left_out = page_of(sources, panels, title)
    content = text.encode()
    write_bytes(out, content)
    drawn = () if figures is None else tuple(write_figures(figures, sources, panels))
    return WrittenReport(out, len(content), tuple(sources), left_out, drawn)


def page_of(
    sources: Sequence[ResultSource], panels: Sequence[Sequence[Panel]], title: str
) -> tuple[str, tuple[Path, ...]]:
    """The page, and the files that are left out of it. panels: of every source."""
    charts = [charts_of(held, place) for place, held in enumerate(panels)]
    bare = _whole(sources, panels, charts, title, {})
    media = load_media(sources, MAX_PAGE_BYTES - len(bare.encode()) - _captions(sources))
    left_out = tuple(each.path for held in media.values() for each in held if each.uri is None)
    return _whole(sources, panels, charts, title, media), left_out


def _captions(sources: Sequence[ResultSource]) -> int:
    """Room for what stands around clips and pictures, with some to spare."""
    names = [(name, source.folder) for source in sources for name in source.result.files]
    return sum(600 + 4 * len(name) + 2 * len(str(folder)) for name, folder in names)


def _whole(
    sources: Sequence[ResultSource],
    panels: Sequence[Sequence[Panel]],
    charts: Sequence[Markup],
    title: str,
    media: Mapping[int, Sequence[Medium]],
) -> str:
    """The page with these files in it."""
    parts = [
        section_of(source, place, charts[place], media.get(place, ()))
        for place, source in enumerate(sources)
    ]
    body = element(
        "body",
        element("a", "Skip to the results", href="#results", class_="skip"),
        element(
            "div",
            _top(sources, title),
            element("main", *parts, id="results"),
            _foot(),
            class_="wrap",
        ),
        _scripts(panels) if any(panels) else None,
    )
    return f"<!doctype html>\n{element('html', _head(title), body, lang='en')}\n"


def _head(title: str) -> Markup:
    """Title, style, and the policy that lets nothing in from outside."""
    policy = (
        "default-src 'none'; img-src data: blob:; media-src data:; style-src 'unsafe-inline'; "
        f"script-src {' '.join(_hash(script) for script in _code())}; base-uri 'none'; "
        "form-action 'none'"
    )
    return element(
        "head",
        element("meta", charset="utf-8"),
        element("meta", http_equiv="Content-Security-Policy", content=policy),
        element("meta", name="viewport", content="width=device-width, initial-scale=1"),
        element("meta", name="generator", content=f"mot-sim {version('mot-sim')}"),
        element("title", title),
        element("link", rel="icon", href="data:,"),
        element("style", raw(_own("page.css"))),
    )


def _top(sources: Sequence[ResultSource], title: str) -> Markup:
    """The title, and a card a result."""
    count = f"{len(sources)} result{'s' * (len(sources) != 1)}"
    cards = [card_of(source, place) for place, source in enumerate(sources)]
    told = f"{count}. Rates in percent; ± and [ ] are 95 % intervals."
    return element(
        "header",
        element("h1", title),
        element("p", told, class_="faint"),
        element("h2", "Summary", id="summary"),
        element("nav", *cards, class_="cards", aria_label="Summary of the results"),
        class_="top",
    )


def _foot() -> Markup:
    """What the page is."""
    return element(
        "footer",
        element(
            "p",
            f"Written by mot-sim {version('mot-sim')}. The page holds all that it shows: it asks "
            "no network, and its tables need no scripting.",
        ),
    )


def _scripts(panels: Sequence[Sequence[Panel]]) -> Markup:
    """The charts in plain values, the library, and what draws them."""
    plots = {
        f"{place}-{number}": [
            {"label": label, "about": chart.about, "plot": plot_of(chart)}
            for label, chart in panel.charts
        ]
        for place, held in enumerate(panels)
        for number, panel in enumerate(held)
    }
    library, own = _code()
    # No text of a result may end the element that holds it.
    content = json.dumps(plots, separators=(",", ":"), allow_nan=False).replace("<", "\\u003c")
    return joined(
        element("script", raw(content), type="application/json", id="plots"),
        element("script", raw(library), type="text/plain", id="library"),
        element("script", raw(own)),
    )


def _code() -> tuple[str, str]:
    """The library of the charts, and the page's own script."""
    library = resources.files("plotly") / "package_data" / "plotly.min.js"
    return library.read_text(encoding="utf-8"), _own("page.js")


def _own(name: str) -> str:
    """A file beside this one."""
    return (resources.files("mot_sim.report.page") / name).read_text(encoding="utf-8")


def _hash(script: str) -> str:
    """How the policy names a script that may run."""
    return f"'sha256-{b64encode(sha256(script.encode()).digest()).decode()}'"


def write_figures(
    folder: Path, sources: Sequence[ResultSource], panels: Sequence[Sequence[Panel]]
) -> list[Path]:
    """Every chart of every panel as PNG, SVG and PDF; gives the paths. Raises BadOutput."""
    written = []
    for place, (source, held) in enumerate(zip(sources, panels, strict=True)):
        for number, panel in enumerate(held, 1):
            for _, chart in panel.charts:
                figure = figure_of([[chart]])
                plain = "".join(letter if letter.isalnum() else "-" for letter in chart.name)
                name = f"{anchor(place)}-{source.result.kind}-{number}-{plain[:80]}"
                written += [
                    save_figure(figure, folder / f"{name}{ending}") for ending in FIGURE_ENDINGS
                ]
    return written


__all__ = ["MAX_PAGE_BYTES", "WrittenReport", "write_report"]
