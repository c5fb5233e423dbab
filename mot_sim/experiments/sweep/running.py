"""A sweep: a design becomes jobs, the jobs become trials, the trials one tidy table."""

import json
import logging
from collections.abc import Callable, Iterator, Mapping
from contextlib import nullcontext
from dataclasses import dataclass, field, fields, replace
from functools import cached_property
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import pyarrow as pa
import pyarrow.parquet as pq

from mot_sim.experiments.executor import Executor, WorkerPool
from mot_sim.experiments.sweep.design import Design, Point, Range
from mot_sim.experiments.sweep.drives import Recordings, truth_key
from mot_sim.experiments.sweep.groups import JobGroup, group_without_lost, grouped, run_group
from mot_sim.experiments.sweep.store import SWEEP_FILE, TABLE_FILE, SweepFolder, TrialOutcome
from mot_sim.experiments.sweep.tracker_specs import TrackerSpec
from mot_sim.experiments.sweep.trial import Job, JobDone, run_job
from mot_sim.files.documents import CONTENT_ERRORS
from mot_sim.files.fingerprint import SWEEP_FORMAT, code_digest, digest
from mot_sim.files.settings import versions
from mot_sim.files.text import read_text
from mot_sim.files.writing import whole_file
from tracker.errors import BadFile, TrackingError, WorkersLost

log = logging.getLogger(__name__)
# Called with what is under way, how much of it is done, and how much there is.
Progress = Callable[[str, int, int], None]


@dataclass(frozen=True)
class Trial:
    """One row of a sweep's table: a point, a seed and a tracker."""

    number: int
    """Place of the point in the design, from 0."""
    point: Point
    """Levels by the axis's name; an axis that is absent keeps its own value."""
    seed: int
    """The seed of the run."""
    contender: TrackerSpec
    """The tracker with the settings of the point."""
    key: str
    """Hash of everything that decides the trial; equal trials share it."""


@dataclass(frozen=True, eq=False)
class SweepPlan:
    """The trials of a design, in the order of the table."""

    design: Design
    """The design."""
    folder: Path
    """The sweep's folder."""
    code: str = field(default_factory=code_digest)
    """Hash of the source code that runs the trials."""
    trials: tuple[Trial, ...] = field(init=False)
    """One trial per point, seed and tracker, in that order."""

    def __post_init__(self) -> None:
        object.__setattr__(self, "trials", tuple(self._trials()))

    def _trials(self) -> Iterator[Trial]:
        """Points, seeds, trackers; the key of each."""
        same = [self.code, self.design.rules, self.design.spatial]
        for number, point in enumerate(self.design.points):
            seen = digest(self.design.conditions[number].description())
            rivals = [(each, digest(each.description())) for each in self.design.rivals(point)]
            for seed in self.design.seed_numbers:
                for rival, does in rivals:
                    yield Trial(number, point, seed, rival, digest([same, seen, does, seed]))

    @cached_property
    def keys(self) -> list[str]:
        """Of all trials; points that come to the same share them."""
        return list(dict.fromkeys(trial.key for trial in self.trials))

    def jobs(self, done: Mapping[str, Any], recordings: Recordings) -> list[Job]:
        """What is left to do: a job a condition and seed, those of one truth together.

        recordings: where traffic and truth are kept.
        """
        wanted: dict[tuple[int, str], list[Trial]] = {}
        planned = set(done)
        for trial in self.trials:
            if trial.key not in planned:
                planned.add(trial.key)
                wanted.setdefault((trial.seed, repr(trial.point)), []).append(trial)
        jobs = [
            Job(
                folder=self.folder,
                code=self.code,
                rules=self.design.rules,
                spatial=self.design.spatial,
                recordings=recordings,
                conditions=self.design.conditions[trials[0].number],
                seed=trials[0].seed,
                trials=tuple((trial.key, trial.contender) for trial in trials),
            )
            for trials in wanted.values()
        ]
        return sorted(jobs, key=lambda job: (job.seed, truth_key(job.conditions, job.seed)))


