"""The docstrings of fields, as a program reads them."""

from dataclasses import dataclass
from fractions import Fraction
from typing import NamedTuple

import pytest

from mot_sim.files.field_docstrings import field_docstring_in, field_docstrings


@dataclass(frozen=True)
class Bottle:
    """A vessel. Its docstring is no field's."""

    volume: float
    """Litres, > 0;
    of water."""
    label: str = ""

    cork: bool = True
    """Whether it has one."""

    def drink(self) -> float:
        """No field's either."""
        return self.volume


class Magnum(Bottle):
    """A larger one."""

    label: str = "brut"
    """Over the base's."""
    cork: bool = False


class Crate(NamedTuple):
    """Of bottles."""

    count: int
    """How many."""

    class Slot(NamedTuple):
        """Of one bottle."""

        row: int
        """From the front."""


def test_the_string_under_a_field_is_its_docstring_on_one_line() -> None:
    assert field_docstrings(Bottle) == {
        "volume": "Litres, > 0; of water.",
        "cork": "Whether it has one.",
    }


def test_a_class_has_the_docstrings_of_its_bases_and_its_own_over_them() -> None:
    assert field_docstrings(Magnum) == {**field_docstrings(Bottle), "label": "Over the base's."}


def test_named_tuples_and_inner_classes_have_theirs() -> None:
    assert field_docstrings(Crate) == {"count": "How many."}
    assert field_docstrings(Crate.Slot) == {"row": "From the front."}


def test_what_has_no_source_has_no_docstrings() -> None:
    names: dict[str, type] = {}
    exec("class Typed:\n    x: int\n    'By hand.'\n", {"__name__": "nowhere"}, names)
    assert field_docstrings(names["Typed"]) == {}
    assert field_docstrings(int) == {}
    assert field_docstrings(Fraction) == {}


def test_a_field_of_a_module_is_read_without_importing_it() -> None:
    text = field_docstring_in("mot_sim.experiments.sweep.design", "Design", "first_seed")
    assert text == "First seed; the runs use consecutive seeds."
    with pytest.raises(KeyError, match="second_seed"):
        field_docstring_in("mot_sim.experiments.sweep.design", "Design", "second_seed")
