"""A design: which levels of which axes, which trackers, how many seeds; also from TOML files."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, fields
from functools import cached_property
from itertools import chain
from pathlib import Path
from typing import Any

from mot_sim.experiments.sweep.conditions import Conditions
from mot_sim.experiments.sweep.paths import Level, unknown
from mot_sim.experiments.sweep.points import (
    DESIGN_MODES,
    Levels,
    Point,
    Range,
    points_of,
    require_levels,
)
from mot_sim.experiments.sweep.tracker_specs import (
    BY_NAME,
    TrackerSpec,
    setting_descriptions,
    tracker_settings,
    tracker_specs_of,
)
from mot_sim.files.documents import read_toml, require_inside
from mot_sim.metrics import RULES
from mot_sim.simulation.registry import scene_maker
from mot_sim.simulation.rig import Rig
from tracker import Tracker
from tracker.errors import BadConfig, UnknownName

DESIGNS_FOLDER = Path(__file__).parent / "designs"
DESIGNS = ("noise",)
TRACKER_AXIS = "tracker."  # what the names of the trackers' axes begin with


@dataclass(frozen=True)
class Design:
    """What a sweep runs: every point with every seed and tracker, on the same traffic and draws.

    Checked when it is made; raises UnknownName and BadConfig.
    """

    axes: Mapping[str, Levels]
    """Levels by the axis's name, all different, or a Range in a random design; at least one
    axis."""
    trackers: Sequence[str | TrackerSpec] = ("default", "paper")
    """The trackers, at least one, no name twice; see `TrackerSpec.parse`. Differences are to the
    first."""
    scene: str = "intersection"
    """Name of the scene."""
    seeds: int = 20
    """Runs per point and tracker, 1 or more; more make the intervals narrower."""
    first_seed: int = 0
    """First seed; the runs use consecutive seeds."""
    frames: int = 100
    """Frames per run, at 10 Hz; 1 or more."""
    fixed: Mapping[str, Level] = field(default_factory=dict)
    """Levels of further axes, the same at every point; none of them may be in `axes`."""
    mode: str = "grid"
    """grid (all combinations), one_at_a_time (the other axes keep their own values), or random (a
    Latin hypercube)."""
    samples: int = 0
    """Points of a random design, above 0; 0 in every other mode."""
    rules: str = "trackeval"
    """Rules of scoring, one of `mot_sim.metrics.RULES`."""
    spatial: bool = False
    """Whether cuboids are scored, too: `sAMOTA@0.25`, `centre_median`, ...; a tracker without
    cuboids fails."""

    def __post_init__(self) -> None:
        for what, name, known in (
            ("mode", self.mode, DESIGN_MODES),
            ("rules", self.rules, RULES),
        ):
            if name not in known:
                raise UnknownName.of(what, name, known)
        scene_maker(self.scene)
        for what, count in (("seeds", self.seeds), ("frames", self.frames)):
            if count < 1:
                raise BadConfig(f"{count} {what}: give 1 or more")
        if not self.axes:
            raise BadConfig("an empty design: give an axis, for example --axis detector.jitter=0,1")
        if (self.mode == "random") != (self.samples > 0):
            raise BadConfig("a random design needs samples, and no other does: --random N")
        for axis, levels in self.axes.items():
            require_levels(axis, levels, self.mode)
            if axis in self.fixed:
                raise BadConfig(f"{axis} is an axis and fixed: keep one")
        self._check_names()
        self._check_points()

    @cached_property
    def contenders(self) -> tuple[TrackerSpec, ...]:
        """The trackers."""
        return tracker_specs_of(self.trackers)

    @cached_property
    def points(self) -> tuple[Point, ...]:
        """The settings of the axes, in the order of the table."""
        known = self.known_axes()
        whole = {axis: type(known.get(axis)) is int for axis in self.axes}
        return points_of(self.axes, self.mode, self.samples, whole)

    @cached_property
    def conditions(self) -> tuple[Conditions, ...]:
        """What the trials of each point are run under."""
        return tuple(self.conditions_at(point) for point in self.points)

    @property
    def seed_numbers(self) -> range:
        """The seeds."""
        return range(self.first_seed, self.first_seed + self.seeds)

    def __len__(self) -> int:
        """The number of trials."""
        return len(self.points) * self.seeds * len(self.contenders)

    def conditions_at(self, point: Point) -> Conditions:
        """What the trials of a point are run under."""
        settings = {"scene.frames": self.frames, **self.fixed, **point}
        return Conditions.of(
            self.scene, {axis: value for axis, value in settings.items() if not is_tracker(axis)}
        )

    def rivals(self, point: Point) -> tuple[TrackerSpec, ...]:
        """The trackers with the settings of a point."""
        settings = {**self.fixed, **point}
        own = {
            axis.removeprefix(TRACKER_AXIS): value
            for axis, value in settings.items()
            if is_tracker(axis)
        }
        return tuple(each.with_settings(own) for each in self.contenders)

    def known_axes(self) -> dict[str, Level]:
        """Every axis of this scene and profile, with its own value."""
        found = self._own_conditions().axes()
        for built in self._our_trackers():
            found |= {TRACKER_AXIS + name: value for name, value in tracker_settings(built).items()}
        return found | {TRACKER_AXIS + name: "" for name in BY_NAME}

    def axis_descriptions(self) -> dict[str, str]:
        """What each of `known_axes` is."""
        found = self._own_conditions().axis_descriptions()
        for built in (*self._our_trackers(), Tracker.default(Rig.kitti().camera)):
            texts = setting_descriptions(built)
            found |= {TRACKER_AXIS + name: text for name, text in texts.items()}
        return {axis: found.get(axis, "") for axis in self.known_axes()}

    def _own_conditions(self) -> Conditions:
        """The scene's and the profile's own values."""
        fixed = {axis: value for axis, value in self.fixed.items() if axis.startswith("scene.")}
        return Conditions.of(self.scene, {"scene.frames": self.frames, **fixed})

    def _our_trackers(self) -> Iterator[Any]:
        """Those of the trackers whose settings are axes."""
        return (each.build(Rig.kitti().camera) for each in self.contenders if each.is_ours)

    def description(self) -> dict[str, Any]:
        """The design in plain values, as `sweep.json` and the table keep it."""
        axes: dict[str, Any] = {
            axis: {"low": levels.low, "high": levels.high, "log": levels.log}
            if isinstance(levels, Range)
            else list(levels)
            for axis, levels in self.axes.items()
        }
        trackers = {
            each.name: {"made_by": each.made_by, **each.settings} for each in self.contenders
        }
        plain = ("scene", "seeds", "first_seed", "frames", "mode", "samples", "rules", "spatial")
        about = {name: getattr(self, name) for name in plain}
        return {**about, "fixed": dict(self.fixed), "axes": axes, "trackers": trackers}

    def _check_names(self) -> None:
        """Raise UnknownName for axes that nobody has, BadConfig for those of foreign trackers."""
        known = self.known_axes()
        foreign = [each.name for each in self.contenders if not each.is_ours]
        for axis in (*self.axes, *self.fixed):
            if is_tracker(axis) and foreign:
                raise BadConfig(
                    f"axis {axis}: tracker {foreign[0]} is none of ours and has no such axes; "
                    "name its settings one by one: NAME=MODULE:CALLABLE:SETTING=VALUE"
                )
            if axis not in known:
                self.conditions_at({axis: 0.0} if not is_tracker(axis) else {})
                raise unknown("axis", axis, known)

    def _check_points(self) -> None:
        """Raise UnknownName or BadConfig for levels and trackers that cannot be."""
        _ = self.conditions
        for rivals in {repr(rivals): rivals for rivals in map(self.rivals, self.points)}.values():
            for each in rivals:
                each.check()


def is_tracker(axis: str) -> bool:
    """Whether an axis is the trackers' own."""
    return axis.startswith(TRACKER_AXIS)


