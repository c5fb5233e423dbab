"""A design: which levels of which axes, which trackers, how many seeds."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

from mot_sim.experiments.sweep.conditions import Conditions
from mot_sim.experiments.sweep.paths import Level, unknown
from mot_sim.experiments.sweep.points import MODES, Levels, Point, Range, points_of, require_levels
from mot_sim.experiments.sweep.tracker_specs import (
    BY_NAME,
    TrackerSpec,
    tracker_settings,
    tracker_specs_of,
)
from mot_sim.metrics import RULES
from mot_sim.simulation.registry import scene_maker
from mot_sim.simulation.rig import Rig
from tracker.errors import BadConfig, UnknownName

TRACKER = "tracker."  # what the names of the trackers' axes begin with


@dataclass(frozen=True)
class Design:
    """What a sweep runs: every point with every seed and every tracker. Checked when it is made.

    axes: levels by axis, or a Range. trackers: see `TrackerSpec.parse`. seeds: how many, from
    first_seed on; every point and tracker gets the same traffic and the same draws. frames: of
    each run, at 10 Hz. fixed: axes that are the same everywhere. mode: grid (all combinations),
    one_at_a_time (the others keep their own value), random (`samples` points, a Latin hypercube).
    Raises UnknownName and BadConfig.
    """

    axes: Mapping[str, Levels]
    trackers: Sequence[str | TrackerSpec] = ("default", "paper")
    scene: str = "intersection"
    seeds: int = 20
    first_seed: int = 0
    frames: int = 100
    fixed: Mapping[str, Level] = field(default_factory=dict)
    mode: str = "grid"
    samples: int = 0
    rules: str = "trackeval"

    def __post_init__(self) -> None:
        for what, name, known in (
            ("mode", self.mode, MODES),
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
            axis.removeprefix(TRACKER): value
            for axis, value in settings.items()
            if is_tracker(axis)
        }
        return tuple(each.with_settings(own) for each in self.contenders)

    def known_axes(self) -> dict[str, Level]:
        """Every axis of this scene and profile, with its own value."""
        fixed = {axis: value for axis, value in self.fixed.items() if axis.startswith("scene.")}
        found = Conditions.of(self.scene, {"scene.frames": self.frames, **fixed}).axes()
        for each in (each for each in self.contenders if each.is_ours):
            built = each.build(Rig.kitti().camera)
            found |= {TRACKER + name: value for name, value in tracker_settings(built).items()}
        return found | {TRACKER + name: "" for name in BY_NAME}

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
        plain = ("scene", "seeds", "first_seed", "frames", "mode", "samples", "rules")
        return {
            **{name: getattr(self, name) for name in plain},
            "fixed": dict(self.fixed), "axes": axes, "trackers": trackers,
        }  # fmt: skip

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
    return axis.startswith(TRACKER)


__all__ = ["Design", "Point", "Range"]
