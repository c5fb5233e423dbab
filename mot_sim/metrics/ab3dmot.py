"""AB3DMOT's scores in 3D: CLEAR at every recall, and its averages.

Weng et al., 3D multi-object tracking: a baseline and new evaluation metrics, IROS 2020. Tracks
are cut by their mean score at up to forty levels of recall. Where its code averages scores again
in every pass, so that rounding loses tracks, they are averaged once here: sAMOTA comes out one to
two points higher.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Float, Int
from numpy import ndarray as Array

from mot_sim.metrics.clear import Number
from mot_sim.metrics.cuboid_overlap import Criterion
from mot_sim.metrics.cuboid_preparation import PreparedCuboids
from mot_sim.metrics.devkit2018 import Devkit2018, count_as_devkit
from mot_sim.metrics.matching import Overlaps

RECALL_LEVELS = 40
# The cut that no track falls under.
NO_CUT = -10000.0


@dataclass(frozen=True, eq=False)
class RecallLevel:
    """The scores of the tracks whose mean score reaches a cut."""

    score_threshold: float
    """The least mean score of a track."""
    recall: float
    """The level's nominal recall: 1/40, 2/40, ..., or 1."""
    counts: Devkit2018
    """CLEAR's counts; matches of neutral labels are in CLR_TP."""
    neutral_matches: int
    """How many of the matches are of neutral labels."""
    mean_precision: float
    """MOTP: IoU or, for distances, metres, mean over the matches; 0 without any."""
    MODP: float
    """Mean over frames of the mean similarity of their matches; a frame without any counts 1."""
    FAR: float
    """False positives per frame."""

    @property
    def sMOTA(self) -> float:
        """MOTA scaled by what the recall lets it reach, in [0, 1]."""
        counts, labels = self.counts, self.counts.GT_Dets
        errors = counts.CLR_FN + counts.CLR_FP + counts.IDSW - (1.0 - self.recall) * labels
        return float(np.clip(1.0 - errors / (self.recall * labels), 0.0, 1.0)) if labels else 0.0

    @property
    def F1(self) -> float:
        """The harmonic mean of recall and precision."""
        recall, precision = self.counts.CLR_Re, self.counts.CLR_Pr
        return 2.0 * recall * precision / (recall + precision) if recall + precision else 0.0

    def numbers(self) -> dict[str, Number]:
        """Every score by its name."""
        named = self.counts.numbers()
        named.pop("MOTP_sum")
        return named | {
            "MOTP": self.mean_precision, "sMOTA": self.sMOTA, "CLR_F1": self.F1,
            "MODP": self.MODP, "FAR": self.FAR, "neutral_matches": self.neutral_matches,
            "score_threshold": self.score_threshold, "recall_level": self.recall,
        }  # fmt: skip


@dataclass(frozen=True, eq=False)
class Ab3dmot:
    """AB3DMOT's scores by one criterion."""

    criterion: Criterion
    """What makes a match."""
    levels: tuple[RecallLevel, ...]
    """The levels of recall that are reached, at most forty."""
    best: RecallLevel
    """The level with the greatest MOTA, where that is above 0; otherwise all tracks."""
    all_tracks: RecallLevel
    """The scores of all tracks, whatever their scores."""

    @property
    def sAMOTA(self) -> float:
        """Mean of sMOTA over forty levels; those not reached count 0."""
        return sum(level.sMOTA for level in self.levels) / RECALL_LEVELS

    @property
    def AMOTA(self) -> float:
        """Mean of MOTA over forty levels; those not reached count 0."""
        return sum(level.counts.MOTA for level in self.levels) / RECALL_LEVELS

    @property
    def AMOTP(self) -> float:
        """Mean of MOTP over forty levels, as AB3DMOT takes it: those not reached count 0."""
        return sum(level.mean_precision for level in self.levels) / RECALL_LEVELS

    def numbers(self) -> dict[str, Number]:
        """The averages, and the scores of the best level by their names."""
        averages = {"sAMOTA": self.sAMOTA, "AMOTA": self.AMOTA, "AMOTP": self.AMOTP}
        return averages | self.best.numbers()

    def as_dict(self) -> dict[str, Any]:
        """Plain numbers, ready for JSON: the averages, the best level, all tracks, each level."""
        return {
            **self.numbers(),
            "all_tracks": self.all_tracks.numbers(),
            "levels": [level.numbers() for level in self.levels],
        }


