"""Which detections reach the tracker: score threshold and non-maximum suppression."""

from dataclasses import dataclass

import numpy as np

from tracker.errors import BadConfig
from tracker.kernels import Kernel
from tracker.types import Camera, Detections

SUPPRESS_BOXES = Kernel("tracker.kernels.pairing", "suppress_boxes")


@dataclass(frozen=True)
class Suppression:
    """Drops weak boxes, boxes without area in the image, and the weaker one of two that overlap.

    Of duplicates a detector is sure of one; of a car behind a car it may be sure as well. Where
    both scores reach `sure_score`, or none is the weaker one, the limit is `max_iou_of_sure`.
    """

    min_score: float = 0.0
    """Boxes with a lower score are dropped; more: fewer false alarms and more misses."""
    max_iou: float = 0.7
    """Of two boxes whose IoU is larger, the one with the lower score is dropped (at equal scores
    the later one), 0 to 1; more: more boxes stay."""
    max_iou_of_sure: float | None = None
    """In place of `max_iou` where both boxes are sure, `max_iou` to 1; more: more boxes stay, cars
    in rows as well as duplicates. None: sure boxes are suppressed as others are."""
    sure_score: float = 0.9
    """Score from which on a box is sure; more: fewer boxes stay."""

    def __post_init__(self) -> None:
        least = self.max_iou if self.max_iou_of_sure is None else self.max_iou_of_sure
        if not 0.0 <= self.max_iou <= least <= 1.0:
            raise BadConfig(
                f"max_iou {self.max_iou:g}, max_iou_of_sure {least:g}: give limits in 0..1, that "
                "of sure boxes not the smaller one"
            )
        if np.isnan(self.min_score) or np.isnan(self.sure_score):
            raise BadConfig(
                f"min_score {self.min_score:g}, sure_score {self.sure_score:g}: give numbers"
            )

    def __call__(self, detections: Detections, camera: Camera) -> Detections:
        """What is left, in the given order, in arrays of its own."""
        boxes, scores = detections.boxes, detections.scores
        rows = np.empty(len(boxes), np.int64)
        of_sure = self.max_iou if self.max_iou_of_sure is None else self.max_iou_of_sure
        limits = self.min_score, self.max_iou, of_sure, self.sure_score
        count = SUPPRESS_BOXES(boxes, scores, camera.far_corner, *limits, rows)
        return detections.copied() if count == len(boxes) else detections.take(rows[:count])
