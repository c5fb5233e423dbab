"""What is asked of a breaking point: which axis, which score, how large a drop."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from math import isfinite

from mot_sim.experiments.stress.bisection import Reach
from mot_sim.experiments.sweep.design import Design
from mot_sim.experiments.sweep.paths import Level
from mot_sim.experiments.sweep.tracker_specs import TrackerSpec
from mot_sim.tables import RATES
from tracker.errors import BadConfig, UnknownName

FARTHEST = 64.0  # first steps, where nobody says how far to go


@dataclass(frozen=True)
class BreakingPointSpec:
    """At which level of an axis does a score fall by `drop` from what it is at `start`?

    metric: a rate (HOTA, IDF1, ...); drop: in fractions. start: where nothing is wrong. end: the
    farthest level; None: 64 steps of the axis's own value (of 1, where that is 0), or as far as
    the axis goes. levels: to be tried in turn instead, from the best on; for axes that take only
    some. precision: of the level, relative. The others are as in `Design`. Checked when it is
    made; raises UnknownName and BadConfig.
    """

    axis: str
    metric: str = "HOTA"
    drop: float = 0.05
    start: Level = 0.0
    end: Level | None = None
    levels: tuple[Level, ...] = ()
    precision: float = 0.1
    trackers: Sequence[str | TrackerSpec] = ("default", "paper")
    scene: str = "intersection"
    seeds: int = 8
    first_seed: int = 0
    frames: int = 80
    fixed: Mapping[str, Level] = field(default_factory=dict)

    def __post_init__(self) -> None:
        if self.metric not in RATES.values():
            raise UnknownName.of("rate", self.metric, RATES.values())
        if not 0.0 < self.drop < 1.0:
            raise BadConfig(f"a drop of {self.drop:g}: give a fraction between 0 and 1, as 0.05")
        if self.seeds < 2:
            raise BadConfig(f"{self.seeds} seeds: give 2 or more, or there is no interval")
        if not 0.001 <= self.precision <= 0.5:
            raise BadConfig(f"precision {self.precision:g}: give 0.001 to 0.5 of the level")
        if self.levels and len(self.levels) < 2:
            raise BadConfig("give two levels or more: the first is where nothing is wrong")
        design = self.design(self.best)
        if not self.levels:
            self._require_numbers(design.known_axes()[self.axis])
        for level in (*self.levels, self.end):
            if level is not None:
                self.design(level)

    @property
    def best(self) -> Level:
        """The level where nothing is wrong."""
        return self.levels[0] if self.levels else self.start

    def design(self, level: Level) -> Design:
        """The sweep of one level."""
        return Design(
            axes={self.axis: (level,)}, trackers=self.trackers, scene=self.scene,
            seeds=self.seeds, first_seed=self.first_seed, frames=self.frames, fixed=self.fixed,
        )  # fmt: skip

    def _require_numbers(self, own: Level) -> None:
        """BadConfig for an axis of words, and for ends that are no two numbers."""
        for level in (own, self.start, self.start if self.end is None else self.end):
            if isinstance(level, bool | str) or not isfinite(level):
                raise BadConfig(
                    f"axis {self.axis} with {level!r}: levels between two cannot be tried; give "
                    "them all, the best first: --levels clear,fog,night"
                )
        if self.start == self.end:
            raise BadConfig(f"axis {self.axis}: from {self.start} to {self.end} is no way")

    @cached_property
    def reach(self) -> Reach:
        """How far to go from the start, in steps of 1 level, or in places of `levels`."""
        if self.levels:
            return Reach(1.0, len(self.levels) - 1.0, is_whole=True)
        own = self.design(self.start).known_axes()[self.axis]
        is_whole = type(own) is int
        step = abs(float(own) - float(self.start)) or 1.0
        most = FARTHEST * step if self.end is None else abs(float(self.end) - float(self.start))
        return Reach(min(step, most), most, self.precision, is_whole)

    def level(self, place: float) -> Level:
        """The level at a place of `reach`."""
        if self.levels:
            return self.levels[int(place)]
        down = self.end is not None and float(self.end) < float(self.start)
        level = float(self.start) + (-place if down else place)
        return int(level) if self.reach.is_whole else level
