"""What a trial is run under: scene, camera, detector, motion; every value of it can be an axis."""

from collections.abc import Mapping
from dataclasses import MISSING, dataclass, field, fields, replace
from functools import lru_cache
from math import inf, radians
from typing import Any

import numpy as np
from jaxtyping import Float, Int
from numpy import ndarray as Array
from scipy.special import expit, logit

from mot_sim.experiments.sweep.paths import (
    Level,
    descriptions,
    fitting,
    scalars,
    unknown,
    with_value,
)
from mot_sim.files.field_docstrings import field_docstrings
from mot_sim.simulation.registry import SCENE_NAMES, find_scene, knob_descriptions, knobs_of
from mot_sim.simulation.rig import KITTI_HEIGHT_METRES, KITTI_IMAGE_SIZE, KITTI_K, Rig
from mot_sim.simulation.scene import Scene
from mot_sim.simulation.scenery import WeatherAxes
from mot_sim.simulation.sensors import (
    EFFECTS,
    Detector,
    Miscalibration,
    Odometry,
    Profile,
    Timing,
    find_profile,
    in_fog_and_rain,
    in_weather,
)
from mot_sim.simulation.traffic.traffic_state import STEP_SECONDS
from tracker.errors import BadConfig
from tracker.types import Camera

# Knobs that no box, no label and no motion hangs on, while no pictures are drawn.
KNOBS_OF_PICTURES = (
    "profile", "weather", "camera_look", "fog", "rain", "sun_elevation", "exposure",
)  # fmt: skip
# What to do instead for an axis that changes only pictures.
CURES_OF_PICTURES = {
    "scene.weather": "detector.weather = {} makes the detector see as badly as that",
    "scene.fog": "detector.fog = {:g} makes the detector see as badly as that",
    "scene.rain": "detector.rain = {:g} makes the detector see as badly as that",
    **{
        f"scene.{knob}": f"record drives with --knobs {knob}={{}} and detect cars in them"
        for knob in ("camera_look", "sun_elevation", "exposure")
    },
}
MIN_DOUBT = 1e-9  # in a score, so that its log-odds are finite
# What the names of axes begin with, beside the names of EFFECTS.
AXIS_ROOTS = ("scene", "rig", "detector", "odometry", "timing", "miscalibration")


@dataclass(frozen=True)
class Mount:
    """KITTI's camera: its true mounting, and how wrongly the tracker is told about it."""

    height: float = KITTI_HEIGHT_METRES
    """True height of the camera above the road, metres, above 0; the tracker is told it."""
    pitch_deg: float = 0.0
    """True pitch in degrees, > 0 looks up; the tracker is told it."""
    roll_deg: float = 0.0
    """True roll in degrees, > 0 leans right; the tracker is told it."""
    height_error: float = 0.0
    """The height that the tracker is told less the true one, metres."""
    pitch_error_deg: float = 0.0
    """The pitch that the tracker is told less the true one, degrees."""
    frame_rate: float = 10.0
    """Frames per second that reach the tracker: 10 Hz or 10 divided by a whole number."""

    def __post_init__(self) -> None:
        every = 1.0 / (STEP_SECONDS * self.frame_rate) if self.frame_rate > 0.0 else 0.0
        if every < 0.99 or abs(every - round(every)) > 0.02 * every:
            raise BadConfig(
                f"rig.frame_rate = {self.frame_rate:g}: give 10 Hz over a whole number: "
                "10, 5, 3.333, 2.5, 2, ..."
            )

    @property
    def every(self) -> int:
        """How many frames are recorded for each that comes."""
        return round(1.0 / (STEP_SECONDS * self.frame_rate))

    @property
    def rig(self) -> Rig:
        """The true camera."""
        return Rig.kitti(self.height, radians(self.pitch_deg), radians(self.roll_deg))

    @property
    def believed(self) -> Camera:
        """The camera that the tracker is told of."""
        height, pitch = self.height + self.height_error, self.pitch_deg + self.pitch_error_deg
        K, size = np.array(KITTI_K), KITTI_IMAGE_SIZE
        return Camera.mounted(K, size, height, radians(pitch), radians(self.roll_deg))


