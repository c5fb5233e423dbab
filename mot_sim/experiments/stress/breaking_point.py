"""Breaking points: the level of an axis at which a tracker has lost so much of a score."""

from collections.abc import Callable, Mapping, Sequence
from contextlib import nullcontext
from dataclasses import dataclass, field, replace
from functools import cached_property
from math import isfinite
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from mot_sim.experiments.sweep.design import Design
from mot_sim.experiments.sweep.paths import Level
from mot_sim.experiments.sweep.running import sweep
from mot_sim.experiments.sweep.summary import SummaryRow
from mot_sim.experiments.sweep.tracker_specs import TrackerSpec
from mot_sim.tables import RATES, Interval, limits_of
from tracker.errors import BadConfig, UnknownName

MIN_PLACE = 1e-4  # of the first step: a place nearer to 0 than that is 0
MAX_FIRST_STEPS = 64.0  # first steps, where nobody says how far to go
RUNS_FOLDER = "runs"  # the sweep's folder inside that of a search

# Called with a tracker's name and the level that it is tried at.
Telling = Callable[[str, Level], None]


@dataclass(frozen=True)
class Reach:
    """How places on an axis are searched, from place 0 on: steps that double, then bisection."""

    first: float
    """Length of the first step, in places; it doubles until a bad place is found."""
    most: float
    """The farthest place that is tried."""
    precision: float = 0.1
    """Width at which a bracket is narrow enough, as a share of its far end; smaller takes more
    runs."""
    is_whole: bool = False
    """Whether places are whole numbers; then a bracket of width 1 is narrow enough."""

    def bracket(self, is_bad: Callable[[float], bool]) -> tuple[float, float] | None:
        """Two places, the near one good and the far one bad; None where all are good.

        Place 0 is taken for good, and is not asked about.
        """
        near, far = 0.0, min(self.first, self.most)
        while not is_bad(far):
            if far >= self.most:
                return None
            near, far = far, min(2.0 * far, self.most)
        while not self._is_narrow(near, far):
            middle = 0.5 * (near + far)
            if self.is_whole:
                middle = float(int(middle))
            if is_bad(middle):
                far = middle
            else:
                near = middle
        return near, far

    def _is_narrow(self, near: float, far: float) -> bool:
        if self.is_whole:
            return far - near <= 1.0
        return far - near <= self.precision * far or far <= MIN_PLACE * self.first


@dataclass(frozen=True)
class BreakingPointSpec:
    """Asks at which level of an axis a score has fallen by `drop` from its value at `start`.

    Checked when it is made; raises UnknownName and BadConfig.
    """

    axis: str
    """Name of the axis whose level is searched, such as detector.jitter."""
    metric: str = "HOTA"
    """The rate that must fall, by TrackEval's name: HOTA, IDF1, MOTA, ..."""
    drop: float = 0.05
    """The fall that is looked for, a share strictly between 0 and 1; raising it moves the point
    farther out."""
    start: Level = 0.0
    """The level where nothing is wrong, and from which the fall is measured."""
    end: Level | None = None
    """The farthest level; None: 64 steps of the axis's own value (of 1, where that is 0), or as far
    as the axis goes."""
    levels: tuple[Level, ...] = ()
    """Levels to try in this order, the best first, instead of numbers from `start` to `end`: none,
    or two or more."""
    precision: float = 0.1
    """Width of the final bracket as a share of the level, 0.001..0.5; smaller takes more runs."""
    trackers: Sequence[str | TrackerSpec] = ("default", "paper")
    """The trackers, each searched on its own; see `TrackerSpec.parse`."""
    scene: str = "intersection"
    """Name of the scene."""
    seeds: int = 8
    """Runs per level, 2 or more; more make the interval of the breaking point narrower."""
    first_seed: int = 0
    """First seed; the runs use consecutive seeds."""
    frames: int = 80
    """Frames per run, at 10 Hz; 1 or more."""
    fixed: Mapping[str, Level] = field(default_factory=dict)
    """Levels of other axes, the same in all runs; `axis` may not be among them."""

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
        most = (
            MAX_FIRST_STEPS * step if self.end is None else abs(float(self.end) - float(self.start))
        )
        return Reach(min(step, most), most, self.precision, is_whole)

    def level(self, place: float) -> Level:
        """The level at a place of `reach`."""
        if self.levels:
            return self.levels[int(place)]
        down = self.end is not None and float(self.end) < float(self.start)
        level = float(self.start) + (-place if down else place)
        return int(level) if self.reach.is_whole else level


@dataclass(frozen=True, eq=False)
class BreakingPoint:
    """The result of the search for one tracker."""

    tracker: str
    """The tracker's name."""
    score: Interval
    """The score at the start, over the seeds."""
    level: Level | None
    """The level at which the mean fall over the seeds reaches the drop; None: nowhere up to
    `tried`."""
    low: Level | None
    """Lower end of the level's 95 % interval: the upper end of the fall's interval reaches the drop
    there; None: nowhere up to `tried`."""
    high: Level | None
    """Upper end of the level's 95 % interval: the lower end of the fall's interval reaches the drop
    there; None: nowhere up to `tried`."""
    tried: Level
    """The farthest level that was run."""
    curve: tuple[tuple[Level, Interval, Interval], ...]
    """Per level, from the start on: the level, the score, and its fall paired by seed."""
    failed: int = 0
    """Number of trials with an error."""
    error: str | None = None
    """Message of the first error; None: no trial failed."""

    def lines(self, axis: str, metric: str) -> list[SummaryRow]:
        """The curve as lines of a sweep's summary, for its picture."""
        return [
            SummaryRow(0, {axis: level}, self.tracker, {metric: score}, None, 0, None)
            for level, score, _ in self.curve
        ]


