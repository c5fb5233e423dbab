"""Whether the boxes contradict the motion or the calibration that a tracker is given."""

from tracker.motion_check.causes import CAUSES, Contradiction
from tracker.motion_check.check import MotionCheck

__all__ = ["CAUSES", "Contradiction", "MotionCheck"]
