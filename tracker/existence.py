"""How sure it is that a track is an object: evidence instead of a count of hits."""

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float
from numpy import ndarray as Array

from tracker.errors import BadConfig
from tracker.geometry import box_area, box_intersection
from tracker.lifecycle import SKIPPED, ActiveTracks
from tracker.types import Camera

# Nothing is ever certain.
MOST = 0.999
# A box that ends this near to the left or right border (pixels) may be leaving.
LEAVING = 5.0
# Sightings after which a track's misses tell of the detector; boxes covered more do not.
KNOWN, HIDDEN = 3, 0.3


@dataclass(frozen=True)
class DetectorStatistics:
    """What the tracker saw of its detector.

    hits of tries: of known cars in plain view. confirmed of newborns: first sightings that were
    followed by a second one in the next frame.
    """

    hits: int = 0
    tries: int = 0
    confirmed: int = 0
    newborns: int = 0


class ExistenceUpdate(NamedTuple):
    """The probabilities of existence after a frame, and what it taught of the detector."""

    matched: Float[Array, " k"]
    unmatched: Float[Array, " l"]
    born: Float[Array, " b"]
    rates: DetectorStatistics


@dataclass(frozen=True)
class ExistenceFilter:
    """The probability that a track exists, by what was seen and what was missed.

    As in IPDA (Musicki, Evans, Stankovic, IEEE Trans. Automatic Control 1994), with the two
    rates of the detector learned on the way, so that the same settings serve a detector that
    misses every fifth car and one that misses none. A row is written out where a car is likelier
    than not: at once for newborns of a clean detector, at the second sighting where most
    newborns vanish again, and in gaps as long as the car should still be there.

    detection_probability, detection_prior: probability that a car in plain view is detected, to start from,
    and how many tries that is worth. birth_probability, birth_prior: the same of newborns that are seen again.
    likelihood_ratio: how much likelier a box is where a car is expected than anywhere else. mean_lifetime: mean
    seconds until a car leaves. prediction_lifetime: mean seconds until a predicted box no longer overlaps the
    car. threshold: on the probability, for writing out.
    """

    detection_probability: float = 0.95
    detection_prior: float = 50.0
    birth_probability: float = 0.9
    birth_prior: float = 20.0
    likelihood_ratio: float = 20.0
    mean_lifetime: float = 3.0
    prediction_lifetime: float = 2.0
    threshold: float = 0.5

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
        rates: DetectorStatistics,
        matched: ActiveTracks,
        lost: ActiveTracks,
        scores: tuple[Float[Array, " k"], Float[Array, " b"]],
        boxes: Float[Array, "m 4"],
        dt: float,
        camera: Camera,
    ) -> ExistenceUpdate:
        """The judgement of a frame: tracks as expected now, scores of the matched and the born.

        boxes: everything that was detected; who is behind one of them was no miss.
        """
        covered = covered_share(lost.beliefs.boxes, boxes)
        learned = self.learn(rates, matched, lost, covered, dt, camera)
        return ExistenceUpdate(
            self.hit(matched, scores[0], learned),
            self.miss(lost, covered, learned),
            self.newborn(scores[1], learned),
            learned,
        )

    def survival(self, dt: float) -> float:
        """The probability that a car is still there after `dt` seconds."""
        return math.exp(-dt / self.mean_lifetime)

    def detected(self, rates: DetectorStatistics) -> float:
        """P_D: the probability that a car in plain view is detected."""
        prior = self.detection_prior
        return (rates.hits + self.detection_probability * prior) / (rates.tries + prior)

    def newborn(self, scores: Float[Array, " b"], rates: DetectorStatistics) -> Float[Array, " b"]:
        """That a first sighting is a car: its score, if newborns have kept their word so far."""
        if len(scores) == 0:
            return scores
        prior = self.birth_prior
        kept = (rates.confirmed + self.birth_probability * prior) / (rates.newborns + prior)
        worth = min(1.0, kept / max(self.detected(rates), 0.5))
        return np.minimum(np.maximum(scores, 0.0) * worth, MOST)

    def hit(
        self, matched: ActiveTracks, scores: Float[Array, " k"], rates: DetectorStatistics
    ) -> Float[Array, " k"]:
        """Of tracks (as expected now) that were seen with these scores."""
        odds = (
            matched.existence
            / (1.0 - matched.existence)
            * (self.likelihood_ratio * np.maximum(scores, 0.0))
        )
        return np.minimum(np.maximum(odds / (1.0 + odds), self.newborn(scores, rates)), MOST)

    def miss(
        self, lost: ActiveTracks, covered: Float[Array, " l"], rates: DetectorStatistics
    ) -> Float[Array, " l"]:
        """Of tracks that were not seen, though only this share of their boxes is hidden."""
        missed = 1.0 - self.detected(rates) * (1.0 - covered)
        return lost.existence * missed / (1.0 - lost.existence * (1.0 - missed))

    def learn(
        self,
        rates: DetectorStatistics,
        matched: ActiveTracks,
        lost: ActiveTracks,
        covered: Float[Array, " l"],
        dt: float,
        camera: Camera,
    ) -> DetectorStatistics:
        """The rates after a frame."""
        soon = SKIPPED * dt
        hits = _count(matched.hits >= KNOWN)
        confirmed = _count((matched.hits == 1) & (matched.time_since_update <= soon))
        misses = vanished = 0
        if len(lost):
            boxes, first = lost.beliefs.boxes, lost.time_since_update <= soon
            right = camera.image_size[0] - 1.0 - LEAVING
            plain = first & (covered < HIDDEN) & (boxes[:, 0] >= LEAVING) & (boxes[:, 2] <= right)
            misses = _count(plain & (lost.hits >= KNOWN))
            vanished = _count(first & (lost.hits == 1))
        return DetectorStatistics(
            rates.hits + hits,
            rates.tries + hits + misses,
            rates.confirmed + confirmed,
            rates.newborns + confirmed + vanished,
        )

    def written(self, population: ActiveTracks) -> Bool[Array, " n"]:
        """Which tracks are likelier there, and in their box, than not."""
        there = population.existence * np.exp(
            population.time_since_update * (-1.0 / self.prediction_lifetime)
        )
        return (there >= self.threshold) & (
            (population.hits > 1) | (population.time_since_update <= 0.0)
        )


def _count(which: Bool[Array, " n"]) -> int:
    """How many are true."""
    return int(np.count_nonzero(which))


def covered_share(boxes: Float[Array, "n 4"], others: Float[Array, "m 4"]) -> Float[Array, " n"]:
    """The largest share of each box that one of the others, ending lower (nearer), covers."""
    if len(boxes) == 0 or len(others) == 0:
        return np.zeros(len(boxes))
    shared = box_intersection(boxes[:, None], others[None])
    shares = shared / np.maximum(box_area(boxes), 1e-6)[:, None]
    return np.where(others[None, :, 3] > boxes[:, None, 3], shares, 0.0).max(axis=1).clip(0.0, 1.0)
