"""Figures of what was measured: rates in bins, gap lengths, autocorrelation, lives, distances."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, Int
from numpy import ndarray as Array

from mot_sim.simulation.sensors.fitting.measure import DetectorMeasurements, FalseBoxes, Found
from tracker.geometry import box_iou

FRAME_STRIDE = 100_000  # more frames than any drive has
MIN_LINK_IOU = 0.3  # IoU from which false boxes of neighbouring frames are one false alarm
HEIGHT_BINS = (0.0, 20.0, 25.0, 30.0, 40.0, 60.0, 100.0, 2000.0)
DEPTH_BINS = (0.0, 15.0, 25.0, 40.0, 60.0, 100.0)
OCCLUSION_BINS = (0.0, 0.5, 0.8, 1.01)  # of the visible fraction: KITTI's levels 2, 1, 0


def lagged(
    ids: Int[Array, " n"], frames: Int[Array, " n"], lag: int
) -> tuple[Int[Array, " k"], Int[Array, " k"]]:
    """Rows of one object in two frames that are `lag` apart: the earlier, the later."""
    code = ids * FRAME_STRIDE + frames
    order = np.argsort(code, kind="stable")
    at = np.searchsorted(code[order], code + lag).clip(max=max(len(code) - 1, 0))
    there = code[order][at] == code + lag if len(code) else np.zeros(0, bool)
    return np.flatnonzero(there), order[at[there]]


def lag_correlation(
    x: Float[Array, " n"], ids: Int[Array, " n"], frames: Int[Array, " n"], lag: int
) -> float:
    """Pearson's correlation of an object's values `lag` frames apart; NaN values do not count."""
    first, second = lagged(ids, frames, lag)
    known = np.isfinite(x[first]) & np.isfinite(x[second])
    first, second = first[known], second[known]
    if len(first) < 10 or np.ptp(x[first]) == 0.0 or np.ptp(x[second]) == 0.0:
        return float("nan")
    return float(np.corrcoef(x[first], x[second])[0, 1])


def gap_lengths(found: Found) -> Int[Array, " g"]:
    """Frames in a row in which a counted car went unseen, between two in which it was seen."""
    rows = np.flatnonzero(found.counted)
    rows = rows[np.lexsort((found.frames[rows], found.ids[rows]))]
    rows = rows[found.hit[rows]]  # what lies between two neighbouring hits is a gap
    same = found.ids[rows][1:] == found.ids[rows][:-1]
    between = np.diff(found.frames[rows]) - 1
    return between[same & (between > 0)]


def rates_in_bins(
    values: Float[Array, " n"], event: Bool[Array, " n"], edges: tuple[float, ...]
) -> list[tuple[int, float]]:
    """How many rows each bin has, and how often the event happens there (NaN in an empty bin)."""
    bins = np.digitize(values, edges) - 1
    result = []
    for number in range(len(edges) - 1):
        inside = event[bins == number]
        result.append((len(inside), float(inside.mean()) if len(inside) else float("nan")))
    return result


def lives(false: FalseBoxes) -> Int[Array, " g"]:
    """How many frames in a row false boxes stay at their place."""
    before, after = linked(false, 1)
    length = np.ones(len(false), np.int64)
    for first, second in zip(before.tolist(), after.tolist(), strict=True):
        length[second] = length[first] + 1
    ends = np.ones(len(false), bool)
    ends[before] = False
    return length[ends]


def linked(false: FalseBoxes, lag: int) -> tuple[Int[Array, " k"], Int[Array, " k"]]:
    """Pairs of false boxes at one place, `lag` frames apart, each box in one pair at most."""
    key = false.drives * FRAME_STRIDE + false.frames
    first = np.searchsorted(key, key + lag, side="left")
    count = np.searchsorted(key, key + lag, side="right") - first
    a = np.repeat(np.arange(len(key)), count)
    b = np.arange(len(a)) + np.repeat(first - (np.cumsum(count) - count), count)
    iou = box_iou(false.boxes[a], false.boxes[b])
    order = np.flatnonzero(iou > MIN_LINK_IOU)
    order = order[np.argsort(-iou[order], kind="stable")]
    _, best = np.unique(a[order], return_index=True)
    order = order[np.sort(best)]
    _, best = np.unique(b[order], return_index=True)
    order = np.sort(order[np.sort(best)])
    return a[order], b[order]


def ks_distance(a: Array, b: Array) -> float:
    """The Kolmogorov-Smirnov distance of two samples; 1 when one is empty."""
    if not len(a) or not len(b):
        return 1.0
    values = np.sort(np.concatenate((a, b)))
    ranks = [np.searchsorted(np.sort(x), values, side="right") / len(x) for x in (a, b)]
    return float(np.abs(ranks[0] - ranks[1]).max())


@dataclass(frozen=True)
class Distance:
    """How far two measurements of a detector are from each other, or from its model."""

    gaps: float
    """Kolmogorov-Smirnov distance of the gaps' lengths, 0 to 1."""
    edges: float
    """Kolmogorov-Smirnov distance of edge errors, 0 to 1: the worst of the four edges."""
    scores: float
    """Kolmogorov-Smirnov distance of the hits' scores, 0 to 1."""
    by_depth: float
    """Mean absolute difference of recall over bins of depth, weighted by their rows."""
    by_occlusion: float
    """Mean absolute difference of recall over bins of the visible fraction, weighted by their
    rows."""
    false: float
    """Relative difference of the false positives per frame."""
    precision: float
    """Absolute difference, 0 to 1."""
    recall: float
    """Absolute difference, 0 to 1."""

    @classmethod
    def between(cls, one: DetectorMeasurements, other: DetectorMeasurements) -> "Distance":
        """From the first, the model or a half of the drives, to the second, the reference."""
        a, b = one.found, other.found
        return cls(
            gaps=ks_distance(gap_lengths(a), gap_lengths(b)),
            edges=max(
                ks_distance(a.edges[a.hit & a.counted, k], b.edges[b.hit & b.counted, k])
                for k in range(4)
            ),
            scores=ks_distance(a.log_odds[a.hit & a.counted], b.log_odds[b.hit & b.counted]),
            by_depth=recall_difference(a, b, a.sightings.depth, b.sightings.depth, DEPTH_BINS),
            by_occlusion=recall_difference(
                a, b, a.sightings.visible, b.sightings.visible, OCCLUSION_BINS
            ),
            false=abs(one.false_per_frame / max(other.false_per_frame, 1e-9) - 1.0),
            precision=abs(one.precision - other.precision),
            recall=abs(one.recall - other.recall),
        )


def recall_difference(
    a: Found,
    b: Found,
    a_values: Float[Array, " n"],
    b_values: Float[Array, " m"],
    edges: tuple[float, ...],
) -> float:
    """Mean absolute difference of recall over bins, weighted by the second one's rows."""
    first = rates_in_bins(a_values[a.counted], a.hit[a.counted], edges)
    second = rates_in_bins(b_values[b.counted], b.hit[b.counted], edges)
    both = [(n, abs(p - q)) for (m, p), (n, q) in zip(first, second, strict=True) if m and n]
    return sum(n * d for n, d in both) / max(sum(n for n, _ in both), 1)