@dataclass(frozen=True, eq=False)
class RecallSweep:
    """The pairs of labels and output that may match, and what counts them at any cut."""

    prepared: PreparedCuboids
    """What is scored."""
    criterion: Criterion
    """What makes a match."""
    overlaps: Overlaps
    """All pairs, with their similarity."""

    @classmethod
    def of(cls, prepared: PreparedCuboids, criterion: Criterion) -> "RecallSweep":
        """With the similarity that the criterion measures."""
        return cls(prepared, criterion, prepared.overlaps(criterion))

    def level(
        self, cut: float = NO_CUT, recall: float = 1.0
    ) -> tuple[RecallLevel, Int[Array, " j"]]:
        """The scores of the tracks whose mean score is at least the cut, and their matches."""
        overlaps, prepared = self.overlaps, self.prepared
        kept = prepared.track_scores >= cut
        near = np.flatnonzero(
            (1.0 - overlaps.iou <= 1.0 - self.criterion.least) & kept[overlaps.columns]
        )
        counts, matched = count_as_devkit(
            overlaps, prepared.neutral, kept & ~prepared.ignored, near
        )
        counted = matched[~prepared.neutral[overlaps.rows[matched]]]
        # AB3DMOT takes one frame too many of every sequence.
        frames = prepared.frame_count + prepared.sequence_count
        mean = float(overlaps.iou[matched].mean()) if len(matched) else 0.0
        return RecallLevel(
            score_threshold=cut,
            recall=recall,
            counts=counts,
            neutral_matches=len(matched) - len(counted),
            mean_precision=self.criterion.precision(mean) if len(matched) else 0.0,
            MODP=_mean_over_frames(overlaps.frames[counted], overlaps.iou[counted], frames),
            FAR=counts.CLR_FP / frames,
        ), matched

    def scores(self) -> Ab3dmot:
        """The sweep over all levels of recall."""
        whole, matched = self.level()
        scores = self.prepared.track_scores[self.overlaps.columns[matched]]
        levels = tuple(
            self.level(cut, recall)[0]
            for cut, recall in cuts_by_recall(scores, whole.counts.CLR_TP + whole.counts.CLR_FN)
        )
        best = max(levels, key=lambda level: level.counts.MOTA, default=whole)
        is_best = best.counts.MOTA > 0.0
        shown = self.level(best.score_threshold)[0] if is_best else whole
        return Ab3dmot(self.criterion, levels, shown, whole)


def _mean_over_frames(
    frames: Int[Array, " j"], similarity: Float[Array, " j"], frame_count: int
) -> float:
    """The mean of the frames' mean similarity; 1 for a frame without a match."""
    _, of_frame, counts = np.unique(frames, return_inverse=True, return_counts=True)
    total = float((np.bincount(of_frame, similarity) / counts).sum()) if len(counts) else 0.0
    return (total + frame_count - len(counts)) / frame_count


def cuts_by_recall(scores: Float[Array, " j"], labels: int) -> list[tuple[float, float]]:
    """The cuts, and the nominal recall of each, from the scores of the matches.

    labels: all that could be found. The first cut is dropped, as AB3DMOT does: at most forty.
    """
    falling = np.sort(scores)[::-1].tolist()
    cuts, recall = [], 0.0
    for place, score in enumerate(falling):
        left, right = (place + 1) / labels, (place + 2) / labels
        is_last = place == len(falling) - 1
        if not is_last and right - recall < recall - left:
            continue
        cuts.append((score, recall))
        recall += 1.0 / RECALL_LEVELS
    return cuts[1:]


def ab3dmot_scores(
    prepared: PreparedCuboids, criteria: Sequence[Criterion]
) -> Mapping[str, Ab3dmot]:
    """AB3DMOT's scores by each criterion, by its name."""
    return {each.name: RecallSweep.of(prepared, each).scores() for each in criteria}
