"""Scenes are found by name."""

import pytest

from mot_sim.episode import Scene
from mot_sim.registry import SCENES, find_scene
from tracker.errors import UnknownName


@pytest.mark.parametrize("name", sorted(SCENES))
def test_every_registered_scene_is_there_under_its_own_name(name) -> None:
    scene = find_scene(name)
    assert isinstance(scene, Scene)
    assert scene.name == name


def test_a_typo_gets_a_hint() -> None:
    with pytest.raises(UnknownName, match=r"unknown scene 'crosing'.*Did you mean 'crossing'"):
        find_scene("crosing")