def truth_jobs(jobs: list[Job]) -> list[Job]:
    """A job for each truth that is not recorded yet."""
    found: dict[Path, Job] = {}
    for job in jobs:
        path = job.recordings.truth_path(job.conditions, job.seed)
        if path not in found and not path.is_file():
            found[path] = replace(job, trials=())
    return list(found.values())


def sweep(
    design: Design,
    folder: Path | str | None = None,
    *,
    jobs: int = 1,
    scheduler: str | None = None,
    extend: bool = False,
    overwrite: bool = False,
    retry: bool = False,
    progress: Progress | None = None,
) -> pa.Table:
    """Run what is missing of a design, and give its table, which `table.parquet` keeps as well.

    A row a point, seed and tracker, in that order: the axes' levels (null: its own value), seed,
    tracker, TrackEval's scores, frames, detections, error (null: none; then there are no scores)
    and cpu_seconds. All but the last are equal to the last bit however the work was spread.
    folder: of this sweep, where it goes on; None: one that is thrown away. jobs, scheduler: see
    `Executor`. extend, overwrite: see `SweepFolder.open`. retry: do failed trials again. progress:
    called as trials are finished. Raises as `SweepFolder.open` and WorkersLost; all that was
    finished by then is kept.
    """
    executor = Executor(jobs, scheduler)
    if folder is None and scheduler is not None:
        raise WorkersLost("a cluster needs a folder that all its workers can write to: give one")
    place = TemporaryDirectory() if folder is None else nullcontext(str(folder))
    with place as name:
        path = Path(name).absolute()
        plan = SweepPlan(design, path)
        kept = SweepFolder.open(path, design.description(), extend=extend, overwrite=overwrite)
        done = kept.finished(plan.keys, failed_too=not retry)
        # (The machines of a cluster share the sweep's folder, and perhaps nothing else.)
        alone = scheduler is None
        todo = plan.jobs(done, Recordings.beside(path) if alone else Recordings(path))
        if todo:
            with executor.open() as pool:
                _run(pool, todo, len(done), len(plan.keys), progress)
            done = kept.finished(plan.keys)
            _require_all(plan, done, path)
            kept.sweep_up()
        table = trials_table(plan, done)
        write_table(path / TABLE_FILE, table)
    return table


def _run(
    pool: WorkerPool, todo: list[Job], before: int, total: int, progress: Progress | None
) -> None:
    """First the truths that several jobs share, then the trials."""
    tell = progress or (lambda what, done, of: None)
    truths = truth_jobs(todo)
    for number, _ in enumerate(pool.run(run_job, truths), 1):
        tell("truth", number, len(truths))
    done, again = before, list[JobGroup]()

    def give_up(group: JobGroup) -> JobDone:
        lost, rest = group_without_lost(group)
        again.extend(rest)
        return lost

    tell("trials", done, total)
    groups = grouped(todo, pool.processes)
    while groups:
        for _, job in pool.run(run_group, groups, give_up):
            done += job.trials
            tell("trials", done, total)
            for who, said in job.said:
                for line in said.splitlines():
                    log.info("%s: %s", who, line)
        groups, again = again, []


def _require_all(plan: SweepPlan, done: Mapping[str, TrialOutcome], folder: Path) -> None:
    """Raise WorkersLost for trials that workers wrote where we cannot see them."""
    lacking = sum(key not in done for key in plan.keys)
    if lacking:
        raise WorkersLost(
            f"{lacking} of {len(plan.keys)} trials are not in {folder}: all workers must see that "
            "folder under the same path (a shared disk)"
        )


