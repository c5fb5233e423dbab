"""Breaking points as tables: for files and pictures, for the terminal, and as plain values."""

from collections.abc import Sequence
from typing import Any

from mot_sim.experiments.stress.breaking_point import BreakingPoint, BreakingPointSpec
from mot_sim.experiments.sweep.paths import Level
from mot_sim.experiments.sweep.summary import INTERVAL_NOTE
from mot_sim.tables import Column, Table, few_seeds_note, mean_column, with_ends


def breaking_tables(
    question: BreakingPointSpec, points: Sequence[BreakingPoint]
) -> tuple[Table, Table]:
    """The points, a row a tracker, and the curves that they were found on."""
    found = [
        (
            each.tracker, *each.score.cells, *(each.level, each.low, each.high), each.tried,
            len(each.curve), each.score.count, each.failed, each.error,
        )
        for each in points
    ]  # fmt: skip
    tracker = Column.named("tracker", "name")
    about = (
        tracker, *with_ends(question.metric), *with_ends("level"), "farthest tried", "levels",
        "seeds", "failed", "error",
    )  # fmt: skip
    told = f"Levels of {question.axis} that cost {_drop(question)}"
    few = few_seeds_note(each.score.count for each in points)
    note = "No level: the drop was not reached up to the farthest level that was tried."
    curve = [
        (level, each.tracker, *score.cells, *fall.cells, score.count)
        for each in points
        for level, score, fall in each.curve
    ]
    columns = (question.axis, tracker, *with_ends(question.metric), *with_ends("fall"), "seeds")
    return (
        Table.of("points", told, about, found, f"{note} {few}".strip()),
        Table.of(
            "curves", f"{question.metric} over {question.axis}", columns, curve,
            f"{INTERVAL_NOTE} {few}".strip(),
        ),
    )  # fmt: skip


def breaking_table(question: BreakingPointSpec, points: Sequence[BreakingPoint]) -> Table:
    """A row a tracker: its score where nothing is wrong, and the level that costs the drop."""
    score = mean_column(question.metric, f"{question.metric} at {_word(question.best)}")
    columns = (
        Column("tracker", "name"), *with_ends(score), Column("breaks at", "value"),
        Column("95 % interval", "value"), *map(Column.named, ("levels", "seeds", "failed")),
    )  # fmt: skip
    rows = tuple(
        (
            each.tracker, *each.score.cells, _level(each.level, each.tried),
            f"{_level(each.low, each.tried)} to {_level(each.high, each.tried)}",
            len(each.curve), each.score.count, each.failed or None,
        )
        for each in points
    )  # fmt: skip
    title = (
        f"level of {question.axis} that costs {_drop(question)}, {question.scene}, "
        f"{question.frames} frames"
    )
    return Table(columns, rows, title, note=few_seeds_note(each.score.count for each in points))


def _drop(question: BreakingPointSpec) -> str:
    return f"{100.0 * question.drop:g} points of {question.metric}"


def breaking_content(
    question: BreakingPointSpec, points: Sequence[BreakingPoint]
) -> dict[str, Any]:
    """The points and their curves in plain values, ready for JSON."""
    asked = ("axis", "metric", "drop", "scene", "seeds", "first_seed", "frames", "precision")
    return {
        **{name: getattr(question, name) for name in asked},
        "start": question.best,
        "fixed": dict(question.fixed),
        "trackers": [
            {
                "tracker": each.tracker, "score": vars(each.score), "level": each.level,
                "low": each.low, "high": each.high, "tried": each.tried,
                "failed": each.failed, "error": each.error,
                "curve": [
                    {"level": level, "score": vars(score), "fall": vars(fall)}
                    for level, score, fall in each.curve
                ],
            }
            for each in points
        ],
    }  # fmt: skip


def _level(level: Level | None, tried: Level) -> str:
    """A level; where there is none, that it lies beyond the farthest."""
    return f"beyond {_word(tried)}" if level is None else _word(level)


def _word(level: Level) -> str:
    return f"{level:.3g}" if isinstance(level, float) else str(level)
