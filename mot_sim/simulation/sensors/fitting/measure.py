"""What a detector did on labelled drives: who was found, how far off boxes were, what was false."""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, Int
from numpy import ndarray as Array
from scipy.special import logit

from mot_sim.datasets.recorded import DetectionLog
from mot_sim.metrics.matching import EPSILON, same_frame_pairs
from mot_sim.metrics.preprocessing import (
    PreparedSequence,
    ignored_if_unmatched,
    match_cars,
    prepare_sequence,
)
from mot_sim.simulation.sensors.boxes import box_errors
from mot_sim.simulation.sensors.sightings import Sightings
from tracker.geometry import box_iou
from tracker.types import Camera, Rows, Tracks

DRIVE_ID_STRIDE = 1_000_000  # between the ids of two drives
MIN_SCORE_DISTANCE = 1e-6  # scores are taken as at least this far from 0 and 1


@dataclass(frozen=True, eq=False)
class LabelledDetections:
    """A labelled drive and what a detector gave on it."""

    labels: Tracks
    log: DetectionLog
    frame_count: int
    camera: Camera


@dataclass(frozen=True, eq=False)
class Found(Rows):
    """A row a labelled car, van or truck in a frame, ids unique over all drives.

    scored: cars and vans, which boxes are matched to. counted: those that must be found.
    hit: matched (IoU >= .5, one to one). errors: dx, dy, dw, dh of `box_errors`; edges: in parts
    of the sides; log_odds: of the score; NaN where not hit.
    """

    sightings: Sightings
    ids: Int[Array, " n"]
    scored: Bool[Array, " n"]
    counted: Bool[Array, " n"]
    hit: Bool[Array, " n"]
    errors: Float[Array, "n 4"]
    edges: Float[Array, "n 4"]
    log_odds: Float[Array, " n"]

    @property
    def frames(self) -> Int[Array, " n"]:
        """Inside each drive."""
        return self.sightings.frames


@dataclass(frozen=True, eq=False)
class FalseBoxes(Rows):
    """A row a false positive. nearest: the row of `Found` that it overlaps most, by iou; or -1."""

    drives: Int[Array, " n"]
    frames: Int[Array, " n"]
    boxes: Float[Array, "n 4"]
    log_odds: Float[Array, " n"]
    nearest: Int[Array, " n"]
    iou: Float[Array, " n"]
    width: Float[Array, " n"]


@dataclass(frozen=True, eq=False)
class DetectorMeasurements:
    """All of it, over some drives."""

    found: Found
    false: FalseBoxes
    frame_count: int

    @property
    def recall(self) -> float:
        """Over the counted labels."""
        return float(self.found.hit[self.found.counted].mean())

    @property
    def precision(self) -> float:
        """Matched counted labels over those and the false positives."""
        hits = float(self.found.hit[self.found.counted].sum())
        return hits / max(hits + len(self.false), 1.0)

    @property
    def false_per_frame(self) -> float:
        """False positives a frame."""
        return len(self.false) / max(self.frame_count, 1)


def measure(drives: Iterable[LabelledDetections]) -> DetectorMeasurements:
    """The detections of all drives against their labels, by TrackEval's rules for cars."""
    found: list[Found] = []
    false: list[FalseBoxes] = []
    frames, rows = 0, 0
    for number, drive in enumerate(drives):
        mine, wrong = _measure_drive(drive, number)
        nearest = np.where(wrong.nearest >= 0, wrong.nearest + rows, -1)
        columns = [getattr(wrong, name) for name in wrong.__match_args__]
        columns[4] = nearest
        found.append(mine)
        false.append(FalseBoxes(*columns))
        frames, rows = frames + drive.frame_count, rows + len(mine)
    return DetectorMeasurements(Found.concatenate(found), FalseBoxes.concatenate(false), frames)


def _measure_drive(drive: LabelledDetections, number: int) -> tuple[Found, FalseBoxes]:
    boxes, scores = drive.log.detections.boxes, drive.log.detections.scores
    output = Tracks(drive.log.frames, np.arange(len(boxes)), boxes, scores)
    contest = prepare_sequence(drive.labels, output, drive.frame_count)
    pairs = match_cars(contest.overlaps)
    sightings = Sightings.from_labels(drive.labels)
    scored = np.isin(sightings.kinds, ("Car", "Van"))
    rows = np.flatnonzero(scored)[contest.overlaps.rows[pairs]]
    columns = contest.overlaps.columns[pairs]
    log_odds = logit(scores.clip(MIN_SCORE_DISTANCE, 1.0 - MIN_SCORE_DISTANCE))
    found = _found(sightings, scored, contest, rows, boxes[columns], log_odds[columns], number)
    wrong = np.ones(len(boxes), bool)
    wrong[columns] = False
    wrong &= ~ignored_if_unmatched(contest, EPSILON)
    frames, boxes = drive.log.frames[wrong], boxes[wrong]
    nearest, iou = _nearest(frames, boxes, sightings)
    width = np.full(len(frames), float(drive.camera.image_size[0]))
    here = np.full(len(frames), number)
    return found, FalseBoxes(here, frames, boxes, log_odds[wrong], nearest, iou, width)


def _found(
    sightings: Sightings,
    scored: Bool[Array, " n"],
    contest: PreparedSequence,
    rows: Int[Array, " k"],
    boxes: Float[Array, "k 4"],
    log_odds: Float[Array, " k"],
    number: int,
) -> Found:
    count = len(sightings)
    counted, hit = np.zeros(count, bool), np.zeros(count, bool)
    counted[np.flatnonzero(scored)] = ~contest.neutral
    hit[rows] = True
    errors, edges = np.full((count, 4), np.nan), np.full((count, 4), np.nan)
    true, odds = sightings.boxes[rows], np.full(count, np.nan)
    errors[rows] = box_errors(boxes, true)
    edges[rows] = (boxes - true) / np.tile(true[:, 2:] - true[:, :2], (1, 2))
    odds[rows] = log_odds
    ids = sightings.ids + DRIVE_ID_STRIDE * number
    return Found(sightings, ids, scored, counted, hit, errors, edges, odds)


def _nearest(
    frames: Int[Array, " m"], boxes: Float[Array, "m 4"], sightings: Sightings
) -> tuple[Int[Array, " m"], Float[Array, " m"]]:
    """The sighting that each box overlaps most, and by how much; -1 where none is touched."""
    nearest, best = np.full(len(boxes), -1), np.zeros(len(boxes))
    mine, theirs = same_frame_pairs(frames, sightings.frames)
    iou = box_iou(boxes[mine], sightings.boxes[theirs])
    order = np.argsort(iou, kind="stable")  # the largest is written last
    order = order[iou[order] > 0.0]
    nearest[mine[order]], best[mine[order]] = theirs[order], iou[order]
    return nearest, best
