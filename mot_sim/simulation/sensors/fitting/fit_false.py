"""Fits false positives: second boxes about cars, and false alarms."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float, Int
from numpy import ndarray as Array
from scipy.special import expit

from mot_sim.simulation.sensors.boxes import box_errors
from mot_sim.simulation.sensors.clutter import Clutter
from mot_sim.simulation.sensors.correlated_noise import Autocorrelation
from mot_sim.simulation.sensors.fitting.fit_lives import of_lives
from mot_sim.simulation.sensors.fitting.fit_misses import latent_autocorrelation
from mot_sim.simulation.sensors.fitting.measure import (
    DetectorMeasurements,
    FalseBoxes,
    Found,
    LabelledDetections,
)
from mot_sim.simulation.sensors.fitting.statistics import lagged, linked
from mot_sim.simulation.sensors.fitting.tetrachoric import RatedEvents, nearest_autocorrelation
from mot_sim.simulation.sensors.jitter import UNSURE_SCORE, edge_errors, move_edges
from mot_sim.simulation.sensors.misses import VISIBLE_KNOTS
from mot_sim.simulation.sensors.multiplicity import (
    MAX_JUMP_IOU,
    MIN_DUPLICATE_IOU,
    Duplicates,
)
from mot_sim.simulation.sensors.quantiles import Quantiles
from tracker.geometry import box_iou

MAX_DUPLICATE_RATE = 0.5  # no rate of second boxes is higher
MIN_SAMPLE = 8  # boxes from which a distribution is taken; fewer give the plain default
SCORE_QUANTILES = 41  # few boxes have the high scores that trackers take for sure
LIFETIME_LAGS = (1, 2, 3, 5, 8)
MIN_TWIN_IOU = 0.5  # of a second box with the first one, from which they are twins
MAX_EXAMPLES = 64  # of second boxes that a profile keeps
MAX_LIFETIME_SECONDS = 1.2  # seconds on average: what is seen for longer moves through the image


class FalseCounts(NamedTuple):
    """How many false boxes there are, on average over some simulations."""

    own: float
    """Of labelled cars before and after their labels."""
    near: float
    """Of the others, about labelled cars."""
    far: float
    """The rest."""


def false_counts(
    measured: Sequence[DetectorMeasurements], drives: Sequence[LabelledDetections], step: float
) -> FalseCounts:
    """Of what was measured of the drives, real or made."""
    own = near = total = 0
    for each in measured:
        mine = of_lives(each.false, drives, step)
        own += int(mine.sum())
        near += int(((each.false.iou >= MIN_DUPLICATE_IOU) & ~mine).sum())
        total += len(mine)
    count = len(measured)
    return FalseCounts(own / count, near / count, (total - own - near) / count)


def fit_duplicates(measured: DetectorMeasurements, step: float) -> Duplicates | None:
    """Second boxes by visible fraction; None when there are too few to tell."""
    found, false = measured.found, measured.false
    trucks = found.sightings.kinds == "Truck"
    about = (false.iou >= MIN_DUPLICATE_IOU) & ~((false.iou >= 0.5) & trucks[false.nearest])
    if about.sum() < MIN_SAMPLE:
        return None
    beside = about & ~handed_over(measured)  # the others are left behind where boxes jump
    if beside.sum() >= MIN_SAMPLE:
        about = beside
    second = false.select(about)
    event = np.zeros(len(found), bool)
    event[second.nearest] = True
    rates = np.zeros(len(found))
    tables = []
    level = np.abs(found.sightings.visible[:, None] - np.array(VISIBLE_KNOTS)).argmin(axis=1)
    for group in (found.hit, ~found.hit):
        table = [_rate(event[group & (level == number)]) for number in (1, 2, 3)]
        table = [table[0], *table]  # labels tell nothing of what is nearly hidden
        rates[group] = np.interp(found.sightings.visible[group], VISIBLE_KNOTS, table)
        tables.append(tuple(table))
    events = RatedEvents(event, rates, found.ids, found.frames)
    autocorrelation = latent_autocorrelation(events, step)
    seen, missed = tables
    moves = box_errors(second.boxes, first_boxes(found)[second.nearest])
    examples = np.column_stack((moves, second.log_odds))
    examples = examples[np.lexsort((examples[:, 2], examples[:, 0]))]
    chosen = np.linspace(0, len(examples) - 1, min(len(examples), MAX_EXAMPLES)).round()
    columns = examples[chosen.astype(int)].round(4).T.tolist()
    dx, dy, dw, dh, odds = (tuple(column) for column in columns)
    return Duplicates(seen, missed, dx, dy, dw, dh, odds, autocorrelation=autocorrelation)


def jumps(found: Found) -> tuple[Int[Array, " k"], Int[Array, " k"]]:
    """Rows of cars before and after their box jumped, their own motion aside."""
    rows = np.flatnonzero(found.hit)
    before, after = (rows[each] for each in lagged(found.ids[rows], found.frames[rows], 1))
    unit = np.array([0.0, 0.0, 1.0, 1.0])
    far = box_iou(unit + found.edges[before], unit + found.edges[after]) < MAX_JUMP_IOU
    return before[far], after[far]


def handed_over(measured: DetectorMeasurements) -> Bool[Array, " m"]:
    """Which false boxes are twins that a tracker may take for the car: of the two boxes the second
    one is nearer to that of a frame before or after, or the car has no box then."""
    found, false = measured.found, measured.false
    unit = np.array([0.0, 0.0, 1.0, 1.0])
    twins = np.flatnonzero(are_twins(measured))
    rows = false.nearest[twins]
    first = unit + found.edges[rows]
    second = unit + edge_errors(false.boxes[twins], found.sightings.boxes[rows])
    over = np.zeros(len(twins), bool)
    earlier, later = lagged(found.ids, found.frames, 1)
    for row, other in ((later, earlier), (earlier, later)):
        beside = np.full(len(found), -1)
        beside[row] = other
        known = beside[rows]
        box = unit + found.edges[known]  # NaN where the car was not found
        over |= (known < 0) | ~(box_iou(box, second) <= box_iou(box, first))
    handed = np.zeros(len(false), bool)
    handed[twins[over]] = True
    return handed


def handed_over_counts(measured: Sequence[DetectorMeasurements]) -> Float[Array, " 2"]:
    """How many there are beside a first box that is sure, and beside one that is not, on average
    over some simulations."""
    return _by_score(
        [each.found.log_odds[each.false.nearest[handed_over(each)]] for each in measured]
    )


def jump_counts(measured: Sequence[DetectorMeasurements]) -> Float[Array, " 2"]:
    """How many boxes jump that are sure, and that are not, on average over some simulations."""
    return _by_score([each.found.log_odds[jumps(each.found)[1]] for each in measured])


def _by_score(log_odds: Sequence[Float[Array, " n"]]) -> Float[Array, " 2"]:
    """Means over simulations of how many boxes have a score from UNSURE_SCORE, and a lower one."""
    unsure = [int((expit(each) < UNSURE_SCORE).sum()) for each in log_odds]
    total = [len(each) for each in log_odds]
    return np.array([np.mean(total) - np.mean(unsure), np.mean(unsure)])


def are_twins(measured: DetectorMeasurements) -> Bool[Array, " m"]:
    """Which false boxes overlap the first box of the car that they are about by half or more."""
    false, near = measured.false, measured.false.nearest
    iou = box_iou(first_boxes(measured.found)[near], false.boxes)
    return (near >= 0) & measured.found.hit[near] & (iou >= MIN_TWIN_IOU)


def first_boxes(found: Found) -> Float[Array, "n 4"]:
    """The boxes of those who were found; of the others what is labelled."""
    return move_edges(found.sightings.boxes, np.where(found.hit[:, None], found.edges, 0.0))


def _rate(event: Bool[Array, " n"]) -> float:
    return round(
        float(np.clip((event.sum() + 0.1) / (len(event) + 1.0), 0.0, MAX_DUPLICATE_RATE)), 5
    )


def fit_clutter(measured: DetectorMeasurements, step: float) -> Clutter | None:
    """False alarms far from every labelled car; None when there are too few to tell."""
    false_alarms = measured.false.select(measured.false.iou < MIN_DUPLICATE_IOU)
    if len(false_alarms) < MIN_SAMPLE:
        return None
    height = false_alarms.boxes[:, 3] - false_alarms.boxes[:, 1]
    width = false_alarms.boxes[:, 2] - false_alarms.boxes[:, 0]
    centre = 0.5 * (false_alarms.boxes[:, 0] + false_alarms.boxes[:, 2]) / false_alarms.width
    return Clutter(
        rate=len(false_alarms) / measured.frame_count,
        autocorrelation=_lives(false_alarms, step),
        height=Quantiles.of(height),
        aspect=Quantiles.of(width / height),
        x=Quantiles.of(centre),
        log_odds=Quantiles.of(false_alarms.log_odds, SCORE_QUANTILES),
    )


def _lives(false_alarms: FalseBoxes, step: float) -> Autocorrelation:
    """Shares of false alarms by lifetime, from how many are still there after a while."""
    kept = [len(linked(false_alarms, lag)[0]) / len(false_alarms) for lag in LIFETIME_LAGS]
    return nearest_autocorrelation(
        [lag * step for lag in LIFETIME_LAGS],
        kept,
        [1.0] * len(LIFETIME_LAGS),
        MAX_LIFETIME_SECONDS,
    )
