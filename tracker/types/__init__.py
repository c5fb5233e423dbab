"""The nouns: frozen dataclasses of arrays, no algorithms."""

from tracker.types.camera import Camera
from tracker.types.cuboids import Cuboids
from tracker.types.detections import Detections
from tracker.types.rows import Rows
from tracker.types.sequence import Frame, Sequence, SequenceWrapper
from tracker.types.tracks import Tracks

__all__ = [
    "Camera",
    "Cuboids",
    "Detections",
    "Frame",
    "Rows",
    "Sequence",
    "SequenceWrapper",
    "Tracks",
]
