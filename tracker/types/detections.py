"""The output of a detector for one frame."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy import ndarray as Array

from tracker.errors import BadDetections
from tracker.types.rows import Rows


@dataclass(frozen=True, eq=False)
class Detections(Rows):
    """Boxes with scores, and whatever cues were measured on them: each a column, or None.

    boxes: x_min, y_min, x_max, y_max in pixels. scores: any scale, larger is surer.
    yaw: radians about road +y. size: length, height, width in metres. shape: coefficients of
    eq. 1. keypoints: u, v, confidence. descriptor: psi of eq. 5.
    pose_cov: covariance of (yaw, shape), c = 1 + b.
    A NaN row in a cue column: the cue was not measured for that box.
    The constructor trusts its arguments; `Detections.of` checks them.
    """

    boxes: Float[Array, "n 4"]
    scores: Float[Array, " n"]
    yaw: Float[Array, " n"] | None = None
    size: Float[Array, "n 3"] | None = None
    shape: Float[Array, "n b"] | None = None
    keypoints: Float[Array, "n k 3"] | None = None
    descriptor: Float[Array, "n d"] | None = None
    pose_cov: Float[Array, "n c c"] | None = None

    @classmethod
    def of(
        cls, boxes: object, scores: object = None, **cues: Float[Array, "n ..."]
    ) -> "Detections":
        """Detections from anything array-like, checked. Scores default to 1.

        Raises BadDetections for NaN or infinite values, inverted boxes, rows that are not four
        numbers and columns of different lengths. Boxes without area are allowed here: they
        overlap nothing.
        """
        box_array = np.asarray(boxes, dtype=float)
        if box_array.size == 0:
            box_array = box_array.reshape(0, 4)
        if box_array.ndim != 2 or box_array.shape[1] != 4:
            raise BadDetections(
                f"boxes of shape {box_array.shape}: give n rows of x_min, y_min, x_max, y_max"
            )
        score_array = (
            np.ones(len(box_array)) if scores is None else np.asarray(scores, dtype=float).ravel()
        )
        for name, column in {"scores": score_array, **cues}.items():
            if len(column) != len(box_array):
                raise BadDetections(
                    f"{len(box_array)} boxes but {len(column)} {name}: give one row a box"
                )
        bad = ~np.isfinite(box_array).all(axis=1) | ~np.isfinite(score_array)
        if bad.any():
            row = int(np.flatnonzero(bad)[0])
            raise BadDetections(
                f"box {row} is not finite: {box_array[row].tolist()} score {score_array[row]}"
            )
        inverted = (box_array[:, 2:] < box_array[:, :2]).any(axis=1)
        if inverted.any():
            row = int(np.flatnonzero(inverted)[0])
            raise BadDetections(
                f"box {row} is inverted: {box_array[row].tolist()}; "
                "boxes are x_min, y_min, x_max, y_max"
            )
        return cls(box_array, score_array, **cues)

    @classmethod
    def empty(cls) -> "Detections":
        """A frame in which nothing was detected."""
        return cls(np.zeros((0, 4)), np.zeros(0))
