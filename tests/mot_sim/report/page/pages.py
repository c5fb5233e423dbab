"""A page taken apart by the parser of the standard library: what a reader without scripts gets."""

from dataclasses import dataclass, field
from html.parser import HTMLParser

from mot_sim.report.page.markup import VOID


@dataclass
class Element:
    """An element with its attributes, its own text, and what is inside."""

    name: str
    attributes: dict[str, str]
    inside: "list[Element]" = field(default_factory=list)
    own: str = ""

    @property
    def text(self) -> str:
        """All text, that of inner elements too; scripts and styles have none."""
        if self.name in ("script", "style"):
            return ""
        return " ".join([self.own, *(each.text for each in self.inside)])

    def every(self, name: str, **wanted: str) -> "list[Element]":
        """The inner elements of a name, at any depth, with these attributes (`class_` a part)."""
        found = [each for inner in self.inside for each in inner.every(name, **wanted)]
        return ([self] if self._is(name, wanted) else []) + found

    def _is(self, name: str, wanted: dict[str, str]) -> bool:
        given = {key.rstrip("_"): value for key, value in wanted.items()}
        kinds = self.attributes.get("class", "").split()
        has_kind = given.pop("class", None) in (None, *kinds)
        same = all(self.attributes.get(key) == value for key, value in given.items())
        return self.name == name and has_kind and same


class Page(HTMLParser):
    """The tree of a page. Raises AssertionError for elements that are not closed in order."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.root = Element("", {})
        self.open = [self.root]
        self.feed(text)
        self.close()
        assert self.open == [self.root], [each.name for each in self.open]

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        names = [name for name, _ in attrs]
        assert len(set(names)) == len(names), names
        found = Element(tag, {name: value or "" for name, value in attrs})
        self.open[-1].inside.append(found)
        if tag not in VOID:
            self.open.append(found)

    def handle_endtag(self, tag: str) -> None:
        assert self.open[-1].name == tag, f"</{tag}> in <{self.open[-1].name}>"
        self.open.pop()

    def handle_data(self, data: str) -> None:
        self.open[-1].own += data
