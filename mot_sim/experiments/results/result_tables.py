"""What the experiments found, as the plain tables of a `result.json`."""

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from math import isfinite
from typing import TYPE_CHECKING, Any

import pyarrow as pa

from mot_sim.experiments.results.result_file import Cell, ResultTable
from mot_sim.experiments.results.shown_tables import ends, plain, result_table
from mot_sim.experiments.sweep.summary import METRICS, Interval, SummaryRow

if TYPE_CHECKING:
    import mot_sim.experiments.guests
    import mot_sim.experiments.stress.breaking_point
    import mot_sim.experiments.stress.suites
    import mot_sim.experiments.tuning.cross_validation

INTERVAL_NOTE = (
    "Means over seeds with their 95 % intervals (Student's t); rates are fractions in the file."
)


def spread(interval: Interval | None) -> tuple[Cell, ...]:
    """The values of those columns."""
    return (None,) * 3 if interval is None else (interval.mean, interval.low, interval.high)


def means(lines: Sequence[SummaryRow], metrics: Sequence[str] = METRICS) -> ResultTable:
    """A row a point and tracker: levels by axis (None: its own value), scores, seeds, failures."""
    return _of_lines(
        "means", "Scores", lines, metrics, lambda line: line.metrics, with_failures=True
    )


def differences(
    lines: Sequence[SummaryRow], metrics: Sequence[str] = METRICS
) -> ResultTable | None:
    """The differences to the first tracker, paired by seed; None where there is only one."""
    others = [line for line in lines if line.less is not None]
    if not others:
        return None
    first = next((line.tracker for line in lines if line.less is None), "the first tracker")
    title = f"Differences to {first}, seed by seed"
    return _of_lines("differences", title, others, metrics, lambda line: line.less or {})


def _of_lines(
    name: str, title: str, lines: Sequence[SummaryRow], metrics: Sequence[str], scores: Any,
    with_failures: bool = False,
) -> ResultTable:  # fmt: skip
    """A row a line, with the intervals that `scores` gives of it."""
    there = [each for each in metrics if each in scores(lines[0])]
    columns = (
        *lines[0].levels, "tracker", *(column for each in there for column in ends(each)), "seeds",
    )  # fmt: skip
    rows: list[tuple[Cell, ...]] = []
    for line in lines:
        found = scores(line)
        values = (cell for each in there for cell in spread(found.get(each)))
        count = max((each.count for each in found.values()), default=0)
        rows.append((*line.levels.values(), line.tracker, *values, count))
    if with_failures:
        columns = (*columns, "failed")
        rows = [(*row, line.failed) for row, line in zip(rows, lines, strict=True)]
    return ResultTable(name, title, columns, tuple(rows), INTERVAL_NOTE)


def failures(table: pa.Table) -> ResultTable | None:
    """Each different error, its tracker, and how often it came; None where nothing failed."""
    rows = table.select(["tracker", "error"]).to_pylist()
    counted = Counter((row["tracker"], row["error"]) for row in rows if row["error"] is not None)
    if not counted:
        return None
    found = tuple((tracker, count, error) for (tracker, error), count in counted.most_common())
    return ResultTable("failures", "Trials that failed", ("tracker", "trials", "error"), found)


def design_table(design: Mapping[str, Any]) -> ResultTable:
    """The settings of a sweep, from `Design.description()`."""
    plain = ("scene", "frames", "seeds", "first_seed", "mode", "samples", "rules")
    rows: list[tuple[Cell, ...]] = [
        (name.replace("_", " "), design[name]) for name in plain if design.get(name)
    ]
    for axis, levels in design["axes"].items():
        told = (
            f"{levels['low']:g} to {levels['high']:g}"
            if isinstance(levels, Mapping)
            else ", ".join(f"{each:g}" if isinstance(each, float) else str(each) for each in levels)
        )
        rows.append((f"axis {axis}", told))
    rows += [(f"fixed {axis}", level) for axis, level in design["fixed"].items()]
    for name, settings in design["trackers"].items():
        told = _settings({key: settings[key] for key in settings if key != "made_by"})
        rows.append((f"tracker {name}", f"{settings['made_by']}{told and ': ' + told}"))
    return ResultTable("design", "What was run", ("setting", "value"), tuple(rows))


def sweep_tables(table: pa.Table, lines: Sequence[SummaryRow], design: Mapping[str, Any]) -> Any:
    """The tables of a sweep: means, differences, failures, and the design."""
    found = (means(lines), differences(lines), failures(table), design_table(design))
    return tuple(each for each in found if each is not None)