@dataclass(frozen=True)
class NoiseLevels:
    """Factors on each kind of the profile's noise, see `Detector`; 1: as it is, 0: none."""

    jitter: float = 1.0
    """Factor on the noise of box edges, finite, >= 0; raising it makes boxes jump more."""
    misses: float = 1.0
    """Factor on the probability of missing a car, finite, >= 0; raising it misses more cars."""
    score_noise: float = 1.0
    """Factor on how far scores lie below 1, finite, >= 0; raising it lowers and spreads them."""
    clutter: float = 1.0
    """Factor on the rates of false alarms and second boxes, finite, >= 0; raising it adds more."""
    cues: float = 1.0
    """Factor on the noise of yaw, size, keypoints, shape and appearance, finite, >= 0."""
    confidence: float = 1.0
    """Factor on the log-odds of scores, finite, >= 0; lowering it brings all scores near 0.5."""
    weather: str = "clear"
    """One of `mot_sim.simulation.sensors.WEATHERS`; the profile is changed to what it becomes in
    it."""
    fog: float = 0.0
    """Visibility in fog, metres, 10 to 20000, on top; 125 is the weather `fog`. 0: none."""
    rain: float = 0.0
    """Rain, mm/h, 0.1 to 150, on top; 16 is the weather `rain`. 0: none."""


