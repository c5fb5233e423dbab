"""CLEAR scores: how many boxes are found, invented, and given a new track id.

Bernardin & Stiefelhagen, Evaluating multiple object tracking performance: the CLEAR MOT metrics,
EURASIP 2008; names and numbers as in TrackEval 1.3.0, with its conventions where the paper is open.
`ClearCounts` has what every version of the rules shares.
"""

from collections.abc import Sequence
from dataclasses import MISSING, dataclass, fields
from math import log10
from typing import ClassVar

import numpy as np
from jaxtyping import Int
from numpy import ndarray as Array

from mot_sim.metrics.matching import EPSILON, Overlaps, solve_frame
from mot_sim.metrics.preprocessing import MIN_OVERLAP

MOSTLY_TRACKED = 0.8  # of a label's frames
MOSTLY_LOST = 0.2

Number = int | float  # a count or a rate
CONTINUING_BONUS = 1000.0  # more than all overlaps of a frame: kept track ids go first


@dataclass(frozen=True, eq=False)
class ClearCounts:
    """CLEAR counts, and their rates under the names that TrackEval gives them.

    The rules decide which boxes and tracks are counted.
    """

    RATES: ClassVar[tuple[str, ...]] = (
        "MOTA",
        "MOTP",
        "MODA",
        "MOTAL",
        "CLR_Re",
        "CLR_Pr",
        "MTR",
        "PTR",
        "MLR",
    )

    CLR_TP: int
    """Matches: boxes of the output that meet a label."""
    CLR_FN: int
    """Misses: labels that no box meets."""
    CLR_FP: int
    """False positives: boxes that meet no label."""
    IDSW: int
    """Id switches: a label's match has another id than its match before."""
    MT: int
    """Labels' tracks that are mostly (> 80 % of their frames) tracked."""
    PT: int
    """Labels' tracks that are partly tracked."""
    ML: int
    """Labels' tracks that are mostly lost (< 20 % tracked)."""
    Frag: int
    """Fragments: a label is matched again after frames without a match."""
    MOTP_sum: float
    """Sum of the IoU of all matches."""

    def accuracy(self, switches: Number) -> float:
        """1 less the misses, false positives and the given switches per label."""
        raise NotImplementedError

    def rate(self, part: Number, whole: Number) -> float:
        """A part of a whole; of nothing it is 0."""
        return part / max(1.0, whole)

    @property
    def MOTA(self) -> float:
        """1 less the misses, false positives and id switches per label."""
        return self.accuracy(self.IDSW)

    @property
    def MODA(self) -> float:
        """MOTA without the id switches."""
        return self.accuracy(0.0)

    @property
    def MOTAL(self) -> float:
        """MOTA with the logarithm of the id switches."""
        return self.accuracy(log10(self.IDSW) if self.IDSW else 0.0)

    @property
    def MOTP(self) -> float:
        """The mean overlap of the matches (intersection over union; more is better)."""
        return self.rate(self.MOTP_sum, self.CLR_TP)

    @property
    def CLR_Re(self) -> float:
        """Recall."""
        return self.rate(self.CLR_TP, self.CLR_TP + self.CLR_FN)

    @property
    def CLR_Pr(self) -> float:
        """Precision."""
        return self.rate(self.CLR_TP, self.CLR_TP + self.CLR_FP)

    @property
    def MTR(self) -> float:
        """The share of the labels' tracks that are mostly tracked."""
        return self.rate(self.MT, self.MT + self.PT + self.ML)

    @property
    def PTR(self) -> float:
        """The share of the labels' tracks that are partly tracked."""
        return self.rate(self.PT, self.MT + self.PT + self.ML)

    @property
    def MLR(self) -> float:
        """The share of the labels' tracks that are mostly lost."""
        return self.rate(self.ML, self.MT + self.PT + self.ML)

    @classmethod
    def counted(cls) -> list[str]:
        """The names of the counts, which add up over sequences."""
        return [field.name for field in fields(cls) if field.default is MISSING]

    @classmethod
    def combine(cls, parts: Sequence["ClearCounts"]) -> "ClearCounts":
        """The scores of all sequences together: counts add up."""
        return cls(**{name: sum(getattr(part, name) for part in parts) for name in cls.counted()})

    def numbers(self) -> dict[str, Number]:
        """Every score by its name."""
        return {name: getattr(self, name) for name in (*self.RATES, *self.counted())}


