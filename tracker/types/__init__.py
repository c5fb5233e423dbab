"""The nouns: frozen dataclasses of arrays, no algorithms; and KITTI's words for classes."""

from tracker.types.camera import Camera
from tracker.types.cuboids import Cuboids
from tracker.types.detections import Detections
from tracker.types.estimates import CarEstimates
from tracker.types.kinds import (
    CAR_SIZE,
    CAR_SIZE_STD,
    KITTI_KINDS,
    MOT_CLASSES,
    MOT_DISTRACTOR,
    TRACKED_KINDS,
    is_kitti_kind,
    kinds_said,
    parse_kinds,
    spelled_as_kitti,
)
from tracker.types.rows import Rows
from tracker.types.sequence import Frame, Sequence, SequenceWrapper, max_step
from tracker.types.tracks import Tracks

__all__ = [
    "CAR_SIZE",
    "CAR_SIZE_STD",
    "KITTI_KINDS",
    "MOT_CLASSES",
    "MOT_DISTRACTOR",
    "TRACKED_KINDS",
    "Camera",
    "CarEstimates",
    "Cuboids",
    "Detections",
    "Frame",
    "Rows",
    "Sequence",
    "SequenceWrapper",
    "Tracks",
    "is_kitti_kind",
    "kinds_said",
    "max_step",
    "parse_kinds",
    "spelled_as_kitti",
]
