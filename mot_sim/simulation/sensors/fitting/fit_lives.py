"""Fits how long cars are seen before their first label and after their last one."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, Int
from numpy import ndarray as Array

from mot_sim.metrics.matching import same_frame_pairs
from mot_sim.simulation.sensors.fitting.measure import (
    FalseBoxes,
    LabelledDetections,
    ScoredSightings,
    log_odds_of,
)
from mot_sim.simulation.sensors.lives import (
    IN_DONT_CARE,
    LIFE_SECONDS,
    Lives,
    beside_labels,
    extrapolated,
)
from mot_sim.simulation.sensors.sightings import Sightings
from tracker.geometry import box_iou
from tracker.types import Rows

MIN_LIFE_IOU = 0.35  # with the extrapolated box, from which a detection is of that car
MIN_CARS = 10  # at a time from the label; with fewer, cars live no longer than that
ALL = (1.0,) * len(LIFE_SECONDS)
ALL_LIVES = Lives(ALL, ALL, ALL, ALL)


@dataclass(frozen=True, eq=False)
class SeenLives(Rows):
    """Whether cars were detected where they would be before and after their labels."""

    lags: Int[Array, " n"]
    """Frames from the label, < 0 before the first one."""
    seen: Bool[Array, " n"]
    """Whether a detection lies there that overlaps no other label more."""
    inside: Bool[Array, " n"]
    """Whether the place lies in a DontCare region."""


def seen_lives(
    drives: Sequence[LabelledDetections], step: float
) -> tuple[SeenLives, ScoredSightings]:
    """All cars of all drives, for all of LIFE_SECONDS inside the drives, and what was found of
    them, with its scores."""
    parts = [SeenLives(np.zeros(0, np.int64), np.zeros(0, bool), np.zeros(0, bool))]
    scored = []
    for drive in drives:
        sightings = Sightings.from_labels(drive.labels)
        lags, rows = beside_labels(sightings, drive.camera, drive.frame_count, step, drive.labels)
        assert rows.unlabelled is not None
        seen = np.zeros(len(rows), bool)
        detections = drive.log.detections
        mine, theirs = life_pairs(drive.log.frames, detections.boxes, sightings, rows)
        seen[mine] = True
        parts.append(SeenLives(lags, seen, rows.unlabelled == IN_DONT_CARE))
        odds = log_odds_of(detections.scores[theirs])
        scored.append(ScoredSightings(rows.select(mine), odds))
    return SeenLives.concatenate(parts), ScoredSightings.concatenate(scored)


def life_pairs(
    frames: Int[Array, " m"], boxes: Float[Array, "m 4"], sightings: Sightings, lives: Sightings
) -> tuple[Int[Array, " k"], Int[Array, " k"]]:
    """Pairs of a row of the lives and a box that is of that car, and of no label."""
    elsewhere = largest_iou(frames, boxes, sightings)
    mine, theirs = same_frame_pairs(lives.frames, frames)
    iou = box_iou(lives.boxes[mine], boxes[theirs])
    good = (iou >= MIN_LIFE_IOU) & (iou > elsewhere[theirs])
    return mine[good], theirs[good]


def largest_iou(
    frames: Int[Array, " m"], boxes: Float[Array, "m 4"], sightings: Sightings
) -> Float[Array, " m"]:
    """The largest IoU of each box with a label of its frame."""
    mine, theirs = same_frame_pairs(frames, sightings.frames)
    best = np.zeros(len(boxes))
    np.maximum.at(best, mine, box_iou(boxes[mine], sightings.boxes[theirs]))
    return best


def of_lives(
    false: FalseBoxes, drives: Sequence[LabelledDetections], step: float
) -> Bool[Array, " m"]:
    """Which false boxes are of labelled cars, before or after their labels."""
    found = np.zeros(len(false), bool)
    for number, drive in enumerate(drives):
        rows = np.flatnonzero(false.drives == number)
        sightings = Sightings.from_labels(drive.labels)
        _, lives = extrapolated(sightings, drive.camera, drive.frame_count, step)
        _, theirs = life_pairs(false.frames[rows], false.boxes[rows], sightings, lives)
        found[rows[theirs]] = True
    return found


def fit_lives(real: SeenLives, made: SeenLives, step: float) -> Lives:
    """The shares of cars that are there.

    made: what the detector's model sees of ALL_LIVES: of those who are there it finds a part.
    """
    tables = []
    for inside in (False, True):
        one, other = (each.select(each.inside == inside) for each in (real, made))
        tables += [_shares(one, other, side, step) for side in (-1, 1)]
    return Lives(*tables)


def _shares(real: SeenLives, made: SeenLives, side: int, step: float) -> tuple[float, ...]:
    """On one side of the labels: seen over seen by the model, never rising."""
    shares = []
    for seconds in LIFE_SECONDS:
        rates, counts = [], []
        for each in (real, made):
            at = np.abs(side * each.lags * step - seconds) < 0.5 * step + 1e-9
            rates.append(float(each.seen[at].mean()) if at.any() else 0.0)
            counts.append(int(at.sum()))
        known = min(counts) >= MIN_CARS and rates[1] > 0.0
        shares.append(min(rates[0] / rates[1], 1.0) if known else 0.0)
    falling: list[float] = np.minimum.accumulate(shares).round(4).tolist()
    return tuple(falling)
