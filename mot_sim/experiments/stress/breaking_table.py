"""Breaking points as a table, as lines of a picture, and as plain values."""

from collections.abc import Sequence
from typing import Any

from mot_sim.experiments.stress.breaking_point import BreakingPoint, BreakingPointSpec
from mot_sim.experiments.sweep.paths import Level
from mot_sim.experiments.sweep.summary_tables import shown
from mot_sim.tables.grid import Column, Table


def breaking_table(question: BreakingPointSpec, points: Sequence[BreakingPoint]) -> Table:
    """A row a tracker: its score where nothing is wrong, and the level that costs the drop."""
    titles = (
        "tracker", f"{question.metric} at {_word(question.best)}", "breaks at", "95 % interval",
        "levels", "seeds", "failed",
    )  # fmt: skip
    rows = tuple(
        (
            each.tracker, shown(each.score, question.metric), _level(each.level, each.tried),
            f"{_level(each.low, each.tried)} to {_level(each.high, each.tried)}",
            str(len(each.curve)), str(each.score.count), str(each.failed or ""),
        )
        for each in points
    )  # fmt: skip
    title = (
        f"level of {question.axis} that costs {100.0 * question.drop:g} points of "
        f"{question.metric}, {question.scene}, {question.frames} frames"
    )
    return Table(tuple(Column(each) for each in titles), rows, title)


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
