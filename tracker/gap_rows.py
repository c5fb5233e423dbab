"""Whether the predicted box of a car that was not detected is worth a row."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from jaxtyping import Bool, Float, Int
from numpy import ndarray as Array

from tracker.car_filter.projection import CUBOID_EDGES
from tracker.errors import BadConfig
from tracker.kernels import Kernel
from tracker.lifecycle import ActiveTracks
from tracker.types import Camera, CarEstimates
from tracker.types.cuboids import CORNERS

# A box that ends this near to the left or right border, px, is leaving.
LEAVING_MARGIN = 3.0
# Between these the model tells boxes apart: logits of existence, logarithms of hits and of
# heights (px), and of standard deviations in box widths.
LOGITS, LOG_HITS, LOG_HEIGHTS = (-6.0, 7.0), (0.0, 4.0), (3.2, 6.0)
MIN_STD = 0.01
LIMITS = np.array([LOGITS, LOG_HITS, LOG_HEIGHTS])
TELL_GAPS = Kernel("tracker.kernels.gaps", "tell_gaps")
WEIGH_GAPS = Kernel("tracker.kernels.gaps", "weigh_gaps")


@dataclass(frozen=True)
class GapRows:
    """The probability that the predicted box of an undetected car overlaps it by half: logistic.

    What decides is how well the box is known, whether the car has long been seen, and its size: a
    large box that nobody detected is hardly ever there. Fitted over KITTI's ten given drives and
    four detectors by `python -m benchmarks.gap_rows`, which prints the weights.
    """

    intercept: float = 0.57
    """What the others are added to."""
    existence: float = 0.29
    """Weight of the logit of the track's existence."""
    hits: float = 0.75
    """Weight of the logarithm of its hits."""
    place: float = -2.79
    """Weight of the logarithm of the std of its left and right edge, box widths."""
    width: float = 1.08
    """Weight of the logarithm of the std of its width, box widths."""
    height: float = -1.25
    """Weight of the logarithm of its height, px."""
    leaving: float = -1.34
    """Weight of whether it ends at the image's left or right border."""
    threshold: float = 0.5
    """Probability from which a row is put out, 0 < threshold < 1; more: fewer false and fewer true
    rows."""

    def __post_init__(self) -> None:
        if not 0.0 < self.threshold < 1.0:
            raise BadConfig(f"threshold {self.threshold:g}: give a probability between 0 and 1")

    @property
    def weights(self) -> tuple[float, ...]:
        """The intercept, then those of `gap_features` in their order."""
        others = self.existence, self.hits, self.place, self.width, self.height, self.leaving
        return (self.intercept, *others)

    @cached_property
    def _weights(self) -> Float[Array, "7"]:
        """The same as an array."""
        return np.array(self.weights)

    def __call__(
        self, tracks: ActiveTracks, estimates: CarEstimates, camera: Camera
    ) -> tuple[Float[Array, " n"], Bool[Array, " n"]]:
        """That the boxes of undetected tracks are right, and which of them are put out.

        estimates: of the cars behind them. What was detected only once is not put out.
        """
        return self._judged(gap_features(tracks, estimates, camera), tracks.hits)

    def of_some(
        self,
        rows: Int[Array, " k"],
        tracks: ActiveTracks,
        estimates: CarEstimates,
        camera: Camera,
    ) -> tuple[Float[Array, " k"], Bool[Array, " k"]]:
        """The same of some of the tracks; a class of one's own is called with these alone."""
        if type(self).__call__ is not GapRows.__call__:
            return self(tracks.replaced(cars=None).take(rows), estimates.take(rows), camera)
        hits = tracks.hits.take(rows)
        told = tracks.beliefs.boxes.take(rows, 0), tracks.existence.take(rows), hits
        believed = estimates.means.take(rows, 0), estimates.covs.take(rows, 0)
        return self._judged(_features(*told, *believed, camera), hits)

    def _judged(
        self, features: Float[Array, "n 6"], hits: Int[Array, " n"]
    ) -> tuple[Float[Array, " n"], Bool[Array, " n"]]:
        """Probabilities by features, and what is put out."""
        logits = np.empty(len(hits))
        WEIGH_GAPS(features, self._weights, logits)
        probabilities: Float[Array, " n"] = 1.0 / (1.0 + np.exp(-logits))
        return probabilities, (probabilities >= self.threshold) & (hits > 1)


def gap_features(
    tracks: ActiveTracks, estimates: CarEstimates, camera: Camera
) -> Float[Array, "n 6"]:
    """What tells whether predicted boxes are right, in the order of the weights of `GapRows`."""
    told = tracks.beliefs.boxes, tracks.existence, tracks.hits
    return _features(*told, estimates.means, estimates.covs, camera)


def _features(
    boxes: Float[Array, "n 4"],
    existence: Float[Array, " n"],
    hits: Int[Array, " n"],
    means: Float[Array, "n 9"],
    covs: Float[Array, "n 9 9"],
    camera: Camera,
) -> Float[Array, "n 6"]:
    """The same, of the columns that tell something."""
    features = np.empty((len(boxes), 6))
    lens = camera.P_road, camera.far_corner, CORNERS, CUBOID_EDGES
    given = boxes, existence, hits, means, covs
    TELL_GAPS(*given, *lens, LIMITS, MIN_STD, LEAVING_MARGIN, features)
    return features
