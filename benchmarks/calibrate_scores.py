"""The score maps of DETECTORS: how a detector's score becomes the probability of a right box.

    python -m benchmarks.calibrate_scores --root KITTI

A logistic curve by maximum likelihood over the ten given sequences. A box is right when it is
matched (IoU >= 0.5, one to one) to a counted car; boxes on neutral labels (vans, truncated), in
DontCare regions or at most 25 px high do not take part, as in the TrackEval rules.
"""

import argparse
import logging
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy import ndarray as Array
from scipy.optimize import minimize

from benchmarks.kitti_tables import GIVEN
from mot_sim.datasets import DETECTORS, KittiSequence, kitti_sequence
from mot_sim.metrics.matching import EPSILON
from mot_sim.metrics.preprocessing import ignored_if_unmatched, match_cars, prepare_sequence
from tracker import Tracks


def right_rows(sequence: KittiSequence, output: Tracks) -> tuple[Array, Array]:
    """Which rows are right, and which do not take part."""
    assert sequence.truth is not None
    contest = prepare_sequence(sequence.truth, output, sequence.frame_count)
    matched = match_cars(contest.overlaps)
    columns = contest.overlaps.columns[matched]
    aside = ignored_if_unmatched(contest, EPSILON)
    aside[columns] = contest.neutral[contest.overlaps.rows[matched]]
    right = np.zeros(len(output), bool)
    right[columns] = True
    return right, aside


def judged(sequence: KittiSequence) -> tuple[Array, Array]:
    """The raw scores of the boxes that take part, and whether each is right."""
    log = sequence.log
    rows = np.arange(len(log.frames))
    output = Tracks(log.frames, rows, log.detections.boxes, log.detections.scores)
    right, aside = right_rows(sequence, output)
    return log.detections.scores[~aside], right[~aside]


def fit(scores: Array, right: Array) -> tuple[float, float]:
    """Midpoint and scale of the logistic curve."""
    sign = np.where(right, 1.0, -1.0)

    def loss(parameters: Array) -> float:
        midpoint, scale = parameters
        return float(np.logaddexp(0.0, -sign * (scores - midpoint) / scale).mean())

    start = np.array([np.median(scores), np.std(scores) + 1e-3])
    midpoint, scale = minimize(loss, start, method="Nelder-Mead").x
    return float(midpoint), float(scale)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--root", type=Path, required=True, help="the KITTI tree")
    root = parser.parse_args().root
    logging.basicConfig(level=logging.ERROR)
    print("detector     boxes   right   midpoint   scale   in the code")
    for name in ("rrc", "permatrack", "pointrcnn"):
        raw = replace(DETECTORS[name], score_map=None)
        DETECTORS["raw scores"] = raw
        try:
            folder = root / "detections" / name
            parts = [
                judged(kitti_sequence(root, n, folder, detection_format="raw scores"))
                for n in GIVEN
            ]
        finally:
            del DETECTORS["raw scores"]
        scores, right = (np.concatenate(column) for column in zip(*parts, strict=True))
        midpoint, scale = fit(scores, right)
        known = DETECTORS[name].score_map
        print(
            f"{name:10s} {len(scores):7d} {100 * right.mean():6.1f}% {midpoint:10.3f} {scale:7.3f}"
            f"   {known.midpoint:g}, {known.scale:g}"
        )


if __name__ == "__main__":
    main()
