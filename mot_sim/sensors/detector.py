"""A detector: the effects put together, each with its own level."""

from dataclasses import dataclass

import numpy as np

from mot_sim.datasets.recorded import DetectionLog
from mot_sim.sensors.jitter import jitter_boxes
from mot_sim.sensors.misses import missed
from mot_sim.sensors.scores import confidence
from mot_sim.truth import Truth
from tracker.errors import BadConfig
from tracker.types import Camera, Detections


@dataclass(frozen=True)
class Detector:
    """Sees truth with noise; at level 0 everywhere it gives the exact boxes with score 1.

    A car of which no pixel is visible is never seen, at any level.
    """

    jitter: float = 1.0
    misses: float = 1.0
    doubt: float = 1.0

    def __post_init__(self) -> None:
        if not min(self.jitter, self.misses, self.doubt) >= 0.0:
            raise BadConfig(f"{self}: a level of noise is 0 (none) or more")

    def __call__(self, truth: Truth, seed: int, camera: Camera) -> DetectionLog:
        """The detections of all frames, clipped to the image."""
        ids, frames = truth.tracks.ids, truth.tracks.frames
        unseen = (truth.visible <= 0.0) | missed(truth.visible, seed, ids, frames, self.misses)
        seen = truth.select(~unseen)
        ids, frames = seen.tracks.ids, seen.tracks.frames
        width, height = camera.image_size
        boxes = jitter_boxes(seen.tracks.boxes, seed, ids, frames, self.jitter)
        boxes = boxes.clip(0.0, np.array([width, height, width, height]) - 1.0)
        scores = confidence(seen.visible, seed, ids, frames, self.doubt)
        return DetectionLog.of(frames, Detections(boxes, scores))
