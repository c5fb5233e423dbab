"""Suites and verdicts as tables and as plain values."""

from collections.abc import Iterator, Sequence
from math import isfinite
from typing import Any

from mot_sim.experiments.stress.suites import Suite, Verdict
from mot_sim.experiments.sweep.summary_tables import INTERVAL_NOTE
from mot_sim.tables import Column, Table, few_seeds_note, is_count, with_ends


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
