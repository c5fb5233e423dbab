"""Finds scenes by name. The modules are imported by string, and only when asked for."""

import re
from collections.abc import Callable
from dataclasses import fields, replace
from inspect import Parameter, getdoc, signature
from typing import Any

from mot_sim.files.field_docstrings import field_docstrings
from mot_sim.simulation.camera_looks import find_camera_look
from mot_sim.simulation.scene import Knob, Scene
from mot_sim.simulation.scene_descriptions import SCENE_NAMES
from mot_sim.simulation.scene_names import COMMON_KNOBS, SCENES
from mot_sim.simulation.scenery import Knobs as Surroundings
from mot_sim.simulation.scenery import WeatherAxes, find_weather
from tracker.errors import BadConfig, UnknownName

COMMON_DESCRIPTIONS = {
    "profile": "The detector's noise: a name (mot-sim list) or a TOML file.",
    "weather": "Light and air of the pictures, by name (mot-sim list).",
    "camera_look": "What the camera makes of the pictures: kitti, plain, or a TOML file.",
}
KNOB_TYPES = (int, float, str, bool)


def find_scene(name: str, **knobs: Knob) -> Scene:
    """The scene of a name, with some of its knobs turned.

    name: of SCENES, of a scene that an installed package registers, or `module:function` of one
    of your own. Raises UnknownName for names and knobs that are not there, with the nearest known
    one, and BadConfig for values of another type or outside a knob's range, and for a function
    that cannot be loaded, raises, or gives no Scene.
    """
    known = knobs_of(name)
    own = set(known) - set(COMMON_KNOBS)
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
    scene: Scene = SCENE_NAMES.make(name, Scene, **{knob: values[knob] for knob in own})
    amounts = {knob: values[knob] for knob in ("houses", "trees", "furniture")}
    shifts = WeatherAxes(**{each.name: values[each.name] for each in fields(WeatherAxes)})
    weather, look = shifts(find_weather(values["weather"]), find_camera_look(values["camera_look"]))
    return replace(
        scene,
        name=name,
        detector=replace(scene.detector, profile=values["profile"]),
        weather=weather,
        camera_look=look,
        surroundings=Surroundings(**amounts),
        knobs=values,
    )


def knobs_of(name: str) -> dict[str, Any]:
    """The knobs of a scene with their defaults, its own and those that all scenes have.

    Raises as `find_scene`, and BadConfig for arguments that cannot be knobs.
    """
    try:
        parameters = signature(scene_maker(name)).parameters.values()
    except (TypeError, ValueError) as error:  # not callable, or of C
        raise BadConfig(f"scene {name!r} is no function: {error}") from None
    own: dict[str, Any] = {}
    for each in parameters:
        if each.kind in (Parameter.VAR_POSITIONAL, Parameter.VAR_KEYWORD):
            continue
        if each.kind is Parameter.POSITIONAL_ONLY or type(each.default) not in KNOB_TYPES:
            raise BadConfig(
                f"scene {name!r}: argument {each} cannot be a knob: give it a default that is a "
                "number, a word, True or False, as in def my_scene(*, speed=14.0, frames=100)"
            )
        if each.name in COMMON_KNOBS:
            raise BadConfig(
                f"scene {name!r}: argument {each.name} is a knob that all scenes have: "
                "give it another name"
            )
        own[each.name] = each.default
    return own | COMMON_KNOBS


def knob_descriptions(name: str) -> dict[str, str]:
    """What each knob of a scene is: what its function's docstring says as `knob: what it is.`.

    Empty for knobs that the docstring does not name. Raises as `knobs_of`.
    """
    found = dict.fromkeys(knobs_of(name), "") | COMMON_DESCRIPTIONS
    amounts = {**field_docstrings(Surroundings), **field_docstrings(WeatherAxes)}
    found |= {
        knob: amounts.get(knob, "") for knob in COMMON_KNOBS if knob not in COMMON_DESCRIPTIONS
    }
    _, *rest = _said_of(name)
    return found | dict(zip(rest[::2], rest[1::2], strict=True))


def scene_about(name: str) -> str:
    """What a scene's function says of it before it comes to the knobs. Raises as `knobs_of`."""
    return _said_of(name)[0]


def _said_of(name: str) -> list[str]:
    """What a scene's function says before its knobs; then each of its own knobs and its text."""
    own = "|".join(re.escape(knob) for knob in knobs_of(name) if knob not in COMMON_KNOBS)
    about = getdoc(scene_maker(name)) or ""
    before, *rest = re.split(rf"(?:^|(?<=[.;])\s+)({own}): ", about) if own else [about]
    texts = (text if at % 2 == 0 else " ".join(text.split()) for at, text in enumerate(rest))
    return [before.strip(), *texts]


def scene_maker(name: str) -> Callable[..., Scene]:
    """The function that makes the scene of a name. Raises as `find_scene`."""
    maker: Callable[..., Scene] = SCENE_NAMES.find(name)
    return maker


__all__ = [
    "COMMON_KNOBS",
    "SCENES",
    "SCENE_NAMES",
    "find_scene",
    "knob_descriptions",
    "knobs_of",
    "scene_about",
    "scene_maker",
]
