"""The package `motpy`: boxes with scores, and tracks whose names are texts. See run.py."""

from collections.abc import Iterator
from importlib import import_module
from typing import Any

import numpy as np


class MotpyAdapter:
    """motpy's tracker; its rows are the filtered boxes of the tracks that it calls active."""

    def __init__(self, kind: Any, frame_rate: float, settings: dict[str, Any]) -> None:
        self.tracker = kind(**{"dt": 1.0 / frame_rate} | settings)
        self.detection = import_module("motpy").Detection
        self.numbers: dict[str, int] = {}

    def detections(self, boxes: list[list[float]]) -> Any:
        """A box and its score each."""
        return [self.detection(box=np.array(box[:4]), score=box[4]) for box in boxes]

    def update(self, detections: Any) -> Any:
        """The tracker's step."""
        return self.tracker.step(detections)

    def rows(self, answer: Any) -> Iterator[tuple[Any, ...]]:
        """id x1 y1 x2 y2 score; names are numbered in the order in which they come."""
        for track in answer:
            number = self.numbers.setdefault(track.id, len(self.numbers))
            yield (number, *track.box.tolist(), float(track.score))


ADAPTER = MotpyAdapter
