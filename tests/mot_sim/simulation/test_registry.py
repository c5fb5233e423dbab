"""Scenes are found by name, and made with their knobs."""

import pytest

from mot_sim.simulation.registry import (
    COMMON_KNOBS,
    SCENES,
    find_scene,
    knob_descriptions,
    knobs_of,
    scene_about,
)
from mot_sim.simulation.scene import Scene, record_scene_traffic
from tracker.errors import BadConfig, UnknownName


@pytest.mark.parametrize("name", sorted(SCENES))
def test_every_registered_scene_is_there_under_its_own_name(name) -> None:
    scene = find_scene(name)
    assert isinstance(scene, Scene)
    assert scene.name == name
    assert scene.knobs == knobs_of(name)
    assert "frames" in scene.knobs
    assert scene.frame_count == scene.knobs["frames"]


def test_a_typo_gets_a_hint() -> None:
    with pytest.raises(UnknownName, match=r"unknown scene 'crosing'.*Did you mean 'crossing'"):
        find_scene("crosing")


def test_a_knob_that_is_turned_stands_in_the_scene_beside_the_others() -> None:
    scene = find_scene("gauntlet", rate=0, weather="fog", frames=20)
    assert scene.knobs == knobs_of("gauntlet") | {"rate": 0.0, "weather": "fog", "frames": 20}
    assert scene.weather.visibility < 200.0
    assert scene.frame_count == 20


@pytest.mark.parametrize(
    ("knobs", "error", "says"),
    [
        ({"rates": 1.0}, UnknownName, "Did you mean 'rate'"),
        ({"weather": "fogg"}, UnknownName, "Did you mean 'fog'"),
        ({"rate": "much"}, BadConfig, "give a float"),
        ({"vans": 1.5}, BadConfig, "give a int"),
        ({"vans": True}, BadConfig, "give a int"),
        ({"frames": 0}, BadConfig, "0 frames"),
        ({"rate": 2.0}, BadConfig, "0 to 0.6"),
        ({"speed": 1.0}, BadConfig, "4 to 20"),
        ({"gap": 0.0}, BadConfig, "0.5 to 10"),
        ({"houses": 9.0}, BadConfig, "0 to 3"),
        ({"alike": 1.5}, BadConfig, "1.5"),
    ],
)
def test_what_no_scene_can_be_made_of_is_refused(knobs, error, says) -> None:
    with pytest.raises(error, match=says):
        find_scene("gauntlet", **knobs)


@pytest.mark.parametrize(
    "knobs", [{"cars": 1000}, {"parked": 1.5}, {"arrivals": -1.0}, {"vans": 500}, {"frames": 0}]
)
def test_more_than_a_road_holds_is_refused(knobs) -> None:
    with pytest.raises(BadConfig, match=r"\d"):
        record_scene_traffic(find_scene("intersection", **knobs), 0)


def test_every_scene_has_the_common_knobs() -> None:
    assert all(set(COMMON_KNOBS) <= set(knobs_of(name)) for name in SCENES)


@pytest.mark.parametrize("name", sorted(SCENES))
def test_every_knob_of_a_scene_says_what_it_is(name: str) -> None:
    texts = knob_descriptions(name)
    assert list(texts) == list(knobs_of(name))
    assert {knob: text for knob, text in texts.items() if not text} == {}
    assert scene_about(name)
    assert not any(text in scene_about(name) for text in texts.values())


def boats(*, count: int = 2, wind: float = 1.0, frames: int = 9) -> Scene:
    """Boats on a river: three of them at most.

    Light wind. count: how many, and where;
    one per lane. frames: at 10 Hz.
    """
    raise NotImplementedError


def ships(*, frames: int = 9) -> Scene:
    raise NotImplementedError


def test_texts_of_knobs_are_found_inside_a_paragraph() -> None:
    here = f"{__name__}:boats"
    texts = knob_descriptions(here)
    assert texts["count"] == "how many, and where; one per lane."
    assert texts["frames"] == "at 10 Hz."
    assert texts["wind"] == ""
    assert scene_about(here) == "Boats on a river: three of them at most.\n\nLight wind."


def test_a_scene_without_a_docstring_has_knobs_without_texts() -> None:
    here = f"{__name__}:ships"
    assert knob_descriptions(here)["frames"] == ""
    assert scene_about(here) == ""
