"""Multi-object tracking from one camera with geometry and shape cues (Sharma et al., ICRA 2018).

Its names are loaded when they are first asked for: importing the package alone costs nothing.
"""

from typing import TYPE_CHECKING

from tracker.lazy_names import lazy_names

if TYPE_CHECKING:
    from tracker.cost_matrix import CostMatrix
    from tracker.cuboid_tracker import cuboid_tracker
    from tracker.frameworks import FRAMEWORKS, Delayed
    from tracker.per_class import PerClass
    from tracker.tracker import TRACKERS, Tracker
    from tracker.types import Camera, Cuboids, Detections, Frame, Sequence, Tracks

# The module that each of these names lives in.
_MODULES = {
    "FRAMEWORKS": "tracker.frameworks",
    "TRACKERS": "tracker.tracker",
    "Camera": "tracker.types",
    "CostMatrix": "tracker.cost_matrix",
    "Cuboids": "tracker.types",
    "Delayed": "tracker.frameworks",
    "Detections": "tracker.types",
    "Frame": "tracker.types",
    "PerClass": "tracker.per_class",
    "Sequence": "tracker.types",
    "Tracker": "tracker.tracker",
    "Tracks": "tracker.types",
    "cuboid_tracker": "tracker.cuboid_tracker",
}

if not TYPE_CHECKING:  # a type checker knows the names above, and no others
    __getattr__, __dir__ = lazy_names(__name__, _MODULES)

__all__ = [
    "FRAMEWORKS",
    "TRACKERS",
    "Camera",
    "CostMatrix",
    "Cuboids",
    "Delayed",
    "Detections",
    "Frame",
    "PerClass",
    "Sequence",
    "Tracker",
    "Tracks",
    "cuboid_tracker",
]
