"""What tracking loses where the scale of the odometry must be found by the cars.

    python -m benchmarks.ego_scale --root KITTI [--detections rrc]

The labelled drives with ORB-SLAM3's poses: in metres as they are, without them, and with positions
times .05, .5, 2 and 20, whose scale is found while a drive is played (`mot-sim track --ego-scale
auto`). Then, of each drive: the scale at the end with its 95 % interval, how many metres a unit of
the poses is by OXTS, and from which frame on it was known. About five minutes.
"""

import argparse
import logging
import warnings
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy import ndarray as Array

from mot_sim.datasets import KittiSequence, kitti_sequence
from mot_sim.evaluation.runs import track_sequence
from mot_sim.evaluation.scoring import choose_sequences
from mot_sim.metrics import evaluate
from tracker import Tracker
from tracker.ego import EgoScale
from tracker.errors import MotionWarning

FACTORS = (0.05, 0.5, 2.0, 20.0)
# Lengths are compared over so many frames: OXTS zigzags.
STRIDE = 10


def rescaled(drive: KittiSequence, factor: float) -> KittiSequence:
    """The drive with other units, of which nothing is known."""
    Ts_world_cam = drive.Ts_world_cam
    assert Ts_world_cam is not None
    Ts_world_cam = Ts_world_cam.copy()
    Ts_world_cam[:, :3, 3] *= factor
    return replace(drive, Ts_world_cam=Ts_world_cam, ego_scale=EgoScale(drive.camera))


def score(name: str, drives: list[KittiSequence]) -> None:
    """A row of the table of scores."""
    tables = {}
    for drive in drives:
        assert drive.truth is not None
        tracks, _ = track_sequence(Tracker.default(drive.camera), drive)
        tables[drive.name] = (drive.truth, tracks, drive.frame_count)
    found = evaluate(tables).combined
    rates = f"{100 * found['HOTA']:.2f} | {100 * found['MOTA']:.2f} | {found['IDSW']:.0f}"
    print(f"| {name} | {rates} |", flush=True)


def path_length(Ts_world_cam: Array) -> float:
    """Metres, or units, by steps of STRIDE frames."""
    places = Ts_world_cam[::STRIDE, :3, 3]
    return float(np.linalg.norm(np.diff(places, axis=0), axis=1).sum())


def scale_row(root: Path, drive: KittiSequence) -> None:
    """A row of the table of scales."""
    by_oxts = kitti_sequence(root, drive.name, None, "oxts").Ts_world_cam
    assert by_oxts is not None
    assert drive.Ts_world_cam is not None
    scale, known_from = EgoScale(drive.camera), None
    for frame in drive:
        scale.step(frame)
        if known_from is None and scale.estimate.known:
            known_from = frame.index
    found = scale.estimate
    said = f"{found.factor:.2f} ({found.low:.2f} to {found.high:.2f})" if found.known else "unknown"
    true = path_length(by_oxts) / path_length(drive.Ts_world_cam)
    moved = f"{true:.2f}" if path_length(by_oxts) > STRIDE else "it stands"
    print(f"| {drive.name} | {said} | {moved} | {known_from} |", flush=True)


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("--root", type=Path, required=True, help="the KITTI tree")
    parser.add_argument("--detections", default="rrc")
    arguments = parser.parse_args()
    logging.basicConfig(level=logging.ERROR)
    warnings.simplefilter("ignore", MotionWarning)
    drives = [
        kitti_sequence(arguments.root, name, arguments.detections, "orbslam3")
        for name in choose_sequences(arguments.root, "labelled")
    ]
    print("| positions | HOTA | MOTA | IDSW |\n|---|---:|---:|---:|")
    score("in metres", drives)
    for factor in FACTORS:
        score(f"times {factor:g}", [rescaled(drive, factor) for drive in drives])
    score("unknown motion", [replace(drive, Ts_world_cam=None) for drive in drives])
    print("\n| drive | metres a unit | by OXTS | known from frame |\n|---|---:|---:|---:|")
    for drive in drives:
        scale_row(arguments.root, drive)


if __name__ == "__main__":
    main()
