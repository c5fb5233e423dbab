"""The weights of `GapRows`: which predicted boxes of undetected cars are right.

    python -m benchmarks.gap_rows --root KITTI

A logistic model by maximum likelihood over the given drives and four detectors. A row is right when
it is matched (IoU >= 0.5, one to one, detected rows too) to a counted car; rows on neutral labels,
in DontCare regions or at most 25 px high do not take part. For every detector: how many rows take
part, how many are right; and of the rows put out the right ones less the wrong ones, with the rule
of `ExistenceFilter`, by weights fitted on the other drives, and by those of the code.
"""

import argparse
import logging
from dataclasses import dataclass, field, fields, replace
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy import ndarray as Array
from scipy.optimize import minimize

from benchmarks.calibrate_scores import right_rows
from benchmarks.kitti_tables import GIVEN
from mot_sim.datasets import KittiSequence, kitti_sequence
from tracker import Camera, Tracker, Tracks
from tracker.gap_rows import GapRows, gap_features
from tracker.lifecycle import ActiveTracks
from tracker.types import CarEstimates

DETECTORS = ("rrc", "pointrcnn", "permatrack", "degraded")
RIDGE = 0.5


@dataclass(frozen=True)
class AllGapRows(GapRows):
    """Puts out all rows, and keeps what tells them apart."""

    seen: list[tuple[Array, Array]] = field(default_factory=list)
    """Ids and features of every frame that had such rows."""

    def __call__(
        self, tracks: ActiveTracks, estimates: CarEstimates, camera: Camera
    ) -> tuple[Array, Array]:
        """Their probabilities, and that all of them are put out."""
        probabilities, _ = super().__call__(tracks, estimates, camera)
        again = tracks.hits > 1
        kept = again.nonzero()[0]
        features = gap_features(tracks.select(kept), estimates.select(kept), camera)
        self.seen.append((tracks.ids[kept], features))
        return probabilities, again


class Judged(NamedTuple):
    """The rows that take part, one a row."""

    features: Array
    """(n, 7): 1, then those of `gap_features`."""
    right: Array
    """Whether each is right."""
    by_existence: Array
    """Whether `ExistenceFilter` would put it out."""


def judged(drive: KittiSequence) -> Judged:
    """All rows in gaps of the default tracker."""
    every = AllGapRows()
    tracker = replace(Tracker.default(drive.camera), gap_rows=every)
    steps, gone, old = [], [], []
    features = []
    for frame in drive:
        count = len(every.seen)
        steps.append(tracker.step(frame))
        ids, found = every.seen[count] if len(every.seen) > count else (np.zeros(0, int), [])
        gone.append(np.isin(steps[-1].ids, ids))
        features.extend(found)
        tracks = tracker.state.tracks
        assert tracker.existence is not None
        written = tracks.ids[tracker.existence.written(tracks)]
        old.append(np.isin(steps[-1].ids, written))
    rows, which = Tracks.concatenate(steps), np.concatenate(gone)
    right, aside = right_rows(drive, rows)
    part = ~aside[which]
    table = np.array(features).reshape(-1, 6)[part]
    return Judged(
        np.column_stack((np.ones(len(table)), table)),
        right[which][part],
        np.concatenate(old)[which][part],
    )


def fit(features: Array, right: Array) -> Array:
    """The weights of the logistic model, the intercept first."""
    sign = np.where(right, 1.0, -1.0)

    def loss(weights: Array) -> tuple[float, Array]:
        margin = sign * features.dot(weights)
        pull = np.concatenate(([0.0], weights[1:]))
        slope = -(sign / (1.0 + np.exp(margin))).dot(features)
        value = np.logaddexp(0.0, -margin).sum() + 0.5 * RIDGE * pull.dot(pull)
        return float(value), slope + RIDGE * pull

    fitted: Array = minimize(loss, np.zeros(features.shape[1]), jac=True).x
    return fitted


def gain(rows: Judged, written: Array) -> int:
    """Right rows less wrong ones, of those put out."""
    return int(rows.right[written].sum() - (~rows.right[written]).sum())


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--root", type=Path, required=True, help="the KITTI tree")
    root = parser.parse_args().root
    logging.basicConfig(level=logging.ERROR)
    tables: dict[str, dict[str, Judged]] = {}
    for detector in DETECTORS:
        tables[detector] = {n: judged(kitti_sequence(root, n, detector)) for n in GIVEN}
    every = [rows for drives in tables.values() for rows in drives.values()]
    together = [np.concatenate(column) for column in zip(*every, strict=True)]
    weights = fit(together[0], together[1])
    code = GapRows()
    for part, weight, known in zip(fields(GapRows), weights, code.weights, strict=False):
        print(f"{part.name:10s} {weight:6.2f}   in the code {known:6.2f}")
    print("detector     rows  right   by existence  left-out drives  in the code")
    for detector, drives in tables.items():
        old = sum(gain(rows, rows.by_existence) for rows in drives.values())
        now = sum(gain(rows, rows.features.dot(code.weights) > 0.0) for rows in drives.values())
        left_out = 0
        for drive, rows in drives.items():
            others = [t for table in tables.values() for n, t in table.items() if n != drive]
            columns = [np.concatenate(column) for column in zip(*others, strict=True)]
            left_out += gain(rows, rows.features.dot(fit(columns[0], columns[1])) > 0.0)
        count = sum(len(rows.right) for rows in drives.values())
        right = sum(int(rows.right.sum()) for rows in drives.values())
        print(f"{detector:10s} {count:6d} {right:6d} {old:12d} {left_out:16d} {now:12d}")


if __name__ == "__main__":
    main()
