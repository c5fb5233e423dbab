"""What weight vectors are worth on each drive: tracked and scored in parallel, and kept."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from mot_sim.evaluation.runs import track_sequence
from mot_sim.experiments.executor import Executor
from mot_sim.experiments.score_cache import ScoreCache
from mot_sim.experiments.sweep.tracker_specs import TrackerSpec
from mot_sim.experiments.tuning.labelled import LabelledSequence
from mot_sim.experiments.tuning.pair_costs import Checked, PairCosts
from mot_sim.files.fingerprint import code_digest, digest
from mot_sim.files.named_objects import COST_NAMES
from mot_sim.metrics import Scores, evaluate_sequence
from tracker import Delayed, Tracker
from tracker.costs import Cost
from tracker.errors import BadConfig

# Called with how many weight vectors are done, and of how many.
Progress = Callable[[int, int], None]

# One weight a cost, in thousandths: whole numbers, so that equal vectors are equal.
Weights = tuple[int, ...]
WEIGHT_SUM = 1000


def weights_of(values: Sequence[float]) -> Weights:
    """The nearest weights in thousandths that sum up to 1000.

    Raises BadConfig for weights that are negative, not finite, or all zero.
    """
    given = np.array(values, float)
    if not np.isfinite(given).all() or (given < 0.0).any() or not given.sum() > 0.0:
        raise BadConfig(
            f"weights {[float(f'{each:g}') for each in values]}: give finite numbers, none below "
            "0 and not all of them 0"
        )
    exact = WEIGHT_SUM * given / given.sum()
    rounded = np.floor(exact).astype(np.int64)
    most_cut = np.argsort(rounded - exact, kind="stable")[: WEIGHT_SUM - int(rounded.sum())]
    rounded[most_cut] += 1
    return tuple(rounded.tolist())


@dataclass(frozen=True)
class Method:
    """The tracker whose costs are weighed. Raises UnknownName and BadConfig for wrong names."""

    names: tuple[str, ...]
    """Names of the costs, each once, at least one."""
    contender: TrackerSpec = TrackerSpec("default")
    """The tracker, one of TRACKERS; its own costs are replaced."""

    def __post_init__(self) -> None:
        for name in self.names:
            COST_NAMES.make(name, Cost)
        if not self.names or len(set(self.names)) < len(self.names):
            raise BadConfig(f"costs {', '.join(self.names) or '(none)'}: name each once")
        if not self.contender.is_ours:
            raise BadConfig(
                f"tracker {self.contender.made_by}: only ours have weights: default, paper"
            )

    def build(self, drive: LabelledSequence, weights: Weights) -> Tracker | Delayed:
        """The tracker for a drive, its costs checked as they come."""
        made: Any = self.contender.build(drive.sequence.camera)
        costs = tuple(
            (weight / WEIGHT_SUM, Checked(name, COST_NAMES.make(name, Cost)))
            for name, weight in zip(self.names, weights, strict=True)
            if weight > 0
        )
        if isinstance(made, Tracker):
            return replace(made, costs=costs)
        return replace(made, tracker=replace(made.tracker, costs=costs))

    def pair_costs(self, drive: LabelledSequence) -> PairCosts | None:
        """The costs of all pairs, where they do not hang on the weights."""
        tracker = self.build(drive, tuple(1 for _ in self.names))
        if not isinstance(tracker, Tracker):
            return None
        return PairCosts.of(tracker, drive.sequence)


def score(
    method: Method, drive: LabelledSequence, cached: PairCosts | None, weights: Weights, rules: str
) -> Scores:
    """The scores of one drive by these weights."""
    if cached is not None:
        rows = cached.track(tuple(each / WEIGHT_SUM for each in weights))
    else:
        rows, _ = track_sequence(method.build(drive, weights), drive.sequence)
    return evaluate_sequence(drive.truth, rows, drive.frame_count, rules)


@dataclass(frozen=True, eq=False)
class _Batch:
    """A worker's task: several weight vectors on one drive."""

    method: Method
    drive: LabelledSequence
    cached: PairCosts | None
    batch: Sequence[Weights]
    rules: str

    def scores(self) -> list[Scores]:
        return [
            score(self.method, self.drive, self.cached, weights, self.rules)
            for weights in self.batch
        ]


