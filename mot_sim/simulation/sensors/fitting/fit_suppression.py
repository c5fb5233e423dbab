"""Fits what a detector suppresses: pairs of found cars that overlap, beside those without it."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Bool, Float, Int
from numpy import ndarray as Array
from scipy.special import expit, logit

from mot_sim.simulation.sensors.boxes import overlapping_pairs
from mot_sim.simulation.sensors.correlated_noise import Autocorrelation
from mot_sim.simulation.sensors.fitting.fit_misses import latent_autocorrelation
from mot_sim.simulation.sensors.fitting.measure import (
    DRIVE_ID_STRIDE,
    DetectorMeasurements,
    Found,
)
from mot_sim.simulation.sensors.fitting.statistics import FRAME_STRIDE, rates_in_bins
from mot_sim.simulation.sensors.fitting.tetrachoric import RatedEvents
from mot_sim.simulation.sensors.quantiles import Quantiles
from mot_sim.simulation.sensors.suppression import (
    IOU_BINS,
    NO_LIMIT,
    SCORE_BINS,
    OverlapSuppression,
)
from tracker.types import Rows

MIN_PAIRS = 20  # that would be there without suppression, to tell of it at all
PRIOR_PAIRS = 10.0  # of the overlap's whole row, that weigh with each cell of the table
MIN_DEVIATIONS = 2.0  # standard deviations that a share of high scores is too low by
MIN_EVENTS = 30  # overlapping cars with one lost, to tell how long that lasts
USUAL = Autocorrelation((1.0,), (1.0,))


@dataclass(frozen=True, eq=False)
class OverlappingBoxes(Rows):
    """Pairs of detections that match two labelled vehicles of a frame and overlap."""

    iou: Float[Array, " n"]
    """Of the two detections, IOU_BINS[0] or more."""
    weaker: Float[Array, " n"]
    """The lower of both scores, 0 to 1."""

    @property
    def counts(self) -> Float[Array, "i s"]:
        """How many there are in each bin of IoU and score."""
        rows = np.digitize(self.iou, IOU_BINS) - 1
        columns = np.digitize(self.weaker, SCORE_BINS) - 1
        found = np.zeros((len(IOU_BINS), len(SCORE_BINS)))
        np.add.at(found, (rows, columns), 1.0)
        return found


def moments(found: Found) -> Int[Array, " n"]:
    """One number for each drive and frame, ascending as rows are."""
    return found.ids // DRIVE_ID_STRIDE * FRAME_STRIDE + found.frames


def overlapping_boxes(found: Found) -> OverlappingBoxes:
    """Those of what was found."""
    hits = found.select(found.hit)
    true = hits.sightings.boxes
    boxes = true + hits.edges * np.tile(true[:, 2:] - true[:, :2], (1, 2))
    scores = expit(hits.log_odds)
    first, second, iou = overlapping_pairs(moments(hits), boxes, IOU_BINS[0])
    return OverlappingBoxes(iou, np.minimum(scores[first], scores[second]))


def recall_behind(found: Found, edges: tuple[float, ...]) -> list[tuple[int, float]]:
    """How many counted cars overlap a nearer one by so much, and the part of them that is found."""
    first, second, iou = overlapping_pairs(moments(found), found.sightings.boxes, edges[0])
    low = found.sightings.boxes[:, 3]
    behind = np.where(low[first] < low[second], first, second)
    counted = found.counted[behind]
    return rates_in_bins(iou[counted], found.hit[behind[counted]], edges)


def crowded(found: Found, min_iou: float = IOU_BINS[0]) -> Bool[Array, " n"]:
    """Which vehicles' labels overlap another's: where suppression may be at work."""
    first, second, _ = overlapping_pairs(moments(found), found.sightings.boxes, min_iou)
    rows = np.zeros(len(found), bool)
    rows[first] = rows[second] = True
    return rows


def fit_suppression(
    real: DetectorMeasurements, without: Sequence[DetectorMeasurements], step: float
) -> OverlapSuppression | None:
    """The suppression that leaves as many pairs as the real detector did; None: too few to tell.

    without: simulations of the same drives by the profile without suppression.
    """
    there = overlapping_boxes(real.found)
    expected = OverlappingBoxes.concatenate([overlapping_boxes(each.found) for each in without])
    n, n0 = there.counts, expected.counts / len(without)
    if n0.sum() < MIN_PAIRS:
        return None
    by_iou = (1.0 - (n.sum(1) + 1.0) / (n0.sum(1) + 1.0)).clip(0.0, 1.0)
    weakened = _weakened(n, n0)
    prior = PRIOR_PAIRS * (1.0 - by_iou)[:, None]
    dropped = (1.0 - (n + prior) / (n0 + PRIOR_PAIRS)).clip(0.0, 1.0)
    dropped[weakened > 0.0] = by_iou[weakened > 0.0, None]  # who was of which score, is unknown
    limits = there.weaker[np.isin(np.digitize(there.iou, IOU_BINS) - 1, np.flatnonzero(weakened))]
    limits = limits[limits < SCORE_BINS[-1]]
    return OverlapSuppression(
        dropped=tuple(np.round(dropped, 4).ravel().tolist()),
        weakened=tuple(np.round(weakened, 4).tolist()) if len(limits) else (0.0,) * len(IOU_BINS),
        log_odds=Quantiles.of(logit(limits.clip(1e-6, 1.0 - 1e-6))) if len(limits) else NO_LIMIT,
        autocorrelation=fit_lasting(real.found, step),
    )


def correct_suppression(
    suppression: OverlapSuppression,
    real: DetectorMeasurements,
    made: Sequence[DetectorMeasurements],
) -> OverlapSuppression:
    """The same with what is left scaled so that as many pairs of each IoU are left as there were.

    made: simulations with it.
    """
    wanted = overlapping_boxes(real.found).counts.sum(1)
    there = OverlappingBoxes.concatenate([overlapping_boxes(each.found) for each in made])
    factor = (wanted + 1.0) / (there.counts.sum(1) / len(made) + 1.0)
    dropped = np.array(suppression.dropped).reshape(len(IOU_BINS), len(SCORE_BINS))
    left = (1.0 - dropped) * factor.clip(0.5, 2.0)[:, None]
    kept = np.where(dropped > 0.0, left, 1.0).clip(0.0, 1.0)
    return replace(suppression, dropped=tuple(np.round(1.0 - kept, 4).ravel().tolist()))


def _weakened(n: Float[Array, "i s"], n0: Float[Array, "i s"]) -> Float[Array, " i"]:
    """By how much the share of high scores falls short, where it clearly does."""
    total, expected = np.maximum(n.sum(1), 1e-9), np.maximum(n0.sum(1), 1e-9)
    share, usual = n[:, -1] / total, n0[:, -1] / expected
    deviation = np.sqrt(np.maximum(usual * (1.0 - usual), 1e-9) / np.maximum(total, 1.0))
    short = usual - share > MIN_DEVIATIONS * deviation
    return np.where(short & (n.sum(1) > 0.0), 1.0 - share / np.maximum(usual, 1e-9), 0.0)


def fit_lasting(found: Found, step: float) -> Autocorrelation:
    """How long one of two overlapping cars stays lost, of pairs of which one at least is found."""
    first, second, iou = overlapping_pairs(moments(found), found.sightings.boxes, 0.5)
    seen = found.hit[first] | found.hit[second]
    first, second, iou = first[seen], second[seen], iou[seen]
    lost = found.hit[first] != found.hit[second]
    if min(lost.sum(), (~lost).sum()) < MIN_EVENTS:
        return USUAL
    bins = np.digitize(iou, IOU_BINS)
    rates = np.array([(lost[bins == each].mean()) for each in bins.tolist()])
    _, pair = np.unique(
        np.stack((found.ids[first], found.ids[second])), axis=1, return_inverse=True
    )
    events = RatedEvents(lost, rates.clip(0.02, 0.98), pair.ravel(), found.frames[first])
    return latent_autocorrelation(events, step)
