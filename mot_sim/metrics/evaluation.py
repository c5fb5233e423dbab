"""From truth and output to scores, by named rules, for one sequence or many together."""

import logging
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from math import isnan
from typing import Any

from mot_sim.metrics.clear import ClearCounts, Number, clear_scores
from mot_sim.metrics.devkit2018 import devkit2018_clear
from mot_sim.metrics.doubts import why_nothing_is_scored
from mot_sim.metrics.hota import ALPHAS, Hota, hota_scores
from mot_sim.metrics.identity import Identity, identity_scores
from mot_sim.metrics.preprocessing import PreparedSequence, prepare_sequence, scored_rows
from mot_sim.metrics.spatial import SpatialScores
from tracker.errors import BadConfig, UnknownName
from tracker.types import Tracks

log = logging.getLogger(__name__)


@dataclass(frozen=True, eq=False)
class Scores:
    """All scores of one sequence, or of several together; `scores["HOTA"]` is one plain number.

    Names are TrackEval's.
    """

    clear: ClearCounts
    """CLEAR: `Clear` or `Devkit2018`."""
    hota: Hota | None = None
    """HOTA; None where the rules do not have it."""
    identity: Identity | None = None
    """Identity scores; None where the rules do not have them."""
    spatial: SpatialScores | None = None
    """Scores of the cuboids; None where they were not scored."""

    def __getitem__(self, name: str) -> Number:
        """One score by its name; of those that vary with alpha, the mean."""
        numbers = self.numbers()
        if name not in numbers:
            raise UnknownName.of("score", name, numbers)
        return numbers[name]

    def numbers(self) -> dict[str, Number]:
        """Every score by its name; of those that vary with alpha, the mean."""
        families = (self.hota, self.clear, self.identity, self.spatial)
        return {
            name: number
            for family in families
            if family is not None
            for name, number in family.numbers().items()
        }

    def as_dict(self) -> dict[str, Any]:
        """Every score as a plain number, and under `by_alpha` lists over HOTA's alphas."""
        found: dict[str, Any] = {
            name: None if isnan(value) else value for name, value in self.numbers().items()
        }
        if self.hota is None:
            return found
        return found | {"by_alpha": {"alpha": ALPHAS.tolist()} | self.hota.by_alpha()}


def combine(parts: Sequence[Scores]) -> Scores:
    """The scores of several sequences together, as TrackEval's COMBINED_SEQ.

    Counts add up; rates are taken of the sums. One sequence without labels or output may
    score other rates combined than alone, as in TrackEval (see `Clear`). Raises BadConfig
    for nothing, and for scores of different rules.
    """
    families = {(type(part.clear), part.hota is None, part.identity is None) for part in parts}
    if len(families) != 1:
        raise BadConfig(
            f"{len(parts)} scores of {len(families)} kinds cannot be combined: "
            "give at least one sequence, and score all by the same rules"
        )
    clears = [part.clear for part in parts]
    hotas = [part.hota for part in parts if part.hota is not None]
    spatial = [part.spatial for part in parts if part.spatial is not None]
    identities = [part.identity for part in parts if part.identity is not None]
    return Scores(
        clear=type(clears[0]).combine(clears),
        hota=Hota.combine(hotas) if hotas else None,
        identity=Identity.combine(identities) if identities else None,
        spatial=SpatialScores.combine(spatial) if len(spatial) == len(parts) else None,
    )


def by_trackeval(prepared: PreparedSequence, frame_count: int) -> Scores:
    """CLEAR, HOTA and Identity as TrackEval 1.3.0 scores a class of KITTI's."""
    overlaps = scored_rows(prepared)
    return Scores(
        clear=clear_scores(overlaps, frame_count),
        hota=hota_scores(overlaps),
        identity=identity_scores(overlaps),
    )


def by_devkit2018(prepared: PreparedSequence, frame_count: int) -> Scores:
    """CLEAR as KITTI's development kit of 2018 counts it; no HOTA, no Identity."""
    return Scores(clear=devkit2018_clear(prepared))


RULES: dict[str, Callable[[PreparedSequence, int], Scores]] = {
    "devkit2018": by_devkit2018,
    "trackeval": by_trackeval,
}


@dataclass(frozen=True, eq=False)
class Evaluation:
    """The scores of every sequence, and of all together."""

    rules: str
    """Name of the rules, of RULES."""
    kind: str
    """The class that was scored, of TRACKED_KINDS."""
    sequences: dict[str, Scores]
    """The scores of each sequence, by its name."""
    combined: Scores
    """The scores of all of them together."""

    def as_dict(self) -> dict[str, Any]:
        """Plain numbers and lists, ready for JSON."""
        return {
            "rules": self.rules,
            "class": self.kind,
            "sequences": {name: scores.as_dict() for name, scores in self.sequences.items()},
            "combined": self.combined.as_dict(),
        }


def evaluate_sequence(
    truth: Tracks, output: Tracks, frame_count: int, rules: str = "trackeval", kind: str = "Car"
) -> Scores:
    """The scores of one sequence of `frame_count` frames, for one class.

    truth: all labels, with the columns kinds, truncation and occlusion where the data set has
    them. output: all rows without kinds, or of this kind, count. kind: of TRACKED_KINDS. Rows may
    come in any order; only between matches of exactly equal merit does the order within a frame
    choose, as in TrackEval. Where rows are given and none is scored, a warning says what they hold.
    Raises UnknownName for rules and kind, BadTracks for rows that cannot be scored.
    """
    scores = _scores(truth, output, frame_count, rules, kind)
    _warn_of_nothing("sequence", {"labels": truth, "results": output}, kind)
    return scores


def _scores(truth: Tracks, output: Tracks, frame_count: int, rules: str, kind: str) -> Scores:
    if rules not in RULES:
        raise UnknownName.of("rules", rules, RULES)
    return RULES[rules](prepare_sequence(truth, output, frame_count, kind), frame_count)


def _warn_of_nothing(name: str, tables: Mapping[str, Tracks], kind: str) -> None:
    """Say of rows of which none is scored what they hold."""
    for what, rows in tables.items():
        if (why := why_nothing_is_scored(rows, kind)) is not None:
            log.warning("%s: the %s %s", name, what, why)


def evaluate(
    sequences: Mapping[str, tuple[Tracks, Tracks, int]],
    rules: str = "trackeval",
    kind: str = "Car",
) -> Evaluation:
    """The scores of many sequences, given as name: (truth, output, frame_count), for one class.

    Where rows are given and none is scored, a warning says what they hold; of labels only if no
    sequence has any of the class. Raises as `evaluate_sequence` and `combine` do.
    """
    scores = {
        name: _scores(truth, output, frame_count, rules, kind)
        for name, (truth, output, frame_count) in sequences.items()
    }
    some = any(why_nothing_is_scored(truth, kind) is None for truth, _, _ in sequences.values())
    for name, (truth, output, _) in sequences.items():
        given = {"results": output} if some else {"labels": truth, "results": output}
        _warn_of_nothing(name, given, kind)
    return Evaluation(rules, kind, scores, combine(list(scores.values())))
