"""From which IoU on sure boxes are suppressed, chosen by drives that are left out.

    python -m benchmarks.suppression --root KITTI

For every least score of a sure box and limit of two of them: HOTA, MOTA and switches of the default
tracker (OXTS) on four detectors, all given drives together. Then the pair that each drive gets when
the others choose (by the sum of HOTA over the detectors), and what all drives score with these.
Below .9 RRC's duplicates stay (HOTA 85.0 in place of 85.4 from IoU .7 on), so it is not tried.
"""

import argparse
import logging
from dataclasses import replace
from itertools import product
from pathlib import Path

from benchmarks.gap_rows import DETECTORS
from benchmarks.kitti_tables import GIVEN
from benchmarks.left_out import print_choice
from mot_sim.datasets import KittiSequence, kitti_sequence
from mot_sim.metrics import Scores, evaluate_sequence
from tracker import Tracker, Tracks
from tracker.suppression import Suppression

MIN_SCORE, MAX_IOU = 0.3, 0.5
SETTINGS = [
    Suppression(MIN_SCORE, MAX_IOU),
    *(
        Suppression(MIN_SCORE, MAX_IOU, limit, score)
        for score, limit in product((0.9, 0.95, 0.98), (0.6, 0.7, 0.8))
    ),
]


def by_setting(drive: KittiSequence) -> dict[Suppression, Scores]:
    """The scores of a drive; settings that keep the same boxes are tracked once."""
    tracker = Tracker.default(drive.camera)
    memory, given = tracker.state.scores, []
    for frame in drive:
        detections, memory = tracker.rescored(memory, frame)
        given.append(detections)
    found: dict[Suppression, Scores] = {}
    same: dict[tuple[bytes, ...], Scores] = {}
    for setting in SETTINGS:
        kept = tuple(setting(each, drive.camera).boxes.tobytes() for each in given)
        if kept not in same:
            one = replace(Tracker.default(drive.camera), suppress=setting)
            rows = Tracks.concatenate([one.step(frame) for frame in drive])
            assert drive.truth is not None
            same[kept] = evaluate_sequence(drive.truth, rows, len(drive))
        found[setting] = same[kept]
    return found


def label(setting: Suppression) -> str:
    """What a setting says of sure boxes."""
    if setting == SETTINGS[0]:
        return "all alike"
    return f"from {setting.sure_score:g}, IoU {setting.max_iou_of_sure:g}"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--root", type=Path, required=True, help="the KITTI tree")
    root = parser.parse_args().root
    logging.basicConfig(level=logging.ERROR)
    every = {
        detector: {name: by_setting(kitti_sequence(root, name, detector)) for name in GIVEN}
        for detector in DETECTORS
    }
    found = {
        setting: {
            detector: {name: drives[name][setting] for name in GIVEN}
            for detector, drives in every.items()
        }
        for setting in SETTINGS
    }
    print_choice(found, GIVEN, label)


if __name__ == "__main__":
    main()
