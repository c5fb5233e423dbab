"""Detectors that look at images: networks in ONNX files, whoever trained them."""

from mot_sim.evaluation.detectors.detected_folder import (
    DetectedFolder,
    detect_in,
    image_drives,
    kitti_rows,
)
from mot_sim.evaluation.detectors.heads import HEADS, Head, NetworkBoxes
from mot_sim.evaluation.detectors.networks import BACKENDS, OnnxNetwork, load_network
from mot_sim.evaluation.detectors.onnx_detector import FITS, PIXELS, OnnxDetector

__all__ = [
    "BACKENDS", "FITS", "HEADS", "PIXELS", "DetectedFolder", "Head", "NetworkBoxes", "OnnxDetector",
    "OnnxNetwork", "detect_in", "image_drives", "kitti_rows", "load_network",
]  # fmt: skip
