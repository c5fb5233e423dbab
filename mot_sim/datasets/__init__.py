"""Readers and writers: recorded drives become `Sequence`s, tracks become files."""

from mot_sim.datasets.boxes import box_sequence, box_sequences, tracks_of_boxes
from mot_sim.datasets.camera_files import CameraFile, read_camera, read_poses, write_poses
from mot_sim.datasets.detection_files import DetectionFormat, ScoreMap, read_detections
from mot_sim.datasets.export import export_motchallenge, export_trackeval
from mot_sim.datasets.images import ImageFolder, ImageSource
from mot_sim.datasets.kitti import (
    DETECTORS,
    EGO,
    Calibration,
    EgoSource,
    KittiSequence,
    available_sequences,
    find_root,
    kitti_sequence,
    read_calibration,
    read_cuboid_results,
    read_labels,
    read_results,
    write_calibration,
    write_labels,
    write_results,
)
from mot_sim.datasets.recorded import DetectionLog, RecordedSequence
from mot_sim.files.text import TextTable, read_table
from mot_sim.files.writing import write_lines

__all__ = [
    "DETECTORS",
    "EGO",
    "Calibration",
    "CameraFile",
    "DetectionFormat",
    "DetectionLog",
    "EgoSource",
    "ImageFolder",
    "ImageSource",
    "KittiSequence",
    "RecordedSequence",
    "ScoreMap",
    "TextTable",
    "available_sequences",
    "box_sequence",
    "box_sequences",
    "export_motchallenge",
    "export_trackeval",
    "find_root",
    "kitti_sequence",
    "read_calibration",
    "read_camera",
    "read_cuboid_results",
    "read_detections",
    "read_labels",
    "read_poses",
    "read_results",
    "read_table",
    "tracks_of_boxes",
    "write_calibration",
    "write_labels",
    "write_lines",
    "write_poses",
    "write_results",
]
