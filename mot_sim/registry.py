"""Finds scenes by name. The modules are imported by string, and only when asked for."""

from importlib import import_module

from mot_sim.episode import Scene
from tracker.errors import UnknownName

# The name of a scene: the module and the attribute that hold it.
SCENES: dict[str, str] = {
    "crossing": "scenes.crossing:SCENE",
}


def find_scene(name: str) -> Scene:
    """The scene of a name. Raises UnknownName, with the nearest known one."""
    if name not in SCENES:
        raise UnknownName.of("scene", name, SCENES)
    module, _, attribute = SCENES[name].partition(":")
    scene: Scene = getattr(import_module(module), attribute)
    return scene
