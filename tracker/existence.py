"""The probability that a track is an object, instead of a count of hits."""

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float
from numpy import ndarray as Array

from tracker.errors import BadConfig
from tracker.geometry import covered_share
from tracker.lifecycle import MAX_CONSECUTIVE_STEPS, ActiveTracks
from tracker.types import Camera

# No track ever exists for certain.
MAX_PROBABILITY = 0.999
# A box that ends this near to the left or right border (pixels) may be leaving.
LEAVING_MARGIN_PIXELS = 5.0
# Hits after which a track's misses tell of the detector.
MIN_KNOWN_HITS = 3
# A box of which more is covered by another one tells nothing of it.
MAX_COVERED_SHARE = 0.3


@dataclass(frozen=True)
class DetectorStatistics:
    """What the tracker learned of its detector."""

    hits: int = 0
    """How many of `tries` were detected."""
    tries: int = 0
    """Frames in which a track with 3 hits or more was detected, or missed in plain view."""
    confirmed: int = 0
    """How many of `newborns` were detected again in the next frame."""
    newborns: int = 0
    """First detections in plain view whose next frame showed whether a second one followed."""


class ExistenceUpdate(NamedTuple):
    """The probabilities of existence after a frame, and what was learned of the detector."""

    matched: Float[Array, " k"]
    """Probability, 0 to 1, that each detected track is an object."""
    unmatched: Float[Array, " l"]
    """The same of each track that was not detected."""
    born: Float[Array, " b"]
    """The same of each detection that no track claims."""
    detector: DetectorStatistics
    """What is known of the detector after this frame."""

    @classmethod
    def certain(
        cls, matched: int, unmatched: ActiveTracks, born: int, detector: DetectorStatistics
    ) -> "ExistenceUpdate":
        """Without a filter: so many detections are objects, and tracks stay as likely as before."""
        return cls(np.ones(matched), unmatched.existence, np.ones(born), detector)


