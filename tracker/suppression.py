"""Which detections reach the tracker: score threshold and non-maximum suppression."""

from dataclasses import dataclass

import numpy as np

from tracker.geometry import box_iou
from tracker.types import Camera, Detections


@dataclass(frozen=True)
class Suppression:
    """Drops weak boxes, boxes without area in the image, and the weaker one of two that overlap.

    min_score: boxes below it are dropped. max_iou: of two boxes that overlap more, the one with
    the smaller score goes (at equal scores the later one).
    """

    min_score: float = 0.0
    max_iou: float = 0.7

    def __call__(self, detections: Detections, camera: Camera) -> Detections:
        """What is left, in the given order."""
        boxes, scores = detections.boxes, detections.scores
        width, height = camera.image_size
        far_corner = np.minimum(boxes[:, 2:], (width - 1.0, height - 1.0))
        visible = (far_corner > np.maximum(boxes[:, :2], 0.0)).all(axis=1)
        kept = visible & (scores >= self.min_score)
        if np.count_nonzero(kept) > 1:
            iou = box_iou(boxes[:, None], boxes[None])
            np.fill_diagonal(iou, 0.0)
            if (iou > self.max_iou).any():
                for row in np.argsort(-scores, kind="stable"):
                    if kept[row]:
                        kept &= iou[row] <= self.max_iou
        return detections if kept.all() else detections.select(kept)
