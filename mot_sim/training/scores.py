"""How good keypoints are: PCK, and whether confidences are the probabilities that they claim."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, UInt8
from numpy import ndarray as Array

from mot_sim.simulation.truth import KeypointVisibility

MAX_ERROR_SHARE = 0.1  # of the longer side of the box: so near is right
CONFIDENCE_BINS = 10


@dataclass(frozen=True, eq=False)
class KeypointScores:
    """Predicted keypoints beside true ones. right: near the true place. seen: truly visible."""

    right: Bool[Array, "n k"]
    seen: Bool[Array, "n k"]
    confidence: Float[Array, "n k"]

    @property
    def pck(self) -> float:
        """The share of the visible keypoints that are right."""
        return float(self.right[self.seen].mean()) if self.seen.any() else float("nan")

    @property
    def claimed(self) -> Float[Array, "b 3"]:
        """For confidences of 0 to .1, .1 to .2, ...: mean, share seen and right, how many."""
        rows = np.minimum((self.confidence * CONFIDENCE_BINS).astype(np.int64), CONFIDENCE_BINS - 1)
        good, table = self.right & self.seen, np.full((CONFIDENCE_BINS, 3), np.nan)
        for row in range(CONFIDENCE_BINS):
            some = rows == row
            table[row, 2] = some.sum()
            if some.any():
                table[row, :2] = self.confidence[some].mean(), good[some].mean()
        return table

    @property
    def doubt(self) -> float:
        """Mean difference between confidence and share that is seen and right, over all points."""
        mean, good, count = np.nan_to_num(self.claimed).T
        return float((np.abs(mean - good) * count).sum() / max(count.sum(), 1.0))


def score_keypoints(
    found: Float[Array, "n k 3"],
    keypoints: Float[Array, "n k 2"],
    states: UInt8[Array, "n k"],
    longer: Float[Array, " n"],
    share: float = MAX_ERROR_SHARE,
) -> KeypointScores:
    """Found points (x, y, confidence) beside true ones; longer: sides of boxes, same unit."""
    seen = states == KeypointVisibility.VISIBLE
    apart = found[:, :, :2] - np.where(seen[:, :, None], keypoints, 0.0)
    off = np.hypot(apart[:, :, 0], apart[:, :, 1])
    return KeypointScores((off <= share * longer[:, None]) & seen, seen, found[:, :, 2])