@dataclass(eq=False)
class Scale:
    """Scores weight vectors on all drives, and keeps what was scored."""

    method: Method
    """The tracker and the names of its costs."""
    drives: tuple[LabelledSequence, ...]
    """The drives that every vector is scored on."""
    rules: str = "trackeval"
    """Rules of scoring, one of `mot_sim.metrics.RULES`."""
    kept: ScoreCache | None = None
    """Where scores are read from and written to; None: only in memory."""
    jobs: int = 1
    """Processes that the drives are spread over; 1: this process, -1: one per core."""
    known: dict[Weights, dict[str, Scores]] = field(default_factory=dict)
    """Scores by weight vector, then by the drive's name."""
    fresh: int = 0
    """Number of vectors that were scored anew, not read from `kept`."""
    cached: dict[str, PairCosts | None] = field(default_factory=dict)
    """The pairs' costs by the drive's name; None where they depend on the weights."""

    def __post_init__(self) -> None:
        self.executor = Executor(self.jobs)

    @classmethod
    def of(
        cls,
        method: Method,
        drives: Sequence[LabelledSequence],
        rules: str = "trackeval",
        folder: Path | None = None,
        jobs: int = 1,
    ) -> "Scale":
        """A scale whose log lies in a folder. Raises MissingCue for a cost without its cue."""
        kept = None if folder is None else ScoreCache(folder / "weights")
        return cls(method, tuple(drives), rules, kept, jobs)

    def key(self, weights: Weights) -> str:
        """The hash of all that decides what these weights are worth."""
        costs = dict(zip(self.method.names, weights, strict=True))
        does = self.method.contender.description()
        sources = [COST_NAMES.source(name) for name in self.method.names]
        return digest([code_digest(), self.rules, self._content, does, costs, sources])

    def weigh(self, wanted: Sequence[Weights], tell: Progress | None = None) -> None:
        """Make sure that all of these are known; each is kept as soon as it is."""
        lacking = [each for each in dict.fromkeys(wanted) if not self._find(each)]
        say = tell or (lambda done, total: None)
        done = len(wanted) - len(lacking)
        say(done, len(wanted))
        for batch, columns in self._in_batches(lacking):
            for place, weights in enumerate(batch):
                scores = {
                    drive.name: column[place]
                    for drive, column in zip(self.drives, columns, strict=True)
                }
                self.known[weights] = scores
                if self.kept is not None:
                    about = dict(zip(self.method.names, weights, strict=True))
                    self.kept.write(self.key(weights), scores, about)
            self.fresh += len(batch)
            done += len(batch)
            say(done, len(wanted))

    def _find(self, weights: Weights) -> bool:
        """Whether these are known, or stand in the log."""
        if weights not in self.known and self.kept is not None:
            found = self.kept.read(self.key(weights))
            if found is not None and found.keys() == {drive.name for drive in self.drives}:
                self.known[weights] = found
        return weights in self.known

    def _in_batches(
        self, lacking: Sequence[Weights]
    ) -> Iterator[tuple[Sequence[Weights], list[list[Scores]]]]:
        """A few vectors at a time, on all drives."""
        if not lacking:
            return
        self._prepare()
        size = 1 if self.jobs == 1 else 8
        with self.executor.open() as pool:
            for first in range(0, len(lacking), size):
                batch = lacking[first : first + size]
                tasks = [
                    _Batch(self.method, drive, self.cached[drive.name], batch, self.rules)
                    for drive in self.drives
                ]
                yield batch, pool.run_in_order(_Batch.scores, tasks)

    def _prepare(self) -> None:
        """The pair costs of every drive, once."""
        for drive in self.drives:
            if drive.name not in self.cached:
                self.cached[drive.name] = self.method.pair_costs(drive)

    @property
    def _content(self) -> list[str]:
        return [drive.content for drive in self.drives]
