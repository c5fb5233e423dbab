"""What becomes of tracking when a detector's scores are on another scale, or say nothing.

    python -m benchmarks.score_scales --root KITTI [--detectors rrc pointrcnn permatrack]

KITTI's ten given sequences, OXTS, `Tracker.default`; the detector's probabilities are replaced
before the tracker sees them. Rows marked * are quoted: other trackers on the same boxes as given.
"""

import argparse
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy import ndarray as Array

from benchmarks.kitti_tables import PEERS, TRACKEVAL, Drives, drives, head, line, scores, tracked
from mot_sim.datasets.recorded import RecordedSequence
from mot_sim.metrics import Scores
from tracker import Tracker

COLUMNS = ("MOTA", "HOTA", "DetA", "AssA", "CLR_FP", "CLR_FN", "IDSW")
SMALLEST = 1e-4  # scores of 0 and 1 have no logit


def inside(scores: Array) -> Array:
    """Probabilities that have logarithms."""
    return np.clip(scores, SMALLEST, 1.0 - SMALLEST)


def shuffled(scores: Array) -> Array:
    """The same scores, each on another box."""
    return np.random.default_rng(0).permutation(scores)


SCALES: dict[str, Callable[[Array], Array]] = {
    "as given": lambda scores: scores,
    "percent": lambda scores: 100.0 * scores,
    "logits": lambda scores: np.log(inside(scores) / (1.0 - inside(scores))),
    "log probabilities": lambda scores: np.log(inside(scores)),
    "tenths of them": lambda scores: 0.1 * scores,
    "their squares": np.square,
    "their roots": np.sqrt,
    "ranks from 0 to 1": lambda scores: np.argsort(np.argsort(scores)) / max(len(scores), 1),
    "shuffled": shuffled,
    **{f"all {value:g}": (lambda scores, value=value: np.full(len(scores), value))
       for value in (0.05, 0.25, 0.5, 0.75, 1.0)},
}  # fmt: skip


def rescored(drive: RecordedSequence, scale: Callable[[Array], Array]) -> RecordedSequence:
    """The same drive with other scores on its boxes."""
    found = drive.log.detections
    log = replace(drive.log, detections=found.replaced(scores=scale(found.scores)))
    return replace(drive, log=log)


def values(score: Scores) -> list[str]:
    """As they are printed."""
    return [
        f"{score[name]:.0f}" if name[:3] in ("CLR", "IDS") else f"{100 * score[name]:.2f}"
        for name in COLUMNS
    ]


def table(root: Path, detector: str) -> None:
    """One row a scale."""
    sequences: Drives = drives(root, detector, "oxts")
    head(f"{detector}, OXTS, Tracker.default", COLUMNS)
    for name, scale in SCALES.items():
        other = [rescored(drive, scale) for drive in sequences]
        line(name, values(scores(tracked(Tracker.default, other)[0], other)))
    for peer, quoted in PEERS[detector].items():
        numbers = dict(zip(TRACKEVAL, quoted.split(), strict=True))
        line(peer, [numbers[name] for name in COLUMNS])


def main() -> None:
    """Read the arguments and print the tables."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--root", type=Path, required=True)
    parser.add_argument("--detectors", nargs="+", default=["rrc", "pointrcnn", "permatrack"])
    chosen = parser.parse_args()
    for detector in chosen.detectors:
        table(chosen.root, detector)


if __name__ == "__main__":
    main()
