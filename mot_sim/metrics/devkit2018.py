"""CLEAR scores as KITTI's development kit of 2018 counts them: the numbers of papers of that time.

They differ from TrackEval's in four ways. Matches to neutral labels stay in CLR_TP, and so in
recall, precision and MOTP, while misses, false positives and GT_Dets leave neutral labels out:
CLR_TP + CLR_FN exceeds GT_Dets, over which MOTA is taken. A frame is matched for the most pairs
first, then for overlap, and never to keep a name. A switch needs two neighbouring rows of a
label matched. A track is judged by its rows that are not neutral.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Int
from numpy import ndarray as Array

from mot_sim.metrics.clear import MOSTLY_LOST, MOSTLY_TRACKED, ClearCounts, Number
from mot_sim.metrics.matching import Overlaps, match
from mot_sim.metrics.preprocessing import MIN_OVERLAP, PreparedSequence, ignored_if_unmatched

PAIR_BONUS = 1000.0  # more than all overlaps of a frame: one pair more goes first


@dataclass(frozen=True, eq=False)
class Devkit2018(ClearCounts):
    """CLEAR as the development kit counts it; rates of nothing are 0 (the kit says infinite)."""

    GT_Dets: int
    """Labels that are not neutral."""

    def accuracy(self, switches: Number) -> float:
        """1 less the misses, false positives and the given switches per counted label."""
        errors = self.CLR_FN + self.CLR_FP + switches
        return 1.0 - errors / self.GT_Dets if self.GT_Dets else 0.0


def devkit2018_clear(prepared: PreparedSequence) -> Devkit2018:
    """The development kit's CLEAR scores of one sequence."""
    near = np.flatnonzero(1.0 - prepared.overlaps.iou <= MIN_OVERLAP)
    ignored = ignored_if_unmatched(prepared, slack=0.0)
    return count_as_devkit(prepared.overlaps, prepared.neutral, ~ignored, near)[0]


def count_as_devkit(
    overlaps: Overlaps,
    neutral: Bool[Array, " n"],
    invented: Bool[Array, " m"],
    near: Int[Array, " k"],
) -> tuple[Devkit2018, Int[Array, " j"]]:
    """The kit's counts, and the matched pairs.

    neutral: labels that need not be found. invented: rows of the output that are false positives
    unless they are matched. near: ascending indices of the pairs that may be matched.
    """
    matched = match(overlaps, near, PAIR_BONUS + overlaps.iou[near])
    names = np.full(len(neutral), -1)
    names[overlaps.rows[matched]] = overlaps.output_ids[matched]
    invented = invented.copy()
    invented[overlaps.columns[matched]] = False
    order = np.lexsort((overlaps.truth.frames, overlaps.truth.ids))
    switches, fragments, mostly, partly, lost = judge_tracks(
        overlaps.truth.ids[order], names[order], neutral[order]
    )
    counts = Devkit2018(
        CLR_TP=len(matched),
        CLR_FN=int((~neutral & (names < 0)).sum()),
        CLR_FP=int(invented.sum()),
        IDSW=switches,
        MT=mostly,
        PT=partly,
        ML=lost,
        Frag=fragments,
        MOTP_sum=float(overlaps.iou[matched].sum()),
        GT_Dets=int((~neutral).sum()),
    )
    return counts, matched


def judge_tracks(
    ids: Int[Array, " n"], names: Int[Array, " n"], neutral: Bool[Array, " n"]
) -> tuple[int, int, int, int, int]:
    """Switches, fragments, and tracks mostly, partly and hardly tracked.

    Rows in the order of labels' ids, then frames; names: what matched the row, -1 for nothing.
    A row is compared with the last name that its track bore, which a neutral row erases. Names
    on a track's first row count even if that row is neutral, as they do in the kit.
    """
    if not len(ids):
        return 0, 0, 0, 0, 0
    first = np.r_[True, ids[1:] != ids[:-1]]
    ends = np.r_[first[1:], True]
    matched, judged = names >= 0, ~first & ~neutral
    remembered = np.where(neutral & ~first, -1, names)
    tells = np.where(first | neutral | matched, np.arange(len(ids)), 0)
    last = np.roll(remembered[np.maximum.accumulate(tells)], 1)
    before, matched_next = np.roll(names, 1), np.roll(matched, -1)
    renamed = judged & matched & (before != names)
    switches = renamed & (last != names) & (last >= 0) & (before >= 0)
    fragments = renamed & (ends | ((last >= 0) & matched_next))
    track = np.cumsum(first) - 1
    counted = np.bincount(track, ~neutral)
    tracked = np.bincount(track, matched & (judged | first))
    ratio = tracked[counted > 0] / counted[counted > 0]
    mostly, lost = int((ratio > MOSTLY_TRACKED).sum()), int((ratio < MOSTLY_LOST).sum())
    return int(switches.sum()), int(fragments.sum()), mostly, len(ratio) - mostly - lost, lost
