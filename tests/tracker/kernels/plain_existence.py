"""The probabilities of existence, and what tells of rows in gaps, in plain NumPy."""

import numpy as np
from jaxtyping import Bool, Float
from numpy import ndarray as Array

from tracker.car_filter import border_gaps, project_boxes
from tracker.existence import (
    LEAVING_MARGIN_PIXELS,
    MAX_COVERED_SHARE,
    MAX_PROBABILITY,
    MIN_KNOWN_HITS,
    DetectorStatistics,
    ExistenceFilter,
    ExistenceUpdate,
)
from tracker.gap_rows import LEAVING_MARGIN, LOG_HEIGHTS, LOG_HITS, LOGITS, MIN_STD
from tracker.geometry import covered_share
from tracker.lifecycle import MAX_CONSECUTIVE_STEPS, ActiveTracks, Partners
from tracker.types import Camera, CarEstimates, Detections


def plain_existence(
    how: ExistenceFilter,
    detector: DetectorStatistics,
    tracks: ActiveTracks,
    partners: Partners,
    found: Detections,
    dt: float,
    camera: Camera,
) -> ExistenceUpdate:
    """What `ExistenceFilter` makes of a frame."""
    matched, unmatched = tracks.select(partners.rows), tracks.select(partners.missed)
    scores = found.scores[partners.columns]
    covered = covered_share(unmatched.beliefs.boxes, found.boxes)
    learned = plain_learned(detector, matched, unmatched, covered, dt, camera)
    prior = how.detection_prior
    detected = (learned.hits + how.detection_probability * prior) / (learned.tries + prior)
    prior = how.birth_prior
    confirmed = learned.confirmed + how.birth_probability * prior
    worth = min(1.0, confirmed / (learned.newborns + prior) / max(detected, 0.5))

    def newborn(of: Float[Array, " n"]) -> Float[Array, " n"]:
        return np.minimum(np.maximum(of, 0.0) * worth, MAX_PROBABILITY)

    before = matched.existence
    odds = before / (1.0 - before) * (how.likelihood_ratio * np.maximum(scores, 0.0))
    hit = np.minimum(np.maximum(odds / (1.0 + odds), newborn(scores)), MAX_PROBABILITY)
    missed, before = 1.0 - detected * (1.0 - covered), unmatched.existence
    after = tracks.existence.copy()
    after[partners.rows] = hit
    after[partners.missed] = before * missed / (1.0 - before * (1.0 - missed))
    return ExistenceUpdate(after, newborn(found.scores[partners.born]), learned)


def plain_learned(
    detector: DetectorStatistics,
    matched: ActiveTracks,
    unmatched: ActiveTracks,
    covered: Float[Array, " l"],
    dt: float,
    camera: Camera,
) -> DetectorStatistics:
    """What is known of the detector after a frame."""
    one_step = MAX_CONSECUTIVE_STEPS * dt
    hits = (matched.hits >= MIN_KNOWN_HITS).sum()
    confirmed = ((matched.hits == 1) & (matched.time_since_update <= one_step)).sum()
    boxes, first = unmatched.beliefs.boxes, unmatched.time_since_update <= one_step
    right = camera.image_size[0] - 1.0 - LEAVING_MARGIN_PIXELS
    plain = first & (covered < MAX_COVERED_SHARE)
    plain = plain & (boxes[:, 0] >= LEAVING_MARGIN_PIXELS) & (boxes[:, 2] <= right)
    misses = (plain & (unmatched.hits >= MIN_KNOWN_HITS)).sum()
    vanished = (plain & (unmatched.hits == 1)).sum()
    return DetectorStatistics(
        detector.hits + hits,
        detector.tries + hits + misses,
        detector.confirmed + confirmed,
        detector.newborns + confirmed + vanished,
    )


def plain_written(
    how: ExistenceFilter, tracks: ActiveTracks, since_look: float
) -> Bool[Array, " n"]:
    """Which tracks are put out."""
    in_box = np.exp(tracks.time_since_update * (-1.0 / how.prediction_lifetime))
    established = (tracks.hits > 1) | (tracks.time_since_update <= since_look)
    return (tracks.existence * in_box >= how.threshold) & established


def plain_gap_features(
    tracks: ActiveTracks, estimates: CarEstimates, camera: Camera
) -> Float[Array, "n 6"]:
    """What tells whether predicted boxes are right."""
    boxes = camera.clip_boxes(tracks.beliefs.boxes)
    sides = np.maximum(boxes[:, 2:] - boxes[:, :2], 1.0)
    _, jacobian = project_boxes(estimates.means, camera)
    across = jacobian[:, ::2]
    cov = across @ estimates.covs @ across.transpose(0, 2, 1)
    left, right = cov[:, 0, 0], cov[:, 1, 1]
    place = 0.5 * (np.sqrt(left) + np.sqrt(right)) / sides[:, 0]
    width = np.sqrt(np.maximum(left + right - 2.0 * cov[:, 0, 1], 0.0)) / sides[:, 0]
    with np.errstate(divide="ignore"):
        existence = np.log(tracks.existence / (1.0 - tracks.existence))
    gap = border_gaps(boxes, camera)[:, ::2].min(axis=1)
    columns = (
        existence.clip(*LOGITS),
        np.log(tracks.hits).clip(*LOG_HITS),
        np.log(place + MIN_STD),
        np.log(width + MIN_STD),
        np.log(sides[:, 1]).clip(*LOG_HEIGHTS),
        (gap < LEAVING_MARGIN).astype(float),
    )
    return np.stack(columns, axis=1)
