"""Gymnasium's ids: one for every scene, and `mot_sim/Association-v0`; all made lazily."""

import gymnasium as gym

from mot_sim.simulation.scene_names import SCENES

NAMESPACE = "mot_sim"
ASSOCIATION = f"{NAMESPACE}/Association-v0"


def register_environments() -> None:
    """Register all ids that are not registered yet; their modules are imported by `gym.make`."""
    if ASSOCIATION not in gym.registry:
        gym.register(ASSOCIATION, "mot_sim.envs.association_env:AssociationEnv")
    for scene in SCENES:
        if environment_id(scene) not in gym.registry:
            gym.register(
                environment_id(scene), "mot_sim.envs.scene_env:SceneEnv", kwargs={"scene": scene}
            )


def environment_id(scene: str) -> str:
    """`mot_sim/TJunction-v0` of the scene `t_junction`."""
    return f"{NAMESPACE}/{''.join(word.capitalize() for word in scene.split('_'))}-v0"
