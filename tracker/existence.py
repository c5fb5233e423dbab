"""The probability that a track is an object, instead of a count of hits."""

import math
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float
from numpy import ndarray as Array

from tracker.errors import BadConfig
from tracker.kernels import Kernel
from tracker.lifecycle import MAX_CONSECUTIVE_STEPS, ActiveTracks, Partners
from tracker.types import Camera, Detections

# No track ever exists for certain.
MAX_PROBABILITY = 0.999
# A box that ends this near to the left or right border (pixels) may be leaving.
LEAVING_MARGIN_PIXELS = 5.0
# Hits after which a track's misses tell of the detector.
MIN_KNOWN_HITS = 3
# A box of which more is covered by another one tells nothing of it.
MAX_COVERED_SHARE = 0.3
LIMITS = np.array([MIN_KNOWN_HITS, MAX_COVERED_SHARE, LEAVING_MARGIN_PIXELS, MAX_PROBABILITY])
JUDGE_ROWS = Kernel("tracker.kernels.existing", "judge_rows")
CHOOSE_WRITTEN = Kernel("tracker.kernels.existing", "choose_written")


class DetectorStatistics(NamedTuple):
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

    tracks: Float[Array, " n"]
    """Probability, 0 to 1, that each track is an object, detected or not."""
    born: Float[Array, " b"]
    """The same of each detection that begins a track."""
    detector: DetectorStatistics
    """What is known of the detector after this frame."""

    @classmethod
    def certain(
        cls, tracks: ActiveTracks, partners: Partners, detector: DetectorStatistics
    ) -> "ExistenceUpdate":
        """Without a filter: detections are objects, and other tracks stay as likely as before."""
        existence = tracks.existence.copy()
        existence[partners.rows] = 1.0
        return cls(existence, np.ones(len(partners.born)), detector)


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
        tracks: ActiveTracks,
        partners: Partners,
        found: Detections,
        dt: float,
        camera: Camera,
    ) -> ExistenceUpdate:
        """The probabilities after a frame, of tracks as predicted for it and of those that begin.

        found: all detections; a track that is hidden behind one of them was not missed.
        """
        rows, columns, missed, born = partners
        after, fresh = np.empty(len(tracks)), np.empty(len(born))
        learned = np.empty(4, np.int64)
        given = tracks.existence, tracks.hits, tracks.time_since_update, tracks.beliefs.boxes
        seen = rows, columns, missed, found.scores, born, found.boxes, np.array(detector)
        how = self.settings, MAX_CONSECUTIVE_STEPS * dt, LIMITS, leaving_border(camera)
        JUDGE_ROWS(*given, *seen, *how, after, fresh, learned)
        return ExistenceUpdate(after, fresh, DetectorStatistics(*learned.tolist()))

    def survival(self, dt: float) -> float:
        """The probability that a car is still there after `dt` seconds."""
        return math.exp(-dt / self.mean_lifetime)

    @cached_property
    def settings(self) -> Float[Array, "5"]:
        """What is assumed of detectors, and what a hit is worth, in the order of the fields."""
        detection = self.detection_probability, self.detection_prior
        birth = self.birth_probability, self.birth_prior
        return np.array((*detection, *birth, self.likelihood_ratio), float)

    def written(self, tracks: ActiveTracks, since_look: float = 0.0) -> Bool[Array, " n"]:
        """Which tracks are put out: those likelier there, and in their box, than not.

        since_look: seconds since a detector looked; 0: it did at this frame. A track that it saw
        once and missed then is not put out.
        """
        written = np.empty(len(tracks), bool)
        given = tracks.existence, tracks.hits, tracks.time_since_update
        how = self.prediction_lifetime, self.threshold, since_look
        CHOOSE_WRITTEN(*given, *how, written)
        return written


def leaving_border(camera: Camera) -> float:
    """Where the margin at the right border begins, in which boxes may be leaving, px."""
    return camera.image_size[0] - 1.0 - LEAVING_MARGIN_PIXELS
