"""The package `trackers`: boxes go in and come out as `supervision` has them. See run.py."""

from collections.abc import Iterator
from importlib import import_module
from typing import Any

import numpy as np


class TrackersAdapter:
    """A tracker of `trackers`; its rows are the detections that it put a name to."""

    def __init__(self, kind: Any, frame_rate: float, settings: dict[str, Any]) -> None:
        self.tracker = kind(**{"frame_rate": frame_rate} | settings)

    def detections(self, boxes: list[list[float]]) -> Any:
        """Boxes x1 y1 x2 y2 score of one class."""
        sv = import_module("supervision")
        grid = np.array(boxes, dtype=float)
        if len(grid) == 0:
            return sv.Detections.empty()
        kinds = np.zeros(len(grid), dtype=int)
        return sv.Detections(xyxy=grid[:, :4], confidence=grid[:, 4], class_id=kinds)

    def update(self, detections: Any) -> Any:
        """The tracker's step."""
        return self.tracker.update(detections)

    def rows(self, answer: Any) -> Iterator[tuple[Any, ...]]:
        """id x1 y1 x2 y2 score; a number below 0 is no track's."""
        if len(answer) == 0:
            return
        columns = (answer.tracker_id.tolist(), answer.xyxy.tolist(), answer.confidence.tolist())
        for number, box, score in zip(*columns, strict=True):
            if number >= 0:
                yield (int(number), *box, score)


ADAPTER = TrackersAdapter
