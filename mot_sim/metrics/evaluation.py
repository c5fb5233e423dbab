"""From truth and output to scores, by named rules, for one sequence or many."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from mot_sim.metrics.clear import clear_scores
from mot_sim.metrics.devkit2018 import devkit2018_clear
from mot_sim.metrics.hota import hota_scores
from mot_sim.metrics.identity import identity_scores
from mot_sim.metrics.preprocessing import PreparedSequence, prepare_sequence, scored_rows
from mot_sim.metrics.scores import Scores, combine
from tracker.errors import UnknownName
from tracker.types import Tracks


def by_trackeval(contest: PreparedSequence, frame_count: int) -> Scores:
    """CLEAR, HOTA and Identity as TrackEval 1.3.0 scores KITTI's cars."""
    overlaps = scored_rows(contest)
    return Scores(
        clear=clear_scores(overlaps, frame_count),
        hota=hota_scores(overlaps),
        identity=identity_scores(overlaps),
    )


def by_devkit2018(contest: PreparedSequence, frame_count: int) -> Scores:
    """CLEAR as KITTI's development kit of 2018 counts it; no HOTA, no Identity."""
    return Scores(clear=devkit2018_clear(contest))


RULES: dict[str, Callable[[PreparedSequence, int], Scores]] = {
    "devkit2018": by_devkit2018,
    "trackeval": by_trackeval,
}


@dataclass(frozen=True, eq=False)
class Evaluation:
    """The scores of every sequence, and of all together."""

    rules: str
    sequences: dict[str, Scores]
    combined: Scores

    def as_dict(self) -> dict[str, Any]:
        """Plain numbers and lists, ready for JSON."""
        return {
            "rules": self.rules,
            "sequences": {name: scores.as_dict() for name, scores in self.sequences.items()},
            "combined": self.combined.as_dict(),
        }


def evaluate_sequence(
    truth: Tracks, output: Tracks, frame_count: int, rules: str = "trackeval"
) -> Scores:
    """The scores of one sequence of `frame_count` frames, for the class Car.

    truth: all labels, with the columns kinds, truncation and occlusion where the data set has
    them. output: all rows without kinds, or of kind Car, count as cars. Rows may come in any
    order; only between matches of exactly equal merit does the order within a frame choose, as
    in TrackEval. Raises UnknownName for the rules, BadTracks for rows that cannot be scored.
    """
    if rules not in RULES:
        raise UnknownName.of("rules", rules, RULES)
    return RULES[rules](prepare_sequence(truth, output, frame_count), frame_count)


def evaluate(
    sequences: Mapping[str, tuple[Tracks, Tracks, int]], rules: str = "trackeval"
) -> Evaluation:
    """The scores of many sequences, given as name: (truth, output, frame_count).

    Raises as `evaluate_sequence` and `combine` do.
    """
    scores = {
        name: evaluate_sequence(truth, output, frame_count, rules)
        for name, (truth, output, frame_count) in sequences.items()
    }
    return Evaluation(rules, scores, combine(list(scores.values())))
