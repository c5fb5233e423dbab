"""Stress tests: named suites, each a hard situation and the scores that must be reached in it."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, fields
from math import ceil, floor, isfinite
from pathlib import Path
from typing import Any

from mot_sim.experiments.sweep.bounds import Bound, bounds_of
from mot_sim.experiments.sweep.conditions import Conditions
from mot_sim.experiments.sweep.design import Design
from mot_sim.experiments.sweep.paths import Level
from mot_sim.experiments.sweep.running import Progress, sweep
from mot_sim.experiments.sweep.summary import INTERVAL_NOTE, summary
from mot_sim.experiments.sweep.tracker_specs import TrackerSpec
from mot_sim.files.documents import read_toml, require_inside
from mot_sim.files.named_objects import NameRegister
from mot_sim.tables import (
    NO_INTERVAL,
    Column,
    Interval,
    Table,
    few_seeds_note,
    is_count,
    with_ends,
)
from tracker.errors import BadConfig, BadFile, UnknownName

SUITES = Path(__file__).with_name("suites.toml")
SEEDS = 8  # that the bounds were measured on
MEASURED_METRICS = ("HOTA", "IDF1", "MOTA", "IDSW")
# Least margins between what was measured and its bound, and what bounds are rounded to.
RATE_MARGIN, RATE_STEP = 0.02, 0.01
COUNT_MARGIN, COUNT_STEP = 1.0, 0.1
RUNS = "runs"  # the sweep's folder inside that of the stress test


@dataclass(frozen=True)
class Suite:
    """A hard situation, and the scores that must be reached in it."""

    name: str
    """Its name on the command line."""
    about: str
    """What is hard in it, in words."""
    scene: str
    """Name of the scene."""
    frames: int
    """Frames per run, at 10 Hz; 1 or more."""
    bounds: tuple[Bound, ...]
    """What the means over the seeds must reach; at least one."""
    settings: Mapping[str, Level] = field(default_factory=dict)
    """Levels of a sweep's axes, by name; all other axes keep their own values."""

    def design(
        self, trackers: Sequence[str | TrackerSpec], seeds: int = SEEDS, first_seed: int = 0
    ) -> Design:
        """The sweep with one point that runs it."""
        return Design(
            axes={"scene.profile": (str(self.settings.get("scene.profile", "rrc")),)},
            trackers=trackers,
            scene=self.scene,
            seeds=seeds,
            first_seed=first_seed,
            frames=self.frames,
            spatial=any(bound.is_spatial for bound in self.bounds),
            fixed={axis: at for axis, at in self.settings.items() if axis != "scene.profile"},
        )


@dataclass(frozen=True)
class Verdict:
    """Whether a tracker met one bound of a suite; one with a failed trial never does."""

    suite: str
    """The suite's name."""
    tracker: str
    """The tracker's name."""
    bound: Bound
    """What must be reached."""
    reached: Interval
    """The mean over the seeds with its 95 % interval."""
    failed: int = 0
    """Number of trials with an error."""
    error: str | None = None
    """Message of the first error; None: no trial failed."""

    @property
    def passed(self) -> bool:
        """Whether the mean meets the bound, and every trial was finished."""
        mean = self.reached.mean
        return self.failed == 0 and mean is not None and self.bound.holds(mean)


def read_suites(path: Path = SUITES) -> dict[str, Suite]:
    """The suites of a TOML file by name. Raises BadFile, UnknownName and BadConfig."""
    content = read_toml(path, "no suites can be read")
    return {name: _suite(name, table, path) for name, table in content.items()}


def _suite(name: str, table: Any, path: Path) -> Suite:
    """A suite from its table."""
    where = f"{path}: suite {name}"
    if not isinstance(table, dict):
        raise BadFile(f"{where}: {table!r} is no table: write [{name}]")
    known = {"about": str, "scene": str, "frames": int, "settings": dict, "bounds": dict}
    for key in table:
        if key not in known:
            raise UnknownName.of(f"entry of {where}:", key, known)
    given = {"settings": {}, **table}
    for key, kind in known.items():
        if type(given.get(key)) is not kind:
            raise BadFile(f"{where}: {key} = {given.get(key)!r}: give a {kind.__name__}")
    for key, kinds in {"settings": int | float | str, "bounds": int | float}.items():
        for name_of, value in given[key].items():
            if not isinstance(value, kinds):
                raise BadFile(f"{where}: {key}: {name_of} = {value!r}: give one value")
            if isinstance(value, str) and value.endswith(".toml"):
                require_inside(value, where, path.parent, Path.cwd())
    if given["frames"] < 1:
        raise BadFile(f"{where}: frames = {given['frames']}: give 1 or more")
    try:
        bounds = bounds_of(given.pop("bounds"))
    except (BadConfig, UnknownName) as error:
        raise BadFile(f"{where}: bounds: {error}") from None
    return Suite(name=name, bounds=bounds, **given)


def suite_names(known: Mapping[str, Suite]) -> NameRegister:
    """These suites, and what else a suite can be named by."""
    return NameRegister("suite", known, "mot_sim.suites", "suite")


