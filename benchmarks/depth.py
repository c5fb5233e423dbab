"""How well a box tells where its car stands: the lift of eq. 2 against KITTI's labels.

    python -m benchmarks.depth --root KITTI

RRC boxes matched (IoU >= 0.6) to cars of the ten given sequences that are neither truncated nor
largely occluded. Errors of the centre: depth as a fraction of the depth, sideways in metres;
median and 1.48 x median absolute deviation (a robust standard deviation).
"""

import argparse
from pathlib import Path

import numpy as np
from numpy import ndarray as Array

from benchmarks.kitti_tables import GIVEN
from mot_sim.datasets import KittiSequence, kitti_sequence
from mot_sim.metrics.matching import Overlaps
from tracker.beliefs import Lift

LIFTS = {"road contact (eq. 2)": Lift(), "with the box's height": Lift(use_box_height=True)}
BINS = ((0, 10), (10, 20), (20, 30), (30, 50), (50, 80))


def errors(sequence: KittiSequence) -> tuple[Array, dict[str, Array]]:
    """True depth of every matched car, and (depth, sideways) errors by lift, metres."""
    truth, log = sequence.truth, sequence.log
    assert truth is not None
    assert truth.cuboids is not None
    assert truth.kinds is not None
    clear = (truth.kinds == "Car") & (truth.truncation == 0) & (truth.occlusion <= 1)
    labels = truth.select(clear)
    boxes = log.detections.boxes
    pairs = Overlaps.between(labels, type(labels)(log.frames, np.arange(len(boxes)), boxes))
    sure = pairs.iou >= 0.6
    base = labels.cuboids.base[pairs.rows[sure]]
    seen = log.detections.select(pairs.columns[sure])
    found = {name: lift(seen, sequence.camera).cuboids.base for name, lift in LIFTS.items()}
    return base[:, 2], {name: (place - base)[:, ::-2] for name, place in found.items()}


def spread(values: Array) -> str:
    """Median and robust standard deviation."""
    middle = np.median(values)
    return f"{middle:+7.3f} {1.48 * np.median(np.abs(values - middle)):6.3f}"


def main() -> None:
    parser = argparse.ArgumentParser(description=str(__doc__).splitlines()[0])
    parser.add_argument("--root", type=Path, required=True, help="the KITTI tree")
    root = parser.parse_args().root
    parts = [errors(kitti_sequence(root, name)) for name in GIVEN]
    depth = np.concatenate([part[0] for part in parts])
    print(f"{'':24s} {'depth':>8s} {'cars':>6s}   depth: median, std   sideways: median, std")
    for name in LIFTS:
        off = np.concatenate([part[1][name] for part in parts])
        for low, high in BINS:
            inside = (depth >= low) & (depth < high)
            relative = spread(off[inside, 0] / depth[inside])
            print(
                f"{name:24s} {low:3d}-{high:2d} m {inside.sum():6d}     {relative}"
                f"        {spread(off[inside, 1])}"
            )


if __name__ == "__main__":
    main()
