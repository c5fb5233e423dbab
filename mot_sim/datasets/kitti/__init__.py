"""The KITTI tracking benchmark: reading its tree and writing what its tools read."""

from mot_sim.datasets.kitti.calibration import Calibration, read_calibration, write_calibration
from mot_sim.datasets.kitti.detectors import DETECTORS
from mot_sim.datasets.kitti.ego import EGO, EgoSource
from mot_sim.datasets.kitti.labels import (
    read_cuboid_results,
    read_labels,
    read_results,
    write_labels,
    write_results,
)
from mot_sim.datasets.kitti.places import available_sequences, find_root
from mot_sim.datasets.kitti.sequence import KittiSequence, kitti_sequence
from mot_sim.datasets.kitti.server import write_server_archive

__all__ = [
    "DETECTORS",
    "EGO",
    "Calibration",
    "EgoSource",
    "KittiSequence",
    "available_sequences",
    "find_root",
    "kitti_sequence",
    "read_calibration",
    "read_cuboid_results",
    "read_labels",
    "read_results",
    "write_calibration",
    "write_labels",
    "write_results",
    "write_server_archive",
]
