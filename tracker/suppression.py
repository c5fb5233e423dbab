"""Which detections reach the tracker: score threshold and non-maximum suppression."""

from dataclasses import dataclass

import numpy as np

from tracker.geometry import box_area, box_intersection
from tracker.types import Camera, Detections


@dataclass(frozen=True)
class Suppression:
    """Drops weak boxes, boxes without area in the image, and the weaker one of two that overlap."""

    min_score: float = 0.0
    """Boxes with a lower score are dropped; more: fewer false alarms and more misses."""
    max_iou: float = 0.7
    """Of two boxes whose IoU is larger, the one with the lower score is dropped (at equal scores
    the later one), 0 to 1; more: more boxes stay."""

    def __call__(self, detections: Detections, camera: Camera) -> Detections:
        """What is left, in the given order, in arrays of its own."""
        boxes, scores = detections.boxes, detections.scores
        inside = camera.clip_boxes(boxes)
        kept = (inside[:, 2] > inside[:, 0]) & (inside[:, 3] > inside[:, 1])
        kept &= scores >= self.min_score
        if len(boxes) > 1:
            area = box_area(boxes)
            shared = box_intersection(boxes[:, None], boxes[None])
            # IoU > t, that is shared > t (both - shared)
            close = (1.0 + self.max_iou) * shared > self.max_iou * (area[:, None] + area)
            close.ravel()[:: len(boxes) + 1] = False  # each box with itself
            if np.count_nonzero(close):
                for row in np.argsort(-scores, kind="stable"):
                    if kept[row]:
                        kept &= ~close[row]
        return detections.select(kept)
