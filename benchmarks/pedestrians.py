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
from mot_sim.datasets import KittiSequence, kitti_sequence
from mot_sim.metrics import Scores, combine, evaluate_sequence
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


def told(scores: Scores) -> str:
    """HOTA and MOTA in percent, and switches."""
    return f"{100 * scores['HOTA']:5.2f} {100 * scores['MOTA']:5.2f} {scores['IDSW']:3.0f}"


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
        (detector, setting): {
            name: scores_of(drive, setting) for name, drive in drives[detector].items()
        }
        for detector in DETECTORS
        for setting in product(BIRTHS, GAPS)
    }

    def merit(setting: Setting, names: set[str]) -> float:
        return sum(
            combine([found[detector, setting][name] for name in sorted(names)])["HOTA"]
            for detector in DETECTORS
        )

    print(f"HOTA, MOTA, switches      {DETECTORS[0]:20s} {DETECTORS[1]}")
    for setting in product(BIRTHS, GAPS):
        cells = [told(combine(list(found[detector, setting].values()))) for detector in DETECTORS]
        print(f"births {setting[0]:.2f}, gaps {setting[1]:.2f} s   {cells[0]:20s} {cells[1]}")
    chosen = {
        name: max(product(BIRTHS, GAPS), key=lambda each, name=name: merit(each, people - {name}))
        for name in GIVEN
    }
    for name in sorted(people):
        print(f"{name} left out: births {chosen[name][0]:.2f}, gaps {chosen[name][1]:.2f} s")
    cells = [
        told(combine([found[detector, chosen[name]][name] for name in GIVEN]))
        for detector in DETECTORS
    ]
    print(f"each as the others choose {cells[0]:20s} {cells[1]}")


if __name__ == "__main__":
    main()
