"""The package `supervision`: its ByteTrack, boxes as those of `trackers`. See run.py."""

from collections.abc import Iterator
from importlib import import_module
from typing import Any

import numpy as np


class SupervisionAdapter:
    """supervision's tracker; its rows are the detections that it put a name to."""

    def __init__(self, kind: Any, frame_rate: float, settings: dict[str, Any]) -> None:
        self.tracker = kind(**{"frame_rate": round(frame_rate)} | settings)

    def detections(self, boxes: list[list[float]]) -> Any:
        """Boxes x1 y1 x2 y2 score of one class."""
        sv = import_module("supervision")
        grid = np.array(boxes, dtype=float).reshape(-1, 5)
        kinds = np.zeros(len(grid), dtype=int)
        return sv.Detections(xyxy=grid[:, :4], confidence=grid[:, 4], class_id=kinds)

    def update(self, detections: Any) -> Any:
        """The tracker's step."""
        return self.tracker.update_with_detections(detections)

    def rows(self, answer: Any) -> Iterator[tuple[Any, ...]]:
        """id x1 y1 x2 y2 score; without a name there is no row."""
        if len(answer) == 0 or answer.tracker_id is None:
            return
        columns = (answer.tracker_id.tolist(), answer.xyxy.tolist(), answer.confidence.tolist())
        for number, box, score in zip(*columns, strict=True):
            yield (int(number), *box, score)


ADAPTER = SupervisionAdapter
