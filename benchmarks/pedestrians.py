"""Which settings of `tracker.per_class` suit pedestrians, chosen by drives that are left out.

    python -m benchmarks.pedestrians --root KITTI

For every pair of least score of a birth and longest gap: HOTA, MOTA and switches on both
detectors of pedestrians, all labelled drives together. Then the pair that each drive gets when the
others choose (by the sum of HOTA over both detectors), and what all drives score with these.
"""

import argparse
import logging
from dataclasses import replace
from itertools import product
from pathlib import Path

from benchmarks.kitti_tables import GIVEN
from benchmarks.left_out import print_choice
from mot_sim.datasets import KittiSequence, kitti_sequence
from mot_sim.metrics import Scores, evaluate_sequence
from tracker import Tracker, Tracks
from tracker.per_class import for_kind

DETECTORS = ("rrc_pedestrian", "pointrcnn_pedestrian")
BIRTHS, GAPS = (0.3, 0.4, 0.5, 0.65, 0.8), (0.75, 1.5, 3.0)
Setting = tuple[float, float]


def scores_of(drive: KittiSequence, setting: Setting) -> Scores:
    """Of one drive with these births and gaps."""
    walking = for_kind(Tracker.default(drive.camera), "Pedestrian")
    birth, gap = setting
    lifecycle = replace(walking.lifecycle, birth_score=birth, max_gap=gap)
    tracker = replace(walking, lifecycle=lifecycle, strong_score=birth)
    rows = Tracks.concatenate([tracker.step(frame) for frame in drive])
    assert drive.truth is not None
    return evaluate_sequence(drive.truth, rows, len(drive), kind="Pedestrian")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--root", type=Path, required=True, help="the KITTI tree")
    root = parser.parse_args().root
    logging.basicConfig(level=logging.ERROR)
    drives = {
        detector: {name: kitti_sequence(root, name, detector) for name in GIVEN}
        for detector in DETECTORS
    }
    people = {
        name
        for name, drive in drives[DETECTORS[0]].items()
        if drive.truth is not None and (drive.truth.kinds == "Pedestrian").any()
    }
    found = {
        setting: {
            detector: {name: scores_of(each[name], setting) for name in GIVEN}
            for detector, each in drives.items()
        }
        for setting in product(BIRTHS, GAPS)
    }
    print_choice(found, people, lambda each: f"births {each[0]:.2f}, gaps {each[1]:.2f} s")


if __name__ == "__main__":
    main()
