"""Multi-object tracking from one camera with geometry and shape cues (Sharma et al., ICRA 2018)."""

from collections.abc import Callable

from tracker.frameworks import FRAMEWORKS, Delayed
from tracker.tracker import CostMatrix, Tracker
from tracker.types import Camera, Cuboids, Detections, Frame, Sequence, Tracks

# Trackers by the name that the command line gives them.
TRACKERS: dict[str, Callable[[Camera], Tracker]] = {
    "default": Tracker.default,
    "paper": Tracker.paper,
}

__all__ = [
    "FRAMEWORKS",
    "TRACKERS",
    "Camera",
    "CostMatrix",
    "Cuboids",
    "Delayed",
    "Detections",
    "Frame",
    "Sequence",
    "Tracker",
    "Tracks",
]
