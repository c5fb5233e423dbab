"""How well boxes are predicted through gaps: carried by their cars, or moved as windows.

    python -m benchmarks.unseen_boxes --root KITTI [--detections rrc]

Every tenth frame of the given drives the tracker is asked where its tracks of 5 detections or more
would be if nothing looked any more: the IoU of those boxes with the label that each track had met
(IoU 0.6) at the last look, after 1 to 20 frames, and the share that overlap by half.
"""

import argparse
import logging
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy import ndarray as Array

from benchmarks.kitti_tables import GIVEN
from mot_sim.datasets import KittiSequence, kitti_sequence
from tracker import Frame, Tracker
from tracker.car_filter import CarFilter
from tracker.geometry import box_iou

STEPS = (1, 2, 3, 5, 10, 15, 20)
EVERY, MIN_HITS, MIN_OVERLAP = 10, 5, 0.6
ROWS = {"carried by their cars": True, "moved as windows": False}


def overlaps(drive: KittiSequence, carried: bool) -> Iterator[tuple[int, float]]:
    """Frames since the last look, and the IoU with the label."""
    tracker = replace(
        Tracker.default(drive.camera), car_filter=CarFilter(carries_boxes=carried), gap_rows=None
    )
    frames, truth = list(drive), drive.truth
    assert truth is not None
    for start, frame in enumerate(frames):
        tracker.step(frame)
        if start % EVERY:
            continue
        tracks, seen = tracker.state.tracks, truth.select(truth.frames == frame.index)
        known = (tracks.hits >= MIN_HITS) & (tracks.time_since_update <= 0.0)
        if not known.any() or not len(seen):
            continue
        met = box_iou(tracks.beliefs.boxes[:, None], seen.boxes[None])
        known &= met.max(axis=1) >= MIN_OVERLAP
        cars = dict(zip(tracks.ids[known], seen.ids[met.argmax(axis=1)[known]], strict=True))
        state = tracker.state
        for steps, later in enumerate(frames[start + 1 : start + 1 + STEPS[-1]], 1):
            blind = Frame(later.index, later.time, None, later.T_now_before, later.motion_cov)
            expected = tracker.cost_matrix(blind).tracks
            tracker.step(blind)
            if steps in STEPS:
                labels = truth.select(truth.frames == later.index)
                boxes = dict(zip(labels.ids, labels.boxes, strict=True))
                clipped = drive.camera.clip_boxes(expected.beliefs.boxes)
                for track, box in zip(expected.ids, clipped, strict=True):
                    if cars.get(track) in boxes:
                        yield steps, float(box_iou(box[None], boxes[cars[track]][None])[0])
        tracker.state = state


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--root", type=Path)
    parser.add_argument("--detections", default="rrc")
    told = parser.parse_args()
    logging.basicConfig(level=logging.ERROR)
    found: dict[str, Array] = {}
    for name, carried in ROWS.items():
        pairs = [
            pair
            for drive in GIVEN
            for pair in overlaps(kitti_sequence(told.root, drive, told.detections), carried)
        ]
        found[name] = np.array(pairs)
    print("| frames unseen | cars | " + " | ".join(f"{n}: IoU | >= 0.5, %" for n in ROWS) + " |")
    print("| ---: | ---: |" + " ---: | ---: |" * len(ROWS))
    for steps in STEPS:
        columns = [table[table[:, 0] == steps, 1] for table in found.values()]
        cells = [f"{iou.mean():.3f} | {100 * (iou >= 0.5).mean():.1f}" for iou in columns]
        print(f"| {steps} | {len(columns[0]):,} | " + " | ".join(cells) + " |")


if __name__ == "__main__":
    main()
