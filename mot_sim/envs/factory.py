"""From the options of a scene environment to its scene; wrong ones are refused here."""

from dataclasses import replace
from functools import lru_cache

from mot_sim.simulation.registry import find_scene, knobs_of
from mot_sim.simulation.renderers import AUTO, RENDERER_NAMES, RENDERERS
from mot_sim.simulation.rig import Rig
from mot_sim.simulation.scene import Knob, Scene
from tracker.errors import BadConfig, UnknownName
from tracker.types import Camera

TRAFFIC = ("recorded", "live")
RENDER_MODES = ("rgb_array", "human")
OPTIONS = ("traffic", "render_mode", "image", "max_detections", "renderer", "scale", "kept_runs")
SCALES = (0.1, 2.0)


def require_words(traffic: str, render_mode: str | None, renderer: str, kept_runs: int) -> None:
    """Raises UnknownName for words that are none, BadConfig for a negative number."""
    if traffic not in TRAFFIC:
        raise UnknownName.of("traffic", traffic, TRAFFIC)
    if render_mode not in (None, *RENDER_MODES):
        raise UnknownName.of("render mode", str(render_mode), RENDER_MODES)
    if renderer != AUTO and renderer not in RENDERER_NAMES:
        raise UnknownName.of("renderer", renderer, (*RENDERERS, AUTO))
    if kept_runs < 0:
        raise BadConfig(f"kept_runs is {kept_runs}: give 0 or more")


def find_long_scene(name: str, knobs: dict[str, Knob]) -> Scene:
    """The scene of a name and its knobs, two or more frames long."""
    known = knobs_of(name)
    for knob in knobs:
        if knob not in known:
            raise UnknownName.of(f"option or knob of scene {name}:", knob, (*OPTIONS, *known))
    frames = knobs.get("frames", known.get("frames"))
    if type(frames) is int and frames < 2:
        raise BadConfig(f"frames of scene {name} is {frames}: an environment needs 2 or more")
    return scene_made(name, tuple(sorted(knobs.items())))


@lru_cache(maxsize=32)
def scene_made(name: str, knobs: tuple[tuple[str, Knob], ...]) -> Scene:
    """The one scene of a name and its knobs: what stands beside its roads is remembered."""
    return find_scene(name, **dict(knobs))


def scaled(scene: Scene, scale: float) -> Scene:
    """The scene with a camera of fewer or more pixels, and the same view."""
    if not SCALES[0] <= scale <= SCALES[1]:
        raise BadConfig(f"scale is {scale:g}: give {SCALES[0]:g} to {SCALES[1]:g}")
    if scale == 1.0:
        return scene
    camera = scene.rig.camera
    K = camera.K.copy()
    K[:2, :2] *= scale
    K[:2, 2] = (K[:2, 2] + 0.5) * scale - 0.5  # pixel centres are at integers
    width, height = (round(scale * side) for side in camera.image_size)
    return replace(scene, rig=Rig(Camera(K, (width, height), camera.T_cam_road)))
