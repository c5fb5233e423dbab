"""Breaking points: the level of an axis at which a tracker has lost so much of a score."""

from collections.abc import Callable, Mapping
from contextlib import nullcontext
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from mot_sim.experiments.stress.bisection import Reach
from mot_sim.experiments.stress.breaking_point_spec import BreakingPointSpec
from mot_sim.experiments.sweep.paths import Level
from mot_sim.experiments.sweep.running import sweep
from mot_sim.experiments.sweep.summary import SummaryRow
from mot_sim.experiments.sweep.tracker_specs import TrackerSpec
from mot_sim.tables import Interval, limits_of
from tracker.errors import BadConfig

RUNS = "runs"  # the sweep's folder inside that of a search

# Called with a tracker's name and the level that it is tried at.
Telling = Callable[[str, Level], None]


@dataclass(frozen=True, eq=False)
class BreakingPoint:
    """What came of the search for one tracker.

    level: at which the mean of the fall over the seeds reaches the drop; None: nowhere up to
    `tried`, the farthest level. low, high: ends of the level's 95 % interval: where the upper,
    and where the lower end of the fall's interval reaches it; None: nowhere up to `tried`.
    score: at the start. curve: by level, the score and its fall, seed by seed. failed: trials
    with an error; error: of the first.
    """

    tracker: str
    score: Interval
    level: Level | None
    low: Level | None
    high: Level | None
    tried: Level
    curve: tuple[tuple[Level, Interval, Interval], ...]
    failed: int = 0
    error: str | None = None

    def lines(self, axis: str, metric: str) -> list[SummaryRow]:
        """The curve as lines of a sweep's summary, for its picture."""
        return [
            SummaryRow(0, {axis: level}, self.tracker, {metric: score}, None, 0, None)
            for level, score, _ in self.curve
        ]


@dataclass(eq=False)
class BreakingPointSearch:
    """The search for one tracker; every level is run once, through the sweep's trial files.

    question: with this tracker alone.
    """

    question: BreakingPointSpec
    contender: TrackerSpec
    folder: Path
    jobs: int = 1
    tell: Telling | None = None
    scores: dict[Level, dict[int, float]] = field(default_factory=dict)  # level: seed: score
    errors: list[str] = field(default_factory=list)

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
            table = sweep(design, self.folder / RUNS, jobs=self.jobs, extend=True)
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
