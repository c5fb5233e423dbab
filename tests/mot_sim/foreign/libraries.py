"""Stand-ins of four libraries of trackers: every box is a track, ids are by its place."""

from pathlib import Path

FILES = {
    "motpy": """
from collections import namedtuple
Track = namedtuple("Track", "id box score class_id")
class Detection:
    def __init__(self, box, score):
        self.box, self.score = box, score
class MultiObjectTracker:
    def __init__(self, dt):
        assert dt == 0.1
    def step(self, detections):
        return [Track("abcdefghijklmnopqrstuvwxyz"[place], each.box, each.score, None)
                for place, each in enumerate(detections)]
""",
    "norfair": """
from types import SimpleNamespace
import numpy as np
class Detection:
    def __init__(self, points, scores, data):
        self.points, self.scores, self.data = points, scores, data
class Tracker:
    def __init__(self, distance_function, distance_threshold):
        assert distance_function == "iou"
    def update(self, detections=None):
        return [SimpleNamespace(id=place, estimate=each.points, last_detection=each,
                                live_points=np.ones(2, bool))
                for place, each in enumerate(detections)]
""",
    "supervision": """
import numpy as np
class Detections:
    def __init__(self, xyxy, confidence=None, class_id=None, tracker_id=None):
        self.xyxy, self.confidence = xyxy, confidence
        self.class_id, self.tracker_id = class_id, tracker_id
    def __len__(self):
        return len(self.xyxy)
    @classmethod
    def empty(cls):
        return cls(np.zeros((0, 4)))
class ByteTrack:
    def __init__(self, frame_rate=30):
        assert frame_rate == 10
    def update_with_detections(self, detections):
        detections.tracker_id = np.arange(len(detections))
        return detections
""",
    "trackers": """
import numpy as np
class SORTTracker:
    def __init__(self, frame_rate=30.0):
        assert frame_rate == 10.0
    def update(self, detections):
        detections.tracker_id = np.arange(len(detections))
        return detections
""",
}


def write_libraries(folder: Path) -> Path:
    """Write them as packages; gives the folder that holds them."""
    for name, code in FILES.items():
        (folder / name).mkdir(parents=True)
        (folder / name / "__init__.py").write_text(code)
    return folder
