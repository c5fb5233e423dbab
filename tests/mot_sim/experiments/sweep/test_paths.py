"""Values inside nested dataclasses by dotted names."""

from dataclasses import dataclass

import pytest

from mot_sim.experiments.sweep.paths import fitting, parse_level, scalars, unknown, with_value
from tracker.errors import BadConfig


@dataclass(frozen=True)
class Inner:
    x: float = 1.0
    table: tuple[float, ...] = (2.0, 3.0)


@dataclass(frozen=True)
class Outer:
    inner: Inner = Inner()
    on: bool = True
    absent: Inner | None = None


def test_every_value_inside_has_a_dotted_name() -> None:
    found = scalars(Outer())
    assert found == {"inner.x": 1.0, "inner.table.0": 2.0, "inner.table.1": 3.0, "on": True}
    assert scalars({"a": 1, "b": Outer()})["b.inner.x"] == 1.0


@pytest.mark.parametrize("path", ["inner.x", "inner.table.1", "on"])
def test_a_changed_value_is_the_only_change(path: str) -> None:
    before = Outer()
    after = scalars(with_value(before, path, 9.0))
    assert after == {**scalars(before), path: 9.0}
    assert scalars(before) == scalars(Outer())


@pytest.mark.parametrize(
    ("value", "like", "fits"), [(1, 2.5, 1.0), (2.0, 7, 2), (True, False, True), ("a", "b", "a")]
)
def test_a_level_takes_the_type_of_what_it_replaces(value: object, like: object, fits: object):
    got = fitting(value, like, "axis")
    assert got == fits
    assert type(got) is type(fits)


@pytest.mark.parametrize(
    ("value", "like"),
    [("a", 1.0), (1.5, 2), (True, 1.0), (1, True), (1.0, "b"), (float("nan"), 1.0)],
)
def test_a_level_of_another_type_is_refused(value: object, like: object) -> None:
    with pytest.raises(BadConfig, match="axis = "):
        fitting(value, like, "axis")


def test_words_of_the_command_line_become_levels() -> None:
    words = ["3", "0.5", "1e-3", "true", "False", "rrc"]
    assert [parse_level(word) for word in words] == [3, 0.5, 0.001, True, False, "rrc"]


def test_an_unknown_name_is_answered_with_its_neighbours_and_the_nearest() -> None:
    known = {"scene.cars": 1, "scene.vans": 2, "rig.height": 3}
    assert str(unknown("axis", "scene.carz", known)) == (
        "unknown axis 'scene.carz'; known: scene.cars, scene.vans. Did you mean 'scene.cars'?"
    )
    assert "Did you mean 'rig.height'?" in str(unknown("axis", "height", known))
    assert "known: rig.*, scene.*" in str(unknown("axis", "zzz", known))
