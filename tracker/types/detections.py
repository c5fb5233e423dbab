"""The output of a detector for one frame."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Shaped
from numpy import ndarray as Array

from tracker.errors import BadDetections
from tracker.types.rows import Rows
from tracker.types.validation import as_floats


@dataclass(frozen=True, eq=False)
class Detections(Rows):
    """Boxes with scores, and whatever cues were measured on them: each a column, or None.

    A NaN row in a cue column: the cue was not measured for that box.
    Array-likes are converted. Raises BadDetections for NaN or infinite boxes and scores, inverted
    boxes, rows that are not four numbers, sizes of 0 and columns of different lengths. Boxes
    without area are allowed here: they overlap nothing.
    """

    boxes: Float[Array, "n 4"]
    """x_min, y_min, x_max, y_max, px."""
    scores: Float[Array, " n"]
    """Confidence of the detector; any scale, larger is surer. `Tracker` takes scores as
    probabilities."""
    yaw: Float[Array, " n"] | None = None
    """About road +y, rad; 0 = facing road +x."""
    size: Float[Array, "n 3"] | None = None
    """Length, height, width, metres, above 0."""
    shape: Float[Array, "n b"] | None = None
    """Coefficients of eq. 1."""
    keypoints: Float[Array, "n k 3"] | None = None
    """u, v (px) and confidence of each keypoint."""
    descriptor: Float[Array, "n d"] | None = None
    """psi of eq. 5, appearance."""
    pose_cov: Float[Array, "n c c"] | None = None
    """Covariance of (yaw, shape); c = b + 1."""
    base: Float[Array, "n 3"] | None = None
    """Centre of the bottom face in the road frame, metres: with yaw and size a cuboid, as LiDAR
    detectors give it. `tracker.cuboid_tracker` takes it; others do not look at it."""
    kinds: Shaped[Array, " n"] | None = None
    """Class of each box, in KITTI's spelling; None: all are of one class, cars unless said."""

    def __post_init__(self) -> None:
        for name in self.__match_args__:
            column = self.__dict__[name]
            if column is not None and name != "kinds":
                object.__setattr__(self, name, as_floats(name, column, BadDetections))
        if self.kinds is not None:
            object.__setattr__(self, "kinds", np.asarray(self.kinds, dtype=str))
        boxes, scores = self.boxes, self.scores
        if boxes.ndim != 2 or boxes.shape[1] != 4:
            raise BadDetections(
                f"boxes of shape {boxes.shape}: give n rows of x_min, y_min, x_max, y_max"
            )
        for name in self.__match_args__[1:]:
            column = self.__dict__[name]
            if column is not None and column.shape[:1] != boxes.shape[:1]:
                count = len(column) if column.ndim else "one value for the"
                raise BadDetections(f"{len(boxes)} boxes but {count} {name}: give one row a box")
        if scores.ndim != 1:
            raise BadDetections(f"scores of shape {scores.shape}: give one number a box")
        bad = ~np.isfinite(boxes).all(axis=1) | ~np.isfinite(scores)
        if np.count_nonzero(bad):
            row = int(np.flatnonzero(bad)[0])
            raise BadDetections(
                f"box {row} is not finite: {boxes[row].tolist()} score {scores[row]}"
            )
        if self.size is not None and np.count_nonzero(self.size <= 0.0):
            row = int(np.flatnonzero((self.size <= 0.0).any(axis=1))[0])
            raise BadDetections(
                f"size {self.size[row].tolist()} of box {row} is not positive: give metres, or NaN "
                "where it was not measured"
            )
        inverted = (boxes[:, 2:] < boxes[:, :2]).any(axis=1)
        if np.count_nonzero(inverted):
            row = int(np.flatnonzero(inverted)[0])
            raise BadDetections(
                f"box {row} is inverted: {boxes[row].tolist()}; "
                "boxes are x_min, y_min, x_max, y_max"
            )

    @classmethod
    def of(
        cls, boxes: object, scores: object = None, **cues: Float[Array, "n ..."]
    ) -> "Detections":
        """Detections from anything array-like. Scores default to 1; no boxes at all may be []."""
        box_array = as_floats("boxes", boxes, BadDetections)
        if box_array.size == 0:
            box_array = box_array.reshape(0, 4)
        given = np.ones(box_array.shape[:1]) if scores is None else scores
        score_array = as_floats("scores", given, BadDetections).ravel()
        return cls(box_array, score_array, **cues)

    @classmethod
    def empty(cls) -> "Detections":
        """A frame in which nothing was detected."""
        return cls(np.zeros((0, 4)), np.zeros(0))
