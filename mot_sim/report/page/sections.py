"""The parts of the page: the summary on top, and a section a result."""

from base64 import b64encode
from collections.abc import Sequence

from mot_sim.plotting.charts import Panel, svg_of
from mot_sim.report.page.markup import Markup, element, joined
from mot_sim.report.page.sources import Medium, ResultSource
from mot_sim.report.page.tables import table_markup
from mot_sim.report.page.verdicts import verdicts_of

KIND_WORDS = {
    "sweep": "sweep", "stress": "stress test", "breaking-point": "breaking points",
    "compare": "comparison", "tables": "the paper's tables", "tune": "weights",
    "diagnosis": "diagnosis", "run": "run", "scenes": "scenes",
    "validate-sim": "simulation beside real drives",
}  # fmt: skip
ASIDE = ("design", "settings")  # tables that stand with how a result was made
DRAWN_ONLY = ("distributions",)  # tables of points, that nobody reads


def card_of(source: ResultSource, place: int) -> Markup:
    """A result in the summary: what it is, how complete, and what came of it."""
    result = source.result
    said = [
        element("li", each.text, class_=None if each.tone == "plain" else each.tone)
        for each in verdicts_of(result)
    ]
    title = element("a", result.title, href=f"#{anchor(place)}")
    return element(
        "article", element("h3", title), badges_of(source), element("ul", *said), class_="card"
    )


def badges_of(source: ResultSource) -> Markup:
    """The kind of the result, whether it is finished, and its folder."""
    made = source.result.made
    is_whole = made.finished and (made.trials is None or made.trials[0] >= made.trials[1])
    state = element(
        "span", "finished" if is_whole else "not finished",
        class_=f"badge {'good' if is_whole else 'bad'}",
    )  # fmt: skip
    if made.form_only:
        state = element("span", "form only, no result", class_="badge bad")
    kind = element("span", KIND_WORDS[source.result.kind], class_="badge")
    return element(
        "p", kind, state, element("span", str(source.folder), class_="badge"), class_="badges"
    )


def section_of(source: ResultSource, place: int, charts: Markup, media: Sequence[Medium]) -> Markup:
    """All of a result: charts, tables, clips and pictures, how it was made."""
    result = source.result
    tables = [table for table in result.tables if table.name not in ASIDE + DRAWN_ONLY]
    return element(
        "section",
        element("h2", result.title, id=f"{anchor(place)}-title"),
        badges_of(source),
        charts,
        element("h3", "Tables") if tables else None,
        joined(*(table_markup(table) for table in tables)),
        media_of(media),
        made_of(source),
        class_="result", id=anchor(place), aria_labelledby=f"{anchor(place)}-title",
    )  # fmt: skip


def charts_of(panels: Sequence[Panel], place: int) -> Markup:
    """The charts of a result; drawing them takes longer than all the rest of the page."""
    if not panels:
        return Markup("")
    charts = [panel_of(panel, f"{place}-{number}") for number, panel in enumerate(panels)]
    return joined(element("h3", "Charts"), element("div", *charts, class_="charts"))


def panel_of(panel: Panel, key: str) -> Markup:
    """A still picture of the first chart, which a script replaces by the chart itself."""
    _, first = panel.charts[0]
    image = b64encode(svg_of(first)).decode()
    still = element(
        "img", src=f"data:image/svg+xml;base64,{image}", alt=first.about, class_="still"
    )
    head = element("div", element("h4", panel.title), class_="panel-head")
    plot = element("div", class_="plot", role="img")
    return element("figure", head, still, plot, class_="panel", data_panel=key)


def media_of(media: Sequence[Medium]) -> Markup:
    """Clips that play, pictures, and what was left out with its reason."""
    clips = [each for each in media if each.uri is not None and each.is_clip]
    pictures = [each for each in media if each.uri is not None and not each.is_clip]
    left = [each for each in media if each.uri is None]
    shown_clips = [
        _figure(each, element(
            "video", src=each.uri, controls=True, loop=True, muted=True, playsinline=True,
            preload="metadata", aria_label=f"clip: {each.title}",
        ))
        for each in clips
    ]  # fmt: skip
    shown_pictures = [
        _figure(each, element("img", src=each.uri, alt=f"picture: {each.title}", loading="lazy"))
        for each in pictures
    ]
    notes = [
        element("li", element("code", str(each.path)), f" ({each.reason})") for each in left
    ]  # fmt: skip
    return joined(
        element("h3", "Clips") if clips else None,
        element("div", *shown_clips, class_="media") if clips else None,
        element("h3", "Pictures") if pictures else None,
        element("div", *shown_pictures, class_="media pictures") if pictures else None,
        element("h3", "Left out of this page") if left else None,
        element("ul", *notes) if left else None,
    )


def _figure(medium: Medium, shown: Markup) -> Markup:
    return element(
        "figure", shown,
        element("figcaption", medium.title, " ", element("code", medium.name)),
    )  # fmt: skip


def made_of(source: ResultSource) -> Markup:
    """The exact command, settings, versions and hashes."""
    made = source.result.made
    facts = [
        ("folder", str(source.folder)),
        ("hash of the code", made.code or "not kept"),
        ("sha256 of the file", source.sha256),
        ("versions", ", ".join(f"{name} {each}" for name, each in made.versions.items())),
    ]
    told = [part for name, text in facts for part in (element("dt", name), element("dd", text))]
    aside = [table_markup(table) for table in source.result.tables if table.name in ASIDE]
    command = element("pre", made.command) if made.command else None
    unknown = element("p", "The command was not kept.", class_="faint")
    return joined(
        element("h3", "How it was made"), command or unknown, joined(*aside), element("dl", *told)
    )


def anchor(place: int) -> str:
    """The name that a section is linked by."""
    return f"result-{place + 1}"
