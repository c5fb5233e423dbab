"""The package `norfair`: a box is two points, compared by IoU. See run.py."""

from collections.abc import Iterator
from importlib import import_module
from typing import Any

import numpy as np


class NorfairAdapter:
    """norfair's tracker; its rows are the filtered boxes that norfair would draw.

    It counts in frames, so the frame rate says nothing to it.
    """

    def __init__(self, kind: Any, frame_rate: float, settings: dict[str, Any]) -> None:
        self.tracker = kind(**{"distance_function": "iou", "distance_threshold": 0.8} | settings)
        self.detection = import_module("norfair").Detection

    def detections(self, boxes: list[list[float]]) -> Any:
        """Two corners, each with the box's score; the score as `data` as well."""
        return [
            self.detection(np.array([box[:2], box[2:4]]), np.full(2, box[4]), data=box[4])
            for box in boxes
        ]

    def update(self, detections: Any) -> Any:
        """The tracker's step."""
        return self.tracker.update(detections=detections)

    def rows(self, answer: Any) -> Iterator[tuple[Any, ...]]:
        """id x1 y1 x2 y2 score, the score of the track's last detection.

        Points are alive for `pointwise_hit_counter_max` frames: 1 means that a track without a
        detection has no row. Corners move on their own; boxes that they turned inside out are
        left out.
        """
        for tracked in answer:
            x1, y1, x2, y2 = tracked.estimate.ravel().tolist()
            if tracked.live_points.any() and x1 < x2 and y1 < y2:
                yield (int(tracked.id), x1, y1, x2, y2, tracked.last_detection.data)


ADAPTER = NorfairAdapter
