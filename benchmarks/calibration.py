"""How well a fitted detector foretells drives it has not seen, beside how well other drives do.

    python -m benchmarks.calibration --root KITTI [--detections rrc] [--splits 8] [--seeds 3]

The ten labelled sequences are split in halves (126 ways). Real against real: the distance of the
two halves, over all splits; its 90th percentile is what a model may miss by. Synthetic against
real: a profile is fitted to one half and judged on the other, both ways, over some splits: the
profile sees the other half's labels, and its detections are measured against the real ones.
Columns: Kolmogorov-Smirnov distances of gap lengths, edge errors (the worst of the four edges)
and scores; mean differences of recall by depth and by occlusion; relative difference of the false
positives a frame; differences of pooled precision and recall.
"""

import argparse
import logging
from collections.abc import Sequence
from dataclasses import astuple, fields
from itertools import combinations
from pathlib import Path

import numpy as np

from benchmarks.kitti_tables import GIVEN
from mot_sim.datasets import kitti_sequence
from mot_sim.simulation.sensors.fitting.calibrate import fit_profile, simulate
from mot_sim.simulation.sensors.fitting.measure import (
    DetectorMeasurements,
    LabelledDetections,
    measure,
)
from mot_sim.simulation.sensors.fitting.statistics import Distance
from mot_sim.simulation.sensors.profile import Profile

NAMES = [field.name for field in fields(Distance)]
WHOLE_SEEDS = 10  # of all drives: one has 10 % more false positives than another
GOALS = {"edges": 0.09, "scores": 0.09, "precision": 0.01, "recall": 0.01}


def halves() -> list[tuple[tuple[int, ...], tuple[int, ...]]]:
    """The 126 ways of splitting ten sequences in five and five."""
    everyone = set(range(10))
    return [
        (half, tuple(sorted(everyone - set(half))))
        for half in combinations(range(10), 5)
        if 0 in half
    ]


def pooled(
    profile: Profile, drives: Sequence[LabelledDetections], seeds: int
) -> DetectorMeasurements:
    """Several simulations as one: the sampling noise of the model is not the question."""
    return measure([made for seed in range(seeds) for made in simulate(profile, drives, seed)])


def table(title: str, rows: Sequence[Distance]) -> None:
    """Median, mean and 90th percentile of every figure."""
    values = np.array([astuple(row) for row in rows])
    print(f"\n{title} ({len(rows)})")
    print(f"{'':12s}" + "".join(f"{name:>14s}" for name in NAMES))
    for name, figure in (
        ("median", np.median(values, axis=0)),
        ("mean", values.mean(axis=0)),
        ("90th pct", np.quantile(values, 0.9, axis=0)),
    ):
        print(f"{name:12s}" + "".join(f"{number:14.4f}" for number in figure))


def verdict(real: Sequence[Distance], made: Sequence[Distance]) -> None:
    """Each figure beside what it has to reach."""
    print("\nverdict: median of synthetic against real, and its limit")
    for number, name in enumerate(NAMES):
        reached = float(np.median([astuple(row)[number] for row in made]))
        limit = float(np.quantile([astuple(row)[number] for row in real], 0.9))
        line = f"{name:12s} {reached:8.4f}   real halves' 90th percentile {limit:8.4f}"
        line += f"  {'reached' if reached <= limit else 'MISSED'}"
        if name in GOALS:
            line += f"   goal {GOALS[name]:g} {'reached' if reached <= GOALS[name] else 'MISSED'}"
        print(line)


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("--root", type=Path, required=True, help="the KITTI tree")
    parser.add_argument("--detections", default="rrc")
    parser.add_argument("--splits", type=int, default=8, help="both halves of each are fitted")
    parser.add_argument("--seeds", type=int, default=3)
    arguments = parser.parse_args()
    logging.basicConfig(level=logging.ERROR)
    sequences = [kitti_sequence(arguments.root, name, arguments.detections) for name in GIVEN]
    drives = [LabelledDetections.of(sequence) for sequence in sequences]
    splits = halves()
    measured = {half: measure([drives[i] for i in half]) for pair in splits for half in pair}
    real = [Distance.between(measured[one], measured[other]) for one, other in splits]
    table("real against real: one half against the other", real)
    made = []
    for number in np.linspace(0, len(splits) - 1, arguments.splits).astype(int).tolist():
        for one, other in (splits[number], splits[number][::-1]):
            profile = fit_profile([drives[i] for i in one])
            synthetic = pooled(profile, [drives[i] for i in other], arguments.seeds)
            made.append(Distance.between(synthetic, measured[other]))
    table("synthetic against real: fitted to one half, judged on the other", made)
    verdict(real, made)
    profile = fit_profile(drives)
    seeds = max(arguments.seeds, WHOLE_SEEDS)
    whole = Distance.between(pooled(profile, drives, seeds), measure(drives))
    table("fitted to all ten and judged on them", [whole])


if __name__ == "__main__":
    main()
