"""Cuboids of real cars: boxes alone against boxes with the network's keypoints.

    python -m benchmarks.pose_real --root KITTI [--markdown]

RRC's boxes, OXTS, the frames of 0000, 0005 and 0009 that have an image. Of every row that meets a
label in the image: how far centre, heading and size are off (medians, shares of rows); and the
frames per CPU second of one thread, of the tracker and with the network and the fit.
"""

import argparse
from dataclasses import replace
from pathlib import Path
from time import process_time

import numpy as np
from rich.console import Console

from mot_sim.datasets import KittiSequence, kitti_sequence
from mot_sim.evaluation.runs import Recipe
from mot_sim.metrics.cuboid_errors import CuboidErrors, cuboid_errors, median
from mot_sim.tables import Column, Table
from mot_sim.tables.columns import Cell, Row
from tracker import Frame, Tracks
from tracker.geometry import invert

CLIPS = ("0000", "0005", "0009")
CUES = {"boxes": "none", "boxes + keypoints": "pose"}
SCORES = (
    "centre_median", "centre_p90", "within_2m", "heading_over_30", "heading_over_90",
    "heading_over_30_turned", "length_error", "height_error", "width_error", "parked_over_1mps",
)  # fmt: skip
COLUMNS = (
    Column("clip", "name"), Column("cues", "name"), Column("rows", "count"),
    Column("centre, m", "value", digits=2), Column("90 %, m", "value", digits=2),
    Column("in 2 m", "rate"), Column("> 30°", "rate"), Column("> 90°", "rate"),
    Column("> 30°, turned", "rate"), Column("length, m", "value", digits=2),
    Column("height, m", "value", digits=2), Column("width, m", "value", digits=2),
    Column("parked > 1 m/s", "rate"), Column("yaw, deg", "value", digits=1),
    Column("tracker, frames/s", "count"), Column("all, frames/s", "count"),
)  # fmt: skip
Measured = tuple[CuboidErrors, int, float, float]


def main() -> None:
    """Print the table, as Markdown with --markdown."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--root", type=Path)
    parser.add_argument("--markdown", action="store_true")
    told = parser.parse_args()
    rows: list[Row] = []
    every: dict[str, list[Measured]] = {name: [] for name in CUES}
    for number, clip in enumerate(CLIPS):
        sequence = kitti_sequence(told.root, clip, images=True)
        frames = [frame for frame in sequence if frame.image is not None]
        for name, cues in CUES.items():
            if number == 0:
                measure(sequence, frames[:5], cues)  # what a first call loads costs no frames
            every[name].append(measure(sequence, frames, cues))
            rows.append(row_of(clip, name, every[name][-1:]))
    rows += [row_of("all", name, parts) for name, parts in every.items()]
    table = Table(COLUMNS, tuple(rows), "Real cars: boxes alone, and with keypoints")
    print(table.as_markdown()) if told.markdown else Console(width=200).print(table)


def measure(sequence: KittiSequence, frames: list[Frame], cues: str) -> Measured:
    """The errors of one run; how many frames it had; CPU seconds of the tracker, and of all."""
    recipe = Recipe(cues=cues)
    front_end, tracker = recipe.front_end, recipe.build(sequence.camera)
    output, measuring, tracking = [], 0.0, 0.0
    for frame in frames:
        begin = process_time()
        seen = frame if front_end is None else front_end(frame, sequence.camera)
        middle = process_time()
        output.append(tracker.step(replace(seen, image=None)))
        measuring, tracking = measuring + middle - begin, tracking + process_time() - middle
    assert sequence.truth is not None
    assert sequence.Ts_world_cam is not None
    labels = np.isin(sequence.truth.frames, [frame.index for frame in frames])
    errors = cuboid_errors(
        sequence.truth.select(labels), Tracks.concatenate(output), sequence.frame_count,
        sequence.Ts_world_cam @ invert(sequence.camera.T_road_cam), sequence.frame_rate,
    )  # fmt: skip
    return errors, len(frames), tracking, measuring + tracking


def row_of(clip: str, name: str, parts: list[Measured]) -> Row:
    """The scores over the rows of several runs."""
    errors = CuboidErrors.concatenate([part[0] for part in parts])
    count = sum(part[1] for part in parts)
    tracking, everything = sum(part[2] for part in parts), sum(part[3] for part in parts)
    numbers = errors.numbers()
    cells = [*(float(numbers[score]) for score in SCORES), np.degrees(median(errors.heading))]
    plain: list[Cell] = [None if np.isnan(cell) else float(cell) for cell in cells]
    return (clip, name, len(errors), *plain, round(count / tracking), round(count / everything))


if __name__ == "__main__":
    main()