@dataclass(frozen=True)
class Conditions:
    """Everything but the seed and the tracker that decides a trial."""

    scene: str
    """Name of the scene."""
    knobs: Mapping[str, Level]
    """The values of all knobs of the scene, by name."""
    effects: Profile
    """The detector's profile, parameter by parameter."""
    rig: Mount = field(default_factory=Mount)
    """The camera, and what the tracker is told about it."""
    detector: NoiseLevels = field(default_factory=NoiseLevels)
    """Factors on the profile's noise, and the weather."""
    odometry: Odometry = field(default_factory=Odometry)
    """Errors of the camera's motion as the tracker is told it."""
    timing: Timing = field(default_factory=Timing)
    """Lost frames, wrong time stamps and latency."""
    miscalibration: Miscalibration = field(default_factory=Miscalibration)
    """Errors of the camera's calibration, a rising road, and the camera's vibration."""

    @classmethod
    def of(cls, scene: str, settings: Mapping[str, Level]) -> "Conditions":
        """A scene's own conditions with some axes set; `scene.*` first, for its profile.

        Raises UnknownName for axes that are not there, BadConfig for values that cannot be.
        """
        knobs = knobs_of(scene)
        if "frames" not in knobs and "scene.frames" in settings:
            raise BadConfig(
                f"scene {scene!r} has no knob frames, how long it is, as in "
                "def my_scene(*, frames=100)"
            )
        found = cls(scene, knobs, _profile_of(str(knobs["profile"])))
        in_order = sorted(settings.items(), key=lambda each: not each[0].startswith("scene."))
        for axis, level in in_order:
            found = found.with_level(axis, level)
        found.check()
        return found

    def axes(self) -> dict[str, Level]:
        """Every axis with its value here."""
        return scalars(self._parts())

    def axis_descriptions(self) -> dict[str, str]:
        """What each of `axes` is."""
        own = field_docstrings(Profile)
        found = {f"scene.{knob}": text for knob, text in knob_descriptions(self.scene).items()}
        for root, part in self._parts().items():
            if root != "scene":
                found |= descriptions(part, root, own.get(root, ""))
        return found

    def _parts(self) -> dict[str, Any]:
        """What has axes, by what their names begin with."""
        parts = {root: self._part(root) for root in (*AXIS_ROOTS, *EFFECTS)}
        return {root: part for root, part in parts.items() if part is not None}

    def _part(self, root: str) -> Any:
        """What an axis whose name begins like this belongs to; None: nothing."""
        if root == "scene":
            return self.knobs
        if root in EFFECTS:
            return _effect(self.effects, root)
        return getattr(self, root) if root in AXIS_ROOTS else None

    def with_level(self, axis: str, level: Level) -> "Conditions":
        """The same with one axis set. Raises UnknownName and BadConfig."""
        root, _, path = axis.partition(".")
        part = self._part(root)
        known = scalars(part, root) if part is not None else {}
        if axis not in known:
            if root in EFFECTS and part is None:
                raise BadConfig(
                    f"axis {axis}: profile {self.effects.name} has no {root}; take a profile that "
                    "has: --profile rrc"
                )
            raise unknown("axis", axis, self.axes())
        value = fitting(level, known[axis], axis)
        if axis in CURES_OF_PICTURES and value != known[axis]:
            raise BadConfig(
                f"{axis} = {value} changes only pictures, and none are drawn here: "
                + CURES_OF_PICTURES[axis].format(value)
            )
        if root == "scene":
            effects = _profile_of(str(value)) if path == "profile" else self.effects
            return replace(self, knobs={**self.knobs, path: value}, effects=effects)
        if root in EFFECTS:
            effects = replace(self.effects, **{root: with_value(part, path, value)})
            return replace(self, effects=effects)
        return replace(self, **{root: with_value(part, path, value)})

    def check(self) -> None:
        """Raise what is wrong with the scene's knobs, the camera and the detector."""
        self.make_scene()
        _ = self.make_detector(), self.rig.believed

    def make_scene(self) -> Scene:
        """The scene, with the true camera."""
        scene = _scene_of(self.scene, tuple(sorted(self.knobs.items())))
        return replace(scene, rig=self.rig.rig)

    def make_detector(self) -> Detector:
        """The detector, in its weather."""
        told = self.detector
        if not 0.0 <= told.confidence < inf:
            raise BadConfig(f"detector.confidence {told.confidence:g}: give a number, 0 or more")
        _ = WeatherAxes(told.fog, told.rain)  # raises BadConfig for what is none
        profile = in_fog_and_rain(in_weather(self.effects, told.weather), told.fog, told.rain)
        return Detector(
            profile, told.jitter, told.misses, told.score_noise,
            told.clutter, told.cues,
        )  # fmt: skip

    def seen_scores(self, scores: Float[Array, " n"]) -> Float[Array, " n"]:
        """The detector's scores, 0 to 1, as these conditions show them."""
        if self.detector.confidence == 1.0:
            return scores
        return expit(self.detector.confidence * logit(scores.clip(MIN_DOUBT, 1.0 - MIN_DOUBT)))

    def frames(self, count: int) -> Int[Array, " k"]:
        """The frames of so many that come at the frame rate, before any is lost."""
        return np.arange(0, count, self.rig.every)

    def traffic(self) -> dict[str, Any]:
        """What decides who is where; source: of a scene that is none of ours."""
        knobs = _without(self.knobs, KNOBS_OF_PICTURES)
        return {"scene": self.scene, "source": SCENE_NAMES.source(self.scene), "knobs": knobs}

    def truth(self) -> dict[str, Any]:
        """What decides what is true of every car in the image."""
        camera = (self.rig.height, self.rig.pitch_deg, self.rig.roll_deg)
        return self.traffic() | {"camera": camera}

    def description(self) -> dict[str, Any]:
        """What decides what trackers are given, and what they are scored against."""
        return {each.name: getattr(self, each.name) for each in fields(self)} | self.traffic()


@lru_cache(maxsize=256)
def _scene_of(name: str, knobs: tuple[tuple[str, Level], ...]) -> Scene:
    """A scene; to be made once, since some look at their whole road when they are made."""
    return find_scene(name, **dict(knobs))


@lru_cache(maxsize=64)
def _profile_of(name: str) -> Profile:
    return find_profile(name)


def _without(knobs: Mapping[str, Level], names: tuple[str, ...]) -> dict[str, Level]:
    return {name: value for name, value in knobs.items() if name not in names}


def _effect(profile: Profile, name: str) -> Any:
    """An effect of the profile; one that does nothing where it has none; None: there is none."""
    effect = getattr(profile, name)
    if effect is not None:
        return effect
    kind = EFFECTS[name]
    required = [
        each for each in fields(kind) if each.default is MISSING and each.default_factory is MISSING
    ]
    return None if required else kind()


__all__ = ["Conditions", "Mount", "NoiseLevels"]
