"""Gymnasium's ids: one for every scene, one for any scene, and one for association."""

import re
from importlib.metadata import entry_points

import gymnasium as gym

from mot_sim.simulation.scene_names import SCENE_GROUP, SCENES

NAMESPACE = "mot_sim"
ANY_SCENE = f"{NAMESPACE}/Scene-v0"
ASSOCIATION = f"{NAMESPACE}/Association-v0"
WELL_NAMED = re.compile(r"[\w/-]+")  # what Gymnasium takes
SCENE_ENV = "mot_sim.envs.scene_env:SceneEnv"


def register_environments() -> None:
    """Register all ids that are not registered yet; their modules are imported by `gym.make`.

    Scenes of installed packages have ids like ours; only their names are looked up here.
    """
    scenes = [*SCENES, *sorted(entry_points(group=SCENE_GROUP).names)]
    wanted = {
        ASSOCIATION: ("mot_sim.envs.association_env:AssociationEnv", {}),
        ANY_SCENE: (SCENE_ENV, {}),
        **{environment_id(name): (SCENE_ENV, {"scene": name}) for name in reversed(scenes)},
    }
    for name, (place, options) in wanted.items():
        if name not in gym.registry and WELL_NAMED.fullmatch(name):
            gym.register(name, place, kwargs=options)


def environment_id(scene: str) -> str:
    """`mot_sim/TJunction-v0` of the scene `t_junction`."""
    return f"{NAMESPACE}/{''.join(word.capitalize() for word in scene.split('_'))}-v0"