def trials_table(plan: SweepPlan, done: Mapping[str, TrialOutcome]) -> pa.Table:
    """The table of a sweep's finished trials; done: the outcomes by key."""
    trials = [trial for trial in plan.trials if trial.key in done]
    outcomes = [done[trial.key] for trial in trials]
    columns: dict[str, pa.Array] = {"point": pa.array([trial.number for trial in trials])}
    for axis in plan.design.axes:
        columns[axis] = pa.array([trial.point.get(axis) for trial in trials])
    columns["seed"] = pa.array([trial.seed for trial in trials])
    columns["tracker"] = pa.array([trial.contender.name for trial in trials])
    names = list(dict.fromkeys(name for outcome in outcomes for name in outcome.scores))
    for name in names:
        columns[name] = pa.array([outcome.scores.get(name) for outcome in outcomes])
    columns["frames"] = pa.array([outcome.frames for outcome in outcomes])
    columns["detections"] = pa.array([outcome.detections for outcome in outcomes])
    columns["error"] = pa.array([outcome.error for outcome in outcomes], pa.string())
    columns["cpu_seconds"] = pa.array([outcome.cpu_seconds for outcome in outcomes])
    about = {"design": plan.design.description(), "code": plan.code, "versions": versions()}
    return pa.table(columns).replace_schema_metadata({"mot-sim sweep": json.dumps(about)})


def write_table(path: Path, table: pa.Table) -> None:
    """The table as Parquet, as a whole or not at all."""
    with whole_file(path) as half:
        pq.write_table(table, half)


@dataclass(frozen=True, eq=False)
class PartialSweep:
    """What a folder holds of a sweep that may be unfinished."""

    table: pa.Table | None
    """The table of the finished trials; None: none is finished."""
    done: int
    """Number of finished trials."""
    wanted: int
    """Number of trials of the whole design."""
    description: Mapping[str, Any]
    """The design in plain values, as `sweep.json` has it."""
    code: str
    """Hash of the source code that ran it, as `sweep.json` has it."""
    versions: dict[str, str]
    """Versions of Python and of the packages by name, as `sweep.json` has them."""


def read_partial(folder: Path) -> PartialSweep:
    """Of the design in `sweep.json`, whatever is finished in `trials/`.

    Raises BadFile for a damaged `sweep.json`, for another format, and for a design that this
    mot-sim cannot understand (a tracker of somebody's own that is not to be found here).
    """
    file = folder / SWEEP_FILE
    try:
        about = json.loads(read_text(file))
        form, code = about["format"], str(about["code"])
        versions = {str(name): str(each) for name, each in about["versions"].items()}
        description = dict(about["design"])
    except CONTENT_ERRORS as error:
        raise BadFile(f"{file}: no sweep of ours: {error!r:.120}") from None
    if form != SWEEP_FORMAT:
        raise BadFile(f"{file}: a sweep of format {form!r:.20}, this mot-sim reads {SWEEP_FORMAT}")
    try:
        plan = SweepPlan(_design(description), folder, code)
    except (TrackingError, *CONTENT_ERRORS) as error:
        raise BadFile(
            f"{file}: its design cannot be understood here: {str(error)[:200]}; run its command "
            "again where it was made, then report"
        ) from None
    found = SweepFolder(folder).finished(plan.keys)
    done = sum(trial.key in found for trial in plan.trials)
    table = trials_table(plan, found) if done else None
    return PartialSweep(table, done, len(plan.trials), description, code, versions)


def _design(description: Mapping[str, Any]) -> Design:
    """The design that a description is of."""
    known = {each.name for each in fields(Design)}
    given = {name: value for name, value in description.items() if name in known}
    given["axes"] = {
        axis: Range(levels["low"], levels["high"], levels["log"])
        if isinstance(levels, Mapping)
        else tuple(levels)
        for axis, levels in description["axes"].items()
    }
    given["trackers"] = tuple(
        TrackerSpec(
            name, each["made_by"], {key: each[key] for key in each if key != "made_by"}
        )
        for name, each in description["trackers"].items()
    )  # fmt: skip
    return Design(**given)
