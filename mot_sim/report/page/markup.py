"""HTML from elements: whatever is no markup yet is text, and is escaped."""

import html
import re

# Characters that HTML forbids; a user's title may contain them.
FORBIDDEN = re.compile("[\x00-\x08\x0b\x0c\x0e-\x1f\x7f-\x9f\ufdd0-\ufdef\ufffe\uffff]")
VOID = {"br", "hr", "img", "input", "link", "meta", "source"}

Child = object  # Markup, text, a number, or None for nothing
Attribute = str | float | int | bool | None


class Markup(str):
    """Text that is HTML already."""

    __slots__ = ()


def escaped(value: object) -> Markup:
    """A value as HTML; markup as it is, None as nothing."""
    if isinstance(value, Markup):
        return value
    if value is None:
        return Markup("")
    return Markup(html.escape(FORBIDDEN.sub("\ufffd", str(value)), quote=True))


def joined(*children: Child) -> Markup:
    """Elements and texts one after the other."""
    return Markup("".join(escaped(child) for child in children))


def element(name: str, /, *children: Child, **attributes: Attribute) -> Markup:
    """`<name attribute="value">children</name>`.

    Attributes: `class_` is class, `_` is a dash, True is an attribute without a value, None and
    False are left out.
    """
    spelled = "".join(
        f" {key.rstrip('_').replace('_', '-')}" + ("" if value is True else f'="{escaped(value)}"')
        for key, value in attributes.items()
        if value is not None and value is not False
    )
    if name in VOID:
        return Markup(f"<{name}{spelled}>")
    return Markup(f"<{name}{spelled}>{joined(*children)}</{name}>")


def raw(text: str) -> Markup:
    """Our own script or style, as it is."""
    return Markup(text)


__all__ = ["Child", "Markup", "element", "escaped", "joined", "raw"]