@dataclass(frozen=True)
class ExistenceFilter:
    """The probability that a track exists, by its hits and misses.

    As in IPDA (Musicki, Evans, Stankovic, IEEE Trans. Automatic Control 1994), with P_D and P_B
    of the detector learned on the way, so that the same settings serve a detector that misses
    every fifth car and one that misses none. A row is put out where a car is likelier than not:
    at once for newborns of a clean detector, at the second hit where most newborns vanish again,
    and in gaps as long as the car should still be there.
    """

    detection_probability: float = 0.95
    """P_D to start from: that a car in plain view is detected, 0 < P_D < 1; more: a miss costs more
    belief."""
    detection_prior: float = 50.0
    """How many tries `detection_probability` is worth, > 0; more: P_D is learned more slowly."""
    birth_probability: float = 0.9
    """P_B to start from: that a newborn is detected again, 0 < P_B < 1; more: new tracks are
    believed sooner."""
    birth_prior: float = 20.0
    """How many newborns `birth_probability` is worth, > 0; more: P_B is learned more slowly."""
    likelihood_ratio: float = 20.0
    """How much likelier a box is where a car is expected than anywhere else, > 0; more: a hit
    raises the probability further."""
    mean_lifetime: float = 3.0
    """Mean seconds until a car leaves, > 0; more: tracks that are not detected stay probable
    longer."""
    prediction_lifetime: float = 2.0
    """Mean seconds until a predicted box no longer overlaps its car, > 0; more: rows are put out
    longer in gaps."""
    threshold: float = 0.5
    """Probability from which a track is put out, 0 < threshold < 1; more: fewer false and fewer
    true rows."""

    def __post_init__(self) -> None:
        shares = {
            "detection_probability": self.detection_probability,
            "birth_probability": self.birth_probability,
            "threshold": self.threshold,
        }
        for name, share in shares.items():
            if not 0.0 < share < 1.0:
                raise BadConfig(f"{name} {share:g}: give a probability between 0 and 1")
        times = {
            "mean_lifetime": self.mean_lifetime,
            "prediction_lifetime": self.prediction_lifetime,
            "likelihood_ratio": self.likelihood_ratio,
        }
        priors = {"detection_prior": self.detection_prior, "birth_prior": self.birth_prior}
        for name, number in (times | priors).items():
            if not 0.0 < number < np.inf:
                raise BadConfig(f"{name} {number:g}: give a finite number above 0")

    def __call__(
        self,
        detector: DetectorStatistics,
        matched: ActiveTracks,
        unmatched: ActiveTracks,
        matched_scores: Float[Array, " k"],
        born_scores: Float[Array, " b"],
        boxes: Float[Array, "m 4"],
        dt: float,
        camera: Camera,
    ) -> ExistenceUpdate:
        """The probabilities after a frame, of tracks as predicted for it and of newborns.

        boxes: all detections; a track that is hidden behind one of them was not missed.
        """
        covered = covered_share(unmatched.beliefs.boxes, boxes)
        learned = self.learn(detector, matched, unmatched, covered, dt, camera)
        return ExistenceUpdate(
            self.hit(matched, matched_scores, learned),
            self.miss(unmatched, covered, learned),
            self.newborn(born_scores, learned),
            learned,
        )

    def survival(self, dt: float) -> float:
        """The probability that a car is still there after `dt` seconds."""
        return math.exp(-dt / self.mean_lifetime)

    def detected(self, detector: DetectorStatistics) -> float:
        """P_D: the probability that a car in plain view is detected."""
        prior = self.detection_prior
        return (detector.hits + self.detection_probability * prior) / (detector.tries + prior)

    def newborn(
        self, scores: Float[Array, " b"], detector: DetectorStatistics
    ) -> Float[Array, " b"]:
        """That a first detection is a car: its score, less where newborns have often vanished."""
        if len(scores) == 0:
            return scores
        prior = self.birth_prior
        confirmed = detector.confirmed + self.birth_probability * prior
        worth = min(
            1.0, confirmed / (detector.newborns + prior) / max(self.detected(detector), 0.5)
        )
        return np.minimum(np.maximum(scores, 0.0) * worth, MAX_PROBABILITY)

    def hit(
        self, matched: ActiveTracks, scores: Float[Array, " k"], detector: DetectorStatistics
    ) -> Float[Array, " k"]:
        """Of tracks (as predicted) that were detected with these scores."""
        odds = (
            matched.existence
            / (1.0 - matched.existence)
            * (self.likelihood_ratio * np.maximum(scores, 0.0))
        )
        return np.minimum(
            np.maximum(odds / (1.0 + odds), self.newborn(scores, detector)), MAX_PROBABILITY
        )

    def miss(
        self, unmatched: ActiveTracks, covered: Float[Array, " l"], detector: DetectorStatistics
    ) -> Float[Array, " l"]:
        """Of tracks that were not detected; covered: the share of their boxes that is hidden."""
        missed = 1.0 - self.detected(detector) * (1.0 - covered)
        return unmatched.existence * missed / (1.0 - unmatched.existence * (1.0 - missed))

    def learn(
        self,
        detector: DetectorStatistics,
        matched: ActiveTracks,
        unmatched: ActiveTracks,
        covered: Float[Array, " l"],
        dt: float,
        camera: Camera,
    ) -> DetectorStatistics:
        """What is known of the detector after a frame."""
        one_step = MAX_CONSECUTIVE_STEPS * dt
        hits = _count(matched.hits >= MIN_KNOWN_HITS)
        confirmed = _count((matched.hits == 1) & (matched.time_since_update <= one_step))
        misses = vanished = 0
        if len(unmatched):
            boxes, first = unmatched.beliefs.boxes, unmatched.time_since_update <= one_step
            right = camera.image_size[0] - 1.0 - LEAVING_MARGIN_PIXELS
            plain = (
                first
                & (covered < MAX_COVERED_SHARE)
                & (boxes[:, 0] >= LEAVING_MARGIN_PIXELS)
                & (boxes[:, 2] <= right)
            )
            misses = _count(plain & (unmatched.hits >= MIN_KNOWN_HITS))
            vanished = _count(plain & (unmatched.hits == 1))
        return DetectorStatistics(
            detector.hits + hits,
            detector.tries + hits + misses,
            detector.confirmed + confirmed,
            detector.newborns + confirmed + vanished,
        )

    def written(self, tracks: ActiveTracks, since_look: float = 0.0) -> Bool[Array, " n"]:
        """Which tracks are put out: those likelier there, and in their box, than not.

        since_look: seconds since a detector looked; 0: it did at this frame. A track that it saw
        once and missed then is not put out.
        """
        in_box = np.exp(tracks.time_since_update * (-1.0 / self.prediction_lifetime))
        established = (tracks.hits > 1) | (tracks.time_since_update <= since_look)
        return (tracks.existence * in_box >= self.threshold) & established


def _count(which: Bool[Array, " n"]) -> int:
    """How many are true."""
    return int(np.count_nonzero(which))