def find_suites(names: Sequence[str], known: Mapping[str, Suite]) -> list[Suite]:
    """The suites of these names; all of the known ones for no name.

    A name is a known one, one of an installed package, or `module:name` of a Suite, of what gives
    one, or of the Path of a TOML file: that stands for its suite of the name, or for all that it
    holds. Raises UnknownName, and BadConfig for what is no suite.
    """
    found: list[Suite] = []
    register = suite_names(known)
    for name in names or known:
        named = register.find(name)
        if isinstance(named, Path):
            inside = read_suites(named)
            found += [inside[name]] if name in inside else inside.values()
        else:
            found.append(named if isinstance(named, Suite) else register.make(name, Suite))
    twice = sorted(
        {each.name for each in found if [one.name for one in found].count(each.name) > 1}
    )
    if twice:
        raise BadConfig(f"suite {twice[0]} is there twice: its lines could not be told apart")
    return found


def stress(
    suite: Suite,
    trackers: Sequence[str | TrackerSpec] = ("default",),
    folder: Path | None = None,
    *,
    seeds: int = SEEDS,
    first_seed: int = 0,
    jobs: int = 1,
    progress: Progress | None = None,
) -> list[Verdict]:
    """Run a suite: a verdict a tracker and bound, in the order of the trackers.

    folder: where finished trials stay, for many suites together; None: nowhere. Raises as
    `sweep` does.
    """
    try:
        Conditions.of(suite.scene, suite.settings)
    except (BadConfig, UnknownName) as error:
        raise BadConfig(f"suite {suite.name}: {error}") from None
    design = suite.design(trackers, seeds, first_seed)
    place = None if folder is None else folder / RUNS
    table = sweep(design, place, jobs=jobs, extend=place is not None, progress=progress)
    lines = summary(table, [bound.metric for bound in suite.bounds])
    return [
        Verdict(
            suite.name, line.tracker, bound,
            line.metrics.get(bound.metric, NO_INTERVAL),
            line.failed, line.first_error,
        )
        for line in lines
        for bound in suite.bounds
    ]  # fmt: skip


def measured(suite: Suite, metrics: Sequence[str] = MEASURED_METRICS) -> Suite:
    """The suite with other metrics and no real bounds: for what they come to.

    One with bounds on cuboids keeps its own metrics.
    """
    own = [bound.metric for bound in suite.bounds]
    is_spatial = any(bound.is_spatial for bound in suite.bounds)
    bounds = tuple(Bound(name, float("-inf")) for name in (own if is_spatial else metrics))
    given = {each.name: getattr(suite, each.name) for each in fields(suite)}
    return Suite(**{**given, "bounds": bounds})


def bound_from(metric: str, reached: Interval) -> Bound | None:
    """The bound that the rule of `suites.toml` takes from a measurement; None: from too few seeds.

    The margin is half of the interval, but never less than the least margin.
    """
    if reached.mean is None or reached.half is None:
        return None
    margin, step = (COUNT_MARGIN, COUNT_STEP) if is_count(metric) else (RATE_MARGIN, RATE_STEP)
    margin = max(reached.half, margin)
    if Bound(metric, 0.0).is_upper:
        return Bound(metric, round(ceil((reached.mean + margin) / step) * step, 6))
    return Bound(metric, round(floor((reached.mean - margin) / step) * step, 6))


def verdict_table(verdicts: Sequence[Verdict]) -> Table:
    """A row a suite, tracker and bound: what was reached, and whether that is enough."""
    columns = (
        Column.named("suite", "name"), Column.named("tracker", "name"), "metric", "must be",
        "bound", *with_ends("reached"), "seeds", "verdict", "failed", "error",
    )  # fmt: skip
    rows = [
        (
            each.suite, each.tracker, each.bound.metric, each.bound.word,
            each.bound.value if isfinite(each.bound.value) else None, *each.reached.cells,
            each.reached.count, _passed(each), each.failed, each.error,
        )
        for each in verdicts
    ]  # fmt: skip
    note = f"{INTERVAL_NOTE} {few_seeds_note(each.reached.count for each in verdicts)}".strip()
    return Table.of("verdicts", "Bounds and what was reached", columns, rows, note)


def _passed(verdict: Verdict) -> str | None:
    """Pass or fail; None where nothing was asked for, as when bounds are measured."""
    if not isfinite(verdict.bound.value):
        return None
    return "pass" if verdict.passed else "FAIL"


def suite_table(suites: Sequence[Suite]) -> Table:
    """What is hard in each suite, and how it is set up."""
    rows = [
        (
            each.name, each.about, each.scene, each.frames,
            ", ".join(f"{name}={value}" for name, value in each.settings.items()),
        )
        for each in suites
    ]  # fmt: skip
    columns = ("suite", "what is hard", "scene", "frames", "settings")
    return Table.of("suites", "The suites", columns, rows)


def bound_table(suites: Sequence[Suite]) -> Table:
    """The suites, what is hard in them, and their bounds in words."""
    rows = tuple(
        (
            suite.name, suite.about,
            ", ".join(
                f"{each.metric} {each.word} {score_word(each.metric, each.value)}"
                for each in suite.bounds
            ),
        )
        for suite in suites
    )  # fmt: skip
    return Table((Column("suite", "name"), Column("what is hard"), Column("bounds")), rows)


def score_word(metric: str, value: float) -> str:
    """A rate with three digits, a count with one."""
    return f"{value:.1f}" if is_count(metric) else f"{value:.3f}"


def verdict_content(verdicts: Sequence[Verdict]) -> Iterator[dict[str, Any]]:
    """The verdicts in plain values, ready for JSON."""
    for each in verdicts:
        yield {
            "suite": each.suite, "tracker": each.tracker, "passed": each.passed,
            "metric": each.bound.metric, "bound": each.bound.value, "kind": each.bound.word,
            **vars(each.reached), "failed": each.failed, "error": each.error,
        }  # fmt: skip
