"""What a detector did on labelled drives: who was found, how far off boxes were, what was false."""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, Int
from numpy import ndarray as Array
from scipy.special import logit

from mot_sim.datasets import KittiSequence
from mot_sim.datasets.recorded import DetectionLog
from mot_sim.metrics.matching import EPSILON, same_frame_pairs
from mot_sim.metrics.preprocessing import (
    PreparedSequence,
    ignored_if_unmatched,
    match_cars,
    prepare_sequence,
)
from mot_sim.simulation.sensors.jitter import edge_errors
from mot_sim.simulation.sensors.sightings import Sightings
from tracker.errors import BadConfig
from tracker.geometry import box_iou
from tracker.types import Camera, Rows, Tracks

DRIVE_ID_STRIDE = 1_000_000  # between the ids of two drives
MIN_SCORE_DISTANCE = 1e-6  # scores are taken as at least this far from 0 and 1


@dataclass(frozen=True, eq=False)
class LabelledDetections:
    """A labelled drive and what a detector gave on it."""

    labels: Tracks
    """KITTI's labels of the drive."""
    log: DetectionLog
    """What the detector gave."""
    frame_count: int
    """Frames of the drive."""
    camera: Camera
    """The camera of the drive."""

    @classmethod
    def of(cls, drive: KittiSequence, labels: Tracks | None = None) -> "LabelledDetections":
        """A drive with its own labels, or with these. Raises BadConfig for one without labels."""
        labels = drive.truth if labels is None else labels
        if labels is None:
            raise BadConfig(f"drive {drive.name} has no labels")
        return cls(labels, drive.log, drive.frame_count, drive.camera)


@dataclass(frozen=True, eq=False)
class Found(Rows):
    """Which labels were found: one row for each labelled car, van or truck in a frame."""

    sightings: Sightings
    """What could be seen of it."""
    ids: Int[Array, " n"]
    """Id of the object, unique over all drives."""
    scored: Bool[Array, " n"]
    """Whether boxes are matched to it: cars and vans."""
    counted: Bool[Array, " n"]
    """Whether it must be found."""
    hit: Bool[Array, " n"]
    """Whether it was matched (IoU >= 0.5, one to one)."""
    edges: Float[Array, "n 4"]
    """Errors of the left, upper, right and lower edge, in parts of the sides; NaN where not hit."""
    log_odds: Float[Array, " n"]
    """Of the score; NaN where not hit."""

    @property
    def frames(self) -> Int[Array, " n"]:
        """Inside each drive."""
        return self.sightings.frames


@dataclass(frozen=True, eq=False)
class ScoredSightings(Rows):
    """What was found, with its scores."""

    sightings: Sightings
    """What could be seen."""
    log_odds: Float[Array, " n"]
    """Of the score."""


@dataclass(frozen=True, eq=False)
class FalseBoxes(Rows):
    """One row for each false positive."""

    drives: Int[Array, " n"]
    """Number of the drive."""
    frames: Int[Array, " n"]
    """Inside the drive."""
    boxes: Float[Array, "n 4"]
    """Pixels."""
    log_odds: Float[Array, " n"]
    """Of the score."""
    nearest: Int[Array, " n"]
    """Row of `Found` that it overlaps most; -1 where it touches none."""
    iou: Float[Array, " n"]
    """Overlap with that one, 0 to 1."""
    width: Float[Array, " n"]
    """Of the drive's image, pixels."""


@dataclass(frozen=True, eq=False)
class DetectorMeasurements:
    """What was measured of a detector over some drives."""

    found: Found
    """Which labels were found."""
    false: FalseBoxes
    """The false positives."""
    frame_count: int
    """Frames of all drives."""
    detection_count: int
    """Detections of all drives."""

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
    frames, rows, detections = 0, 0, 0
    for number, drive in enumerate(drives):
        mine, wrong = _measure_drive(drive, number)
        nearest = np.where(wrong.nearest >= 0, wrong.nearest + rows, -1)
        columns = [getattr(wrong, name) for name in wrong.__match_args__]
        columns[4] = nearest
        found.append(mine)
        false.append(FalseBoxes(*columns))
        frames, rows = frames + drive.frame_count, rows + len(mine)
        detections += len(drive.log.frames)
    return DetectorMeasurements(
        Found.concatenate(found), FalseBoxes.concatenate(false), frames, detections
    )


def _measure_drive(drive: LabelledDetections, number: int) -> tuple[Found, FalseBoxes]:
    boxes, scores = drive.log.detections.boxes, drive.log.detections.scores
    output = Tracks(drive.log.frames, np.arange(len(boxes)), boxes, scores)
    contest = prepare_sequence(drive.labels, output, drive.frame_count)
    pairs = match_cars(contest.overlaps)
    sightings = Sightings.from_labels(drive.labels)
    scored = np.isin(sightings.kinds, ("Car", "Van"))
    rows = np.flatnonzero(scored)[contest.overlaps.rows[pairs]]
    columns = contest.overlaps.columns[pairs]
    log_odds = log_odds_of(scores)
    found = _found(sightings, scored, contest, rows, boxes[columns], log_odds[columns], number)
    wrong = np.ones(len(boxes), bool)
    wrong[columns] = False
    wrong &= ~ignored_if_unmatched(contest, EPSILON)
    frames, boxes = drive.log.frames[wrong], boxes[wrong]
    nearest, iou = _nearest(frames, boxes, sightings)
    width = np.full(len(frames), float(drive.camera.image_size[0]))
    here = np.full(len(frames), number)
    return found, FalseBoxes(here, frames, boxes, log_odds[wrong], nearest, iou, width)


def log_odds_of(scores: Float[Array, " n"]) -> Float[Array, " n"]:
    """Finite ones."""
    return logit(scores.clip(MIN_SCORE_DISTANCE, 1.0 - MIN_SCORE_DISTANCE))


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
    edges = np.full((count, 4), np.nan)
    odds = np.full(count, np.nan)
    edges[rows] = edge_errors(boxes, sightings.boxes[rows])
    odds[rows] = log_odds
    ids = sightings.ids + DRIVE_ID_STRIDE * number
    return Found(sightings, ids, scored, counted, hit, edges, odds)


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
