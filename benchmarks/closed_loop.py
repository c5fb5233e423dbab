"""Does the testbed foretell what a tracker does on KITTI? The same trackers on real and made boxes.

    python -m benchmarks.closed_loop --root KITTI [--detections rrc] [--seeds 10]

The labelled cars of the ten given sequences are seen by the fitted profile in place of the
detector; camera, ego-motion, labels and scoring stay KITTI's. Printed: every variant's MOTA, HOTA
and identity switches on KITTI beside the synthetic ones (median over the seeds, and their range),
and Spearman's rank correlation of the variants by HOTA and by switches.

Detections that no label owns (in DontCare regions, at most 25 px high) exist only on the real side.
"""

import argparse
import logging
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
from scipy.stats import spearmanr

from benchmarks.kitti_tables import GIVEN, IMAGE
from mot_sim.datasets import KittiSequence, kitti_sequence
from mot_sim.metrics import evaluate
from mot_sim.runs import track_sequence
from mot_sim.sensors import Detector, Profile, Sightings, find_profile
from mot_sim.sensors.calibrate import fit_profile
from mot_sim.sensors.measure import Drive
from tracker import Camera, Tracker
from tracker.association import Greedy
from tracker.lifecycle import Lifecycle
from tracker.suppression import Suppression

MOST_MOTA, MOST_HOTA, MOST_IDSW, LEAST_RANK = 1.5, 2.5, 0.35, 0.9
Scores = tuple[float, float, float]
Variant = tuple[str, str, Callable[[Camera], Tracker]]


def default(**changes: object) -> Callable[[Camera], Tracker]:
    """Tracker.default with some parts replaced."""
    return lambda camera: replace(Tracker.default(camera), **changes)


VARIANTS: tuple[Variant, ...] = (
    ("default", "oxts", default()),
    ("paper", "oxts", Tracker.paper),
    ("default without ego-motion", "none", default()),
    ("greedy", "oxts", default(associate=Greedy(0.7))),
    ("IoU of neighbours, Hungarian", "none", default(
        costs=((1.0, IMAGE),), lifecycle=Lifecycle(0.0, 0.0), strong_score=0.0,
    )),
    ("scores from .1", "oxts", default(suppress=Suppression(0.1, 0.5))),
    ("scores from .9, one stage", "oxts", default(
        suppress=Suppression(0.9, 0.5), strong_score=0.0,
    )),
    ("memory 0.5 s", "oxts", default(lifecycle=Lifecycle(0.8, 0.5))),
    ("no memory", "oxts", default(lifecycle=Lifecycle(0.8, 0.0))),
    ("paper, memory 0.3 s, births from .8", "oxts", lambda camera: replace(
        Tracker.paper(camera), lifecycle=Lifecycle(0.8, 0.3))),
)  # fmt: skip


def synthetic(drives: Sequence[KittiSequence], profile: Profile, seed: int) -> list[KittiSequence]:
    """The same drives with made detections. (A rendered re-enactment takes this one's place.)"""
    detector, made = Detector(profile), []
    for number, drive in enumerate(drives):
        assert drive.truth is not None
        sensed = detector.sense(
            Sightings.from_labels(drive.truth), 1000 * seed + number, drive.camera,
            1.0 / drive.frame_rate, np.arange(drive.frame_count),
        )  # fmt: skip
        made.append(replace(drive, log=sensed.log))
    return made


def scores(drives: Sequence[KittiSequence], variant: Variant) -> Scores:
    """MOTA and HOTA in percent, identity switches."""
    _, ego, build = variant
    results = {}
    for drive in drives:
        heard = drive if ego == "oxts" else replace(drive, Ts_world_cam=None)
        tracks, _ = track_sequence(build(drive.camera), heard)
        results[drive.name] = (drive.truth, tracks, drive.frame_count)
    combined = evaluate(results).combined
    return 100 * combined["MOTA"], 100 * combined["HOTA"], combined["IDSW"]


def profile_of(name: str, drives: Sequence[KittiSequence], fit: bool) -> Profile:
    """The shipped profile, or one fitted here and now."""
    if not fit:
        return find_profile(name)
    labelled = [Drive(d.truth, d.log, d.frame_count, d.camera) for d in drives if d.truth]
    return fit_profile(labelled)


def show(real: Sequence[Scores], made: np.ndarray) -> None:
    """The table, how many variants are within reach, and the ranks."""
    middle = np.median(made, axis=1)
    print(
        f"{'':40s}{'MOTA':>8s}{'made':>8s}{'HOTA':>8s}{'made':>8s}{'IDSW':>7s}{'made':>7s}  range"
    )
    for (name, _, _), kitti, ours, each in zip(VARIANTS, real, middle, made, strict=True):
        print(
            f"{name:40s}{kitti[0]:8.2f}{ours[0]:8.2f}{kitti[1]:8.2f}{ours[1]:8.2f}"
            f"{kitti[2]:7.0f}{ours[2]:7.0f}  {each[:, 2].min():.0f}-{each[:, 2].max():.0f}"
        )
    kitti = np.array(real)
    off = np.abs(middle - kitti)
    off[:, 2] /= np.maximum(kitti[:, 2], 1.0)
    for column, (name, limit) in enumerate(
        (("MOTA", MOST_MOTA), ("HOTA", MOST_HOTA), ("IDSW, relative", MOST_IDSW))
    ):
        inside, worst = int((off[:, column] <= limit).sum()), off[:, column].max()
        print(f"{name}: {inside} of {len(off)} variants within {limit:g}, worst {worst:.2f}")
    for column, name in ((1, "HOTA"), (2, "IDSW")):
        rank = float(spearmanr(kitti[:, column], middle[:, column]).statistic)
        print(f"rank correlation by {name}: {rank:.3f} (goal {LEAST_RANK:g})")


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("--root", type=Path, required=True, help="the KITTI tree")
    parser.add_argument("--detections", default="rrc")
    parser.add_argument("--seeds", type=int, default=10)
    parser.add_argument("--fit", action="store_true", help="fit the profile now")
    arguments = parser.parse_args()
    logging.basicConfig(level=logging.ERROR)
    drives = [kitti_sequence(arguments.root, name, arguments.detections) for name in GIVEN]
    profile = profile_of(arguments.detections, drives, arguments.fit)
    real = [scores(drives, variant) for variant in VARIANTS]
    made = np.zeros((len(VARIANTS), arguments.seeds, 3))
    for seed in range(arguments.seeds):
        seen = synthetic(drives, profile, seed)
        for number, variant in enumerate(VARIANTS):
            made[number, seed] = scores(seen, variant)
    print(
        f"{arguments.detections}: KITTI beside the profile {profile.name}, {arguments.seeds} seeds"
    )
    show(real, made)


if __name__ == "__main__":
    main()
