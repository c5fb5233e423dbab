"""What scenes say in their source is what they say when they are imported."""

from inspect import getdoc
from pathlib import Path

import pytest

from mot_sim.simulation.registry import COMMON_KNOBS, SCENES, knobs_of, scene_maker
from mot_sim.simulation.scene_descriptions import SceneDescription
from tests.mot_sim.own_things import write_package
from tests.mot_sim.test_imports import COMPUTING, modules_after
from tracker.errors import BadConfig, UnknownName

MODULE = '''
SPEED = 3.0

def plain(frames=10, /, *given, speed=-1.5, fast: bool = True, mode="x", cars=SPEED, **more):
    return None

class Roads:
    @staticmethod
    def wide(*, frames: int = 7):
        """  A wide road.

        frames: how many."""

def bare(): ...
other = plain
'''


@pytest.fixture
def place(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder of Python's path with a module in it, and one whose text is no Python."""
    (tmp_path / "read_only.py").write_text(MODULE)
    (tmp_path / "no_python.py").write_text("def f(:\n")
    monkeypatch.syspath_prepend(str(tmp_path))
    return tmp_path


@pytest.mark.parametrize("name", sorted(SCENES))
def test_the_source_of_a_scene_says_what_its_function_says(name: str) -> None:
    source = SceneDescription.of(name)
    assert source.about == (getdoc(scene_maker(name)) or "").partition("\n")[0]
    assert source.about.endswith(".")
    own = {knob: value for knob, value in knobs_of(name).items() if knob not in COMMON_KNOBS}
    assert source.knobs == own


def test_defaults_are_read_as_they_are_written(place: Path) -> None:
    found = SceneDescription.of("read_only:plain")
    assert found.about == ""
    assert found.knobs == {
        "frames": 10, "speed": "-1.5", "fast": True, "mode": "x", "cars": "SPEED"
    }  # fmt: skip
    wide = SceneDescription.of("read_only:Roads.wide")
    assert wide == SceneDescription("A wide road.", {"frames": 7})
    assert SceneDescription.of("read_only:bare") == SceneDescription("", {})


@pytest.mark.parametrize(
    ("name", "told"),
    [
        ("read_only:other", r"scene 'read_only:other': no function other is defined in .*only.py"),
        ("read_only:Roads.narrow", "no function Roads.narrow"),
        ("no_python:f", "no_python.py cannot be read: invalid syntax"),
        ("not_there:f", "No module named 'not_there'"),
        ("not_there.inside:f", "ModuleNotFoundError: No module named 'not_there'"),
        ("sys:f", "sys"),
    ],
)
def test_what_has_no_source_is_named(place: Path, name: str, told: str) -> None:
    with pytest.raises(BadConfig, match=told):
        SceneDescription.of(name)


def test_a_name_that_is_no_scene_gets_a_hint() -> None:
    with pytest.raises(UnknownName, match="Did you mean 'gauntlet'"):
        SceneDescription.of("gauntlt")


def test_scenes_of_installed_packages_are_read_too(
    place: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    write_package(place / "site", "theirs", {"mot_sim.scenes": {"wide": "read_only:Roads.wide"}})
    monkeypatch.syspath_prepend(str(place / "site"))
    assert SceneDescription.of("wide").knobs == {"frames": 7}


def test_the_list_makes_no_scene() -> None:
    loaded = modules_after("from mot_sim.__main__ import main\nassert main(['scenes']) == 0")
    assert loaded.isdisjoint(set(COMPUTING) - {"numpy", "jaxtyping"})
