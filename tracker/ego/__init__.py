"""Camera motion from images: visual odometry that takes its scale from the road plane.

Sharma et al., ICRA 2018, take the camera's motion from matched features and scale it by the
camera's height. Here: corners and optical flow, an essential matrix, the road's own pixels for
the metres, and a filter that coasts through outliers.
"""

from tracker.ego.features import CornerFlow, Features
from tracker.ego.filter import Coasting, MotionMeasurement
from tracker.ego.odometry import VisualOdometry
from tracker.ego.road import RoadScale
from tracker.ego.scale import EgoScale, ScaleEstimate
from tracker.ego.visual_sequence import VisualSequence, prefetch, with_visual_motion

__all__ = [
    "Coasting",
    "CornerFlow",
    "EgoScale",
    "Features",
    "MotionMeasurement",
    "RoadScale",
    "ScaleEstimate",
    "VisualOdometry",
    "VisualSequence",
    "prefetch",
    "with_visual_motion",
]
