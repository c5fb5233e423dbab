"""Finds scenes by name. The modules are imported by string, and only when asked for."""

from collections.abc import Callable
from dataclasses import replace
from importlib import import_module
from inspect import Parameter, signature
from typing import Any

from mot_sim.simulation.scene import Knob, Scene
from mot_sim.simulation.scene_names import SCENES
from mot_sim.simulation.scenery import Knobs as Surroundings
from mot_sim.simulation.scenery import find_weather
from tracker.errors import BadConfig, UnknownName

# What can be set for every scene: a name of `mot_sim.simulation.scenery.WEATHERS`, and how many houses, trees,
# lamps and signs stand beside the roads (1 = as in a usual town, at most 3).
# profile: of the detector's noise, a name of `mot_sim.simulation.sensors.PROFILES` or a TOML file.
COMMON: dict[str, Any] = {
    "profile": "rrc", "weather": "noon", "houses": 1.0, "trees": 1.0, "furniture": 1.0,
}  # fmt: skip


def find_scene(name: str, **knobs: Knob) -> Scene:
    """The scene of a name, with some of its knobs turned.

    Raises UnknownName for names and knobs that are not there, with the nearest known one, and
    BadConfig for values of another type or outside a knob's range.
    """
    make, known = scene_maker(name), knobs_of(name)
    own = set(known) - set(COMMON)
    for knob, value in knobs.items():
        if knob not in known:
            raise UnknownName.of(f"knob of scene {name}:", knob, known)
        wanted = type(known[knob])
        is_whole = wanted is float and type(value) is int
        if type(value) is not wanted and not is_whole:
            raise BadConfig(
                f"knob {knob} of scene {name} is {value!r}: give a {wanted.__name__}, for "
                f"example {known[knob]!r}"
            )
    values = known | {knob: type(known[knob])(value) for knob, value in knobs.items()}
    scene = make(**{knob: values[knob] for knob in own})
    amounts = {knob: values[knob] for knob in ("houses", "trees", "furniture")}
    return replace(
        scene,
        name=name,
        detector=replace(scene.detector, profile=values["profile"]),
        weather=find_weather(values["weather"]),
        surroundings=Surroundings(**amounts),
        knobs=values,
    )


def knobs_of(name: str) -> dict[str, Any]:
    """The knobs of a scene with their defaults, its own and those that all scenes have."""
    parameters = signature(scene_maker(name)).parameters.values()
    own = {each.name: each.default for each in parameters if each.kind is Parameter.KEYWORD_ONLY}
    return own | COMMON


def scene_maker(name: str) -> Callable[..., Scene]:
    """The function that makes the scene of a name."""
    if name not in SCENES:
        raise UnknownName.of("scene", name, SCENES)
    module, _, attribute = SCENES[name].partition(":")
    maker: Callable[..., Scene] = getattr(import_module(module), attribute)
    return maker


__all__ = ["COMMON", "SCENES", "find_scene", "knobs_of", "scene_maker"]