@dataclass(eq=False)
class BreakingPointSearch:
    """The search for one tracker; every level is run once, through the sweep's trial files."""

    question: BreakingPointSpec
    """What is asked, with this tracker alone."""
    contender: TrackerSpec
    """The tracker."""
    folder: Path
    """Folder of the search; the sweep of all tried levels lies in `runs` inside it."""
    jobs: int = 1
    """Processes on this machine; -1: one per core."""
    tell: Telling | None = None
    """Called with the tracker's name and the level before a level is run; None: not called."""
    scores: dict[Level, dict[int, float]] = field(default_factory=dict)
    """The scores that were run, by level, then by seed; failed trials are left out."""
    errors: list[str] = field(default_factory=list)
    """Messages of all failed trials."""

    def run(self) -> BreakingPoint:
        """Search three times, over the levels that earlier searches tried as well."""
        asked = self.question
        self._scores(asked.best)
        middle = self._search(lambda fall: fall.mean)
        first = self._search(lambda fall: fall.high)
        last = self._search(lambda fall: fall.low)
        start = self._interval(self.scores[asked.best])
        curve = tuple(
            (level, self._interval(self.scores[level]), self._fall(level))
            for level in sorted(self.scores, key=self._place)
        )
        return BreakingPoint(
            self.contender.name, start, self._between(middle),
            None if first is None else asked.level(first[0]),
            None if last is None else asked.level(last[1]),
            curve[-1][0], curve, len(self.errors), self.errors[0] if self.errors else None,
        )  # fmt: skip

    def _search(self, end: Callable[[Interval], float | None]) -> tuple[float, float] | None:
        """Where an end of the fall's interval reaches the drop; NaN, of no seed, is no reason."""

        def is_bad(place: float) -> bool:
            reached = end(self._fall(self.question.level(place)))
            return reached is not None and reached >= self.question.drop

        return self._farthest.bracket(is_bad)

    @cached_property
    def _farthest(self) -> Reach:
        """The reach, cut off before the first doubling that the axis refuses."""
        reach = self.question.reach
        if self.question.levels or self.question.end is not None:
            return reach
        place = reach.first
        while place < reach.most:
            try:
                self.question.design(self.question.level(2.0 * place))
            except BadConfig:
                break
            place *= 2.0
        return replace(reach, most=place)

    def _between(self, bracket: tuple[float, float] | None) -> Level | None:
        """The middle of a bracket; its far end where levels are whole."""
        if bracket is None:
            return None
        near, far = bracket
        return self.question.level(far if self.question.reach.is_whole else 0.5 * (near + far))

    def _place(self, level: Level) -> float:
        """How far a level is from the start."""
        if self.question.levels:
            return float(self.question.levels.index(level))
        return abs(float(level) - float(self.question.start))

    def _fall(self, level: Level) -> Interval:
        """What is lost at a level, of the seeds that were finished there and at the start."""
        before, now = self._scores(self.question.best), self._scores(level)
        lost = np.array([before[seed] - now[seed] for seed in now if seed in before])
        return Interval.of(lost, limits_of(self.question.metric, is_difference=True))

    def _interval(self, scores: Mapping[int, float]) -> Interval:
        values = np.array(list(scores.values()), dtype=float)
        return Interval.of(values, limits_of(self.question.metric))

    def _scores(self, level: Level) -> dict[int, float]:
        """The scores at a level, by seed."""
        if level not in self.scores:
            if self.tell is not None:
                self.tell(self.contender.name, level)
            design = self.question.design(level)
            table = sweep(design, self.folder / RUNS_FOLDER, jobs=self.jobs, extend=True)
            rows = table.to_pylist()
            self.errors += [row["error"] for row in rows if row["error"] is not None]
            self.scores[level] = {
                row["seed"]: float(row[self.question.metric])
                for row in rows
                if row["error"] is None
            }
        return self.scores[level]


def breaking_points(
    question: BreakingPointSpec,
    folder: Path | None = None,
    *,
    jobs: int = 1,
    tell: Telling | None = None,
) -> list[BreakingPoint]:
    """The breaking point of every tracker. Levels and trackers share traffic and draws by seed.

    The score is taken to fall on the way; where it does not, one of the places where it crosses
    is found. folder: where finished trials stay, so that a search that was interrupted goes on;
    None: nowhere. Raises as `sweep` does.
    """
    contenders = question.design(question.best).contenders
    with TemporaryDirectory() if folder is None else nullcontext(folder) as place:
        path = Path(place).absolute()
        return [
            BreakingPointSearch(replace(question, trackers=(each,)), each, path, jobs, tell).run()
            for each in contenders
        ]


__all__ = ["BreakingPoint", "BreakingPointSpec", "breaking_points"]