def read_design(name: str, **changes: Any) -> Design:
    """The design of a name, or of a TOML file, with some fields changed.

    Raises UnknownName, BadFile for no TOML, BadConfig for a design that cannot be.
    """
    if name in DESIGNS:
        path = DESIGNS_FOLDER / f"{name}.toml"
    elif name.endswith(".toml"):
        path = Path(name)
    else:
        raise UnknownName.of("design", name, DESIGNS)
    content = read_toml(path, "no design can be read")
    known = {each.name: each for each in fields(Design)}
    for key in content:
        if key not in known:
            raise UnknownName.of(f"entry of {path}:", key, known)
    content["axes"] = {
        axis: _levels(levels, f"{path}: axis {axis}")
        for axis, levels in _table(content.get("axes", {}), f"{path}: axes").items()
    }
    content["trackers"] = _trackers(content.get("trackers", ["default", "paper"]), path)
    _require_types(content, path)
    _require_profiles(content, path)
    return Design(**{**content, **changes})


def _table(value: Any, where: str) -> Mapping[str, Any]:
    if not isinstance(value, Mapping):
        raise BadConfig(f"{where}: {value!r} is no table")
    return value


def _levels(value: Any, where: str) -> Levels:
    """A list of levels, or a table low, high, log."""
    if isinstance(value, Mapping):
        try:
            return Range(float(value["low"]), float(value["high"]), bool(value.get("log", False)))
        except (KeyError, TypeError, ValueError):
            raise BadConfig(f"{where}: {dict(value)}: write {{low = 0, high = 1}}") from None
    if not isinstance(value, list) or not all(
        isinstance(each, float | int | str) for each in value
    ):
        raise BadConfig(f"{where}: {value!r} is no list of levels")
    return tuple(value)