def verdicts(given: "Sequence[mot_sim.experiments.stress.suites.Verdict]") -> ResultTable:
    """A row a suite, tracker and bound: what was reached, and whether that is enough."""
    columns = (
        "suite", "tracker", "metric", "must be", "bound", *ends("reached"), "seeds", "verdict",
        "failed", "error",
    )  # fmt: skip
    rows = tuple(
        (
            each.suite, each.tracker, each.bound.metric, each.bound.word,
            each.bound.value if isfinite(each.bound.value) else None, *spread(each.reached),
            each.reached.count, _passed(each), each.failed, each.error,
        )
        for each in given
    )  # fmt: skip
    return ResultTable("verdicts", "Bounds and what was reached", columns, rows, INTERVAL_NOTE)


def _passed(verdict: "mot_sim.experiments.stress.suites.Verdict") -> str | None:
    """Pass or fail; None where nothing was asked for, as when bounds are measured."""
    if not isfinite(verdict.bound.value):
        return None
    return "pass" if verdict.passed else "FAIL"


def suite_table(suites: "Sequence[mot_sim.experiments.stress.suites.Suite]") -> ResultTable:
    """What is hard in each suite, and how it is set up."""
    rows = tuple(
        (each.name, each.about, each.scene, each.frames, _settings(each.settings))
        for each in suites
    )
    columns = ("suite", "what is hard", "scene", "frames", "settings")
    return ResultTable("suites", "The suites", columns, rows)


def _settings(settings: Mapping[str, Any]) -> str:
    return ", ".join(f"{name}={value}" for name, value in settings.items())


def breaking_tables(
    axis: str,
    metric: str,
    drop: float,
    points: "Sequence[mot_sim.experiments.stress.breaking_point.BreakingPoint]",
) -> tuple[ResultTable, ...]:
    """The points, a row a tracker, and the curves that they were found on."""
    found = tuple(
        (
            each.tracker, *spread(each.score), *(each.level, each.low, each.high), each.tried,
            len(each.curve), each.score.count, each.failed, each.error,
        )
        for each in points
    )  # fmt: skip
    about = (
        "tracker", *ends(metric), *ends("level"), "farthest tried", "levels", "seeds", "failed",
        "error",
    )  # fmt: skip
    told = f"Levels of {axis} that cost {100.0 * drop:g} points of {metric}"
    note = "No level: the drop was not reached up to the farthest level that was tried."
    curve = tuple(
        (level, each.tracker, *spread(score), *spread(fall), score.count)
        for each in points
        for level, score, fall in each.curve
    )
    columns = (axis, "tracker", *ends(metric), *ends("fall"), "seeds")
    return (
        ResultTable("points", told, about, found, note),
        ResultTable("curves", f"{metric} over {axis}", columns, curve, INTERVAL_NOTE),
    )


def contest_tables(contest: "mot_sim.experiments.guests.Comparison") -> Iterator[ResultTable]:
    """The trackers side by side; those that failed, and why; the scores of every drive."""
    yield result_table("scores", contest.table("All drives together"))
    if contest.failures:
        rows = tuple((name, each.reason, each.stderr) for name, each in contest.failures.items())
        yield ResultTable("failures", "Trackers that failed", ("tracker", "reason", "stderr"), rows)
    names = ("MOTA", "HOTA", "AssA", "IDF1", "CLR_FP", "CLR_FN", "IDSW", "Frag")
    found: list[tuple[Cell, ...]] = []
    for tracker, each in contest.entries.items():
        if tracker in contest.failures:
            continue
        for drive, scores in each.evaluation.sequences.items():  # type: ignore[union-attr]
            numbers = scores.numbers()
            found.append((drive, tracker, *(plain(numbers.get(name)) for name in names)))
    yield ResultTable("drives", "Drive by drive", ("drive", "tracker", *names), tuple(found))


def tuned_tables(
    tuned: "mot_sim.experiments.tuning.cross_validation.Tuned", objective: str, whole: float
) -> tuple[ResultTable, ...]:
    """The weights, what they are worth, and the folds; whole: what weights add up to."""
    weights = tuple(
        (name, weight / whole, float(spread))
        for name, weight, spread in zip(tuned.names, tuned.weights, tuned.spread, strict=True)
    )
    worth: tuple[tuple[Cell, ...], ...] = (
        ("the weights to begin with, all drives", tuned.start),
        ("the mean weights, all drives", tuned.overall),
        ("weights that were chosen without the drive", tuned.held_out),
    )
    folds: tuple[tuple[Cell, ...], ...] = tuple(
        (
            " ".join(fold.held), fold.train, fold.held_out, fold.switches,
            *(weight / whole for weight in fold.weights),
        )
        for fold in tuned.folds
    )  # fmt: skip
    columns = (
        "held out", f"{objective} of the others", f"{objective} held out", "IDSW",
        *(f"weight of {name}" for name in tuned.names),
    )  # fmt: skip
    return (
        ResultTable("weights", "Weights of the costs", ("cost", "weight", "std of folds"), weights),
        ResultTable("worth", f"{objective} by these weights", ("weights", objective), worth),
        ResultTable("folds", "Fold by fold", columns, folds),
    )
