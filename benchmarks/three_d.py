"""Cuboids of trackers on KITTI's given sequences: the tables of docs/results/three_d.md.

    python -m benchmarks.three_d --root KITTI [--sequences labelled] [--ego oxts] [--drives]

A row per tracker: RRC's boxes through the default tracker, with a lag of ten frames, over the whole
drive, without the car filter (cuboids are back-projected boxes), through the paper's; PointRCNN's
boxes alone; and PointRCNN's LiDAR cuboids through the same code. --drives: the default tracker
drive by drive.
"""

import argparse
from collections.abc import Callable
from dataclasses import replace
from math import isnan
from pathlib import Path

from rich.console import Console

from mot_sim.datasets import kitti_sequence
from mot_sim.evaluation.runs import Recipe, track_sequences
from mot_sim.evaluation.scoring import choose_sequences
from mot_sim.evaluation.spatial_scoring import SpatialEvaluation, score_in_3d
from mot_sim.metrics import Criterion, SpatialScores
from mot_sim.metrics.clear import Number
from mot_sim.tables import Column, Table, consistency_table, error_table
from mot_sim.tables.columns import Cell, Kind
from tracker import Camera, Delayed, Tracker, cuboid_tracker

CRITERIA = tuple(Criterion.parse(word) for word in (".25", ".5", ".7", "2m"))
COLUMNS: dict[str, tuple[str, Kind]] = {
    "sAMOTA@0.25": ("sAMOTA .25", "rate"), "sAMOTA@0.5": (".5", "rate"),
    "sAMOTA@0.7": (".7", "rate"), "MOTA3D@0.25": ("MOTA .25", "rate"),
    "MOTA3D@2m": ("MOTA 2 m", "rate"), "HOTA3D": ("HOTA 3D", "rate"),
    "centre_median": ("centre, m", "value"), "centre_p90": ("90 %, m", "value"),
    "within_2m": ("in 2 m", "rate"), "heading_over_30": ("heading > 30°", "rate"),
    "heading_over_90": ("> 90°", "rate"), "heading_over_90_moving": ("> 90°, moving", "rate"),
    "heading_over_90_oncoming": ("> 90°, oncoming", "rate"),
    "parked_over_1mps": ("parked > 1 m/s", "rate"),
    "centre_inside_2_sigma": ("in 2 sigma", "rate"),
}  # fmt: skip
Build = Callable[[Camera], Tracker | Delayed]


def without_car_filter(camera: Camera) -> Tracker:
    """The default tracker, whose cuboids are back-projected boxes of the mean car."""
    return replace(Tracker.default(camera), car_filter=None)


# What a row is called: the detector, whether its cuboids are read, the tracker.
ROWS: dict[str, tuple[str, bool, Build]] = {
    "default": ("rrc", False, Tracker.default),
    "lag of 10 frames": ("rrc", False, Recipe(lag=10).build),
    "whole drive": ("rrc", False, Recipe(associate="network_flow").build),
    "without car filter": ("rrc", False, without_car_filter),
    "paper": ("rrc", False, Tracker.paper),
    "PointRCNN's boxes": ("pointrcnn", False, Tracker.default),
    "PointRCNN's LiDAR cuboids": ("pointrcnn", True, cuboid_tracker),
}


def main() -> None:
    """Print the tables as Markdown."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--root", type=Path)
    parser.add_argument("--sequences", default="labelled")
    parser.add_argument("--ego", default="oxts")
    parser.add_argument("--drives", action="store_true")
    told = parser.parse_args()
    scores: dict[str, SpatialScores] = {}
    whole: SpatialEvaluation | None = None
    for name in ("default",) if told.drives else ROWS:
        found = evaluation_of(name, told.root, told.sequences, told.ego)
        scores[name], whole = found.combined, whole or found
        Console(stderr=True).print(f"{name}: done")
    assert whole is not None
    if told.drives:
        scores = {**whole.sequences, "all": whole.combined}
    print(summary_table(scores).as_markdown())
    if not told.drives:
        print(error_table(whole.combined.errors).as_markdown())
        stated = consistency_table(whole.combined.errors)
        print("" if stated is None else stated.as_markdown())


def evaluation_of(name: str, root: Path | None, sequences: str, ego: str) -> SpatialEvaluation:
    """A row's scores on the labelled sequences."""
    detections, cuboids, build = ROWS[name]
    drives = [
        kitti_sequence(root, drive, detections, ego, cuboids=cuboids)
        for drive in choose_sequences(root, sequences)
    ]
    return score_in_3d(drives, track_sequences(drives, build).tracks, CRITERIA)


def summary_table(scores: dict[str, SpatialScores]) -> Table:
    """A row for each of the scores."""
    columns = [Column("", "name", "row")]
    for name, (title, kind) in COLUMNS.items():
        columns.append(Column(title, kind, name, 1 if kind == "rate" else 2))
    rows = tuple((name, *cells_of(each.numbers())) for name, each in scores.items())
    return Table(tuple(columns), rows)


def cells_of(numbers: dict[str, Number]) -> list[Cell]:
    """The scores of the columns; None where nothing is known."""
    values = [float(numbers[name]) for name in COLUMNS]
    return [None if isnan(value) else value for value in values]


if __name__ == "__main__":
    main()