def _trackers(value: Any, path: Path) -> tuple[str | TrackerSpec, ...]:
    """A list of words, or a table of tables."""
    if isinstance(value, list) and all(isinstance(each, str) for each in value):
        return tuple(value)
    found = []
    for name, table in _table(value, f"{path}: trackers").items():
        settings = dict(_table(table, f"{path}: tracker {name}"))
        for key, setting in settings.items():
            if not isinstance(setting, Level):
                raise BadConfig(f"{path}: tracker {name}: {key} = {setting!r}: give one value")
        found.append(TrackerSpec(name, str(settings.pop("made_by", "default")), settings))
    return tuple(found)


def _require_profiles(content: Mapping[str, Any], path: Path) -> None:
    """Raise BadFile for a profile's file that lies neither beside the design nor where we work."""
    axes = [levels for levels in content["axes"].values() if isinstance(levels, tuple)]
    for level in (*chain(*axes), *content.get("fixed", {}).values()):
        if isinstance(level, str) and level.endswith(".toml"):
            require_inside(level, f"{path}", path.parent, Path.cwd())


def _require_types(content: Mapping[str, Any], path: Path) -> None:
    """Raise BadConfig for a word where a number belongs, or the other way round."""
    words = dict.fromkeys(("scene", "mode", "rules"), str)
    wanted = {**words, "spatial": bool, "fixed": dict} | dict.fromkeys(
        ("seeds", "first_seed", "frames", "samples"), int
    )
    for key, kind in wanted.items():
        if key in content and type(content[key]) is not kind:
            raise BadConfig(f"{path}: {key} = {content[key]!r}: give a {kind.__name__}")
    for axis, level in content.get("fixed", {}).items():
        if not isinstance(level, Level):
            raise BadConfig(f"{path}: fixed {axis} = {level!r}: give one value")


__all__ = ["DESIGNS", "Design", "Point", "Range", "read_design"]
