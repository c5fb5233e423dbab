"""Shows the fields of a class as a table in its place, made of the docstrings under them."""

from typing import Any

import griffe

HEAD = ("| field | type | what it is |", "| --- | --- | --- |")


class FieldTables(griffe.Extension):
    """Moves the docstrings of fields into a table below that of their class."""

    def on_class_members(self, *, cls: griffe.Class, **_: Any) -> None:
        """Write the table of a class whose members are known; properties stay as they are."""
        fields = [
            each
            for each in cls.attributes.values()
            if each.docstring is not None
            and not each.name.startswith("_")
            and "property" not in each.labels
        ]
        if not fields or cls.docstring is None:
            return
        rows = [f"| {cells(each)} |" for each in fields]
        cls.docstring.value += "\n\n" + "\n".join((*HEAD, *rows))
        for each in fields:  # what has no docstring is not listed again
            each.docstring = None


def cells(field: griffe.Attribute) -> str:
    """Name, type and text of a field, as a row of a Markdown table holds them."""
    said = " ".join(field.docstring.value.split()) if field.docstring is not None else ""
    kind = "" if field.annotation is None else f"`{field.annotation}`"
    return f"`{field.name}` | {kind} | {said.replace('|', chr(92) + '|')}"