@dataclass(frozen=True, eq=False)
class Clear(ClearCounts):
    """CLEAR as TrackEval counts it, without neutral labels and what matches them."""

    RATES: ClassVar[tuple[str, ...]] = (*ClearCounts.RATES, "sMOTA", "CLR_F1", "FP_per_frame")

    CLR_Frames: int
    """Frames of the sequence."""
    one_sided: bool = False
    """A single sequence without labels or without output, for which TrackEval gives 0 for every
    rate and 1 for MLR, and counts no frame; in sums its boxes count like all others."""

    def rate(self, part: Number, whole: Number) -> float:
        """A part of a whole; 0 of nothing, and for a one-sided sequence."""
        return 0.0 if self.one_sided else super().rate(part, whole)

    def accuracy(self, switches: Number) -> float:
        """1 less the misses, false positives and the given switches per label."""
        return self.rate(self.CLR_TP - self.CLR_FP - switches, self.CLR_TP + self.CLR_FN)

    @property
    def sMOTA(self) -> float:
        """MOTA in which a match counts by its overlap."""
        return self.rate(self.MOTP_sum - self.CLR_FP - self.IDSW, self.CLR_TP + self.CLR_FN)

    @property
    def CLR_F1(self) -> float:
        """The harmonic mean of recall and precision."""
        return self.rate(self.CLR_TP, self.CLR_TP + 0.5 * self.CLR_FN + 0.5 * self.CLR_FP)

    @property
    def FP_per_frame(self) -> float:
        """False positives per frame."""
        return self.rate(self.CLR_FP, self.CLR_Frames)

    @property
    def MLR(self) -> float:
        """The share of the labels' tracks that are mostly lost; 1 for a one-sided sequence."""
        return 1.0 if self.one_sided else super().MLR


def clear_scores(overlaps: Overlaps, frame_count: int) -> Clear:
    """CLEAR scores of one sequence.

    A frame counts as the one before only if it holds labels and output, as in TrackEval: an
    empty frame neither breaks a continuing match nor makes a fragment.
    """
    truth_total, output_total = len(overlaps.truth), len(overlaps.output)
    truth_count = overlaps.id_counts[0]
    if not truth_total or not output_total:
        return Clear(0, truth_total, output_total, 0, 0, 0, truth_count, 0, 0.0, 0, True)
    busy = np.intersect1d(overlaps.truth.frames, overlaps.output.frames)
    matched = match_in_time(overlaps, busy)
    found = len(matched)
    # Matches in the order of labels' ids, then of time: neighbours tell switches and fragments.
    by_label = matched[np.argsort(overlaps.truth_ids[matched], kind="stable")]
    label, name = overlaps.truth_ids[by_label], overlaps.output_ids[by_label]
    step = np.searchsorted(busy, overlaps.frames[by_label])
    same_label = label[1:] == label[:-1]
    tracked = np.bincount(label, minlength=truth_count) / np.bincount(overlaps.truth.ids)
    mostly = int((tracked > MOSTLY_TRACKED).sum())
    partly = int((tracked >= MOSTLY_LOST).sum()) - mostly
    # Summed frame by frame, as the reference does, to agree to the last digit.
    by_frame = np.bincount(overlaps.frames[matched], overlaps.iou[matched], minlength=1)
    return Clear(
        CLR_TP=found,
        CLR_FN=truth_total - found,
        CLR_FP=output_total - found,
        IDSW=int((same_label & (name[1:] != name[:-1])).sum()),
        MT=mostly,
        PT=partly,
        ML=truth_count - mostly - partly,
        Frag=int((same_label & (step[1:] > step[:-1] + 1)).sum()),
        MOTP_sum=float(np.cumsum(by_frame)[-1]),
        CLR_Frames=frame_count,
    )


def match_in_time(overlaps: Overlaps, busy: Int[Array, " b"]) -> Int[Array, " j"]:
    """The matched pairs of every frame: first those that keep a track id, then by overlap.

    busy: the frames with labels and output, ascending. A frame in which no box has two candidates
    needs no choice; only in the others, taken in order, does the frame before matter.
    """
    near = np.flatnonzero(overlaps.iou >= MIN_OVERLAP - EPSILON)
    frames, id_pairs = overlaps.frames[near], overlaps.id_pairs[near]
    rows, columns = overlaps.rows[near], overlaps.columns[near]
    shared = (np.bincount(rows)[rows] > 1) | (np.bincount(columns)[columns] > 1)
    chosen = np.ones(len(near), dtype=bool)
    for frame in np.unique(frames[shared]):
        here = slice(*np.searchsorted(frames, [frame, frame + 1]))
        before = busy[max(0, np.searchsorted(busy, frame) - 1)]
        past = slice(*np.searchsorted(frames, [before, before + 1])) if before < frame else slice(0)
        kept = id_pairs[here, None] == id_pairs[past][chosen[past]]
        weights = CONTINUING_BONUS * kept.any(axis=1) + overlaps.iou[near[here]]
        chosen[here] = solve_frame(overlaps, int(frame), near[here], weights)
    return near[chosen]
