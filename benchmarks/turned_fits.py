"""How many fits are trusted, and how many of these are turned round, by `ShapeFit.min_turned_gap`.

    python -m benchmarks.turned_fits [--seeds 2] [--frames 40] [--root KITTI]

Made cars: junctions as the camera sees them, profile `rrc`, cars at least nine tenths visible; the
setting is the highest of GAPS that keeps nine tenths of the right fits there. Real cars: those of
`benchmarks.keypoints --real`. A fit is turned when its yaw is off by more than 90 degrees.
"""

import argparse
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy import ndarray as Array

from benchmarks.keypoint_real import SHARE, clips
from mot_sim.simulation.episode import record
from mot_sim.simulation.registry import find_scene
from mot_sim.simulation.sensors.sightings import Sightings
from mot_sim.tables import Column, Table
from mot_sim.tables.columns import Row
from tracker.geometry import box_iou, wrap_angle
from tracker.shape import Hourglass, ShapeFit

SCENES, FIRST_SEED = ("intersection", "roundabout", "t_junction"), 3000
GAPS = (-np.inf, -2.0, 0.0, 1.0, 1.5, 2.0, 2.5, 3.0, 4.0)
KEPT = 0.9
SAME, PLAIN = 0.6, 0.9  # overlap with the true box; visible share
FIT = ShapeFit(min_turned_gap=-1e9)  # trusts whatever fits
COLUMNS = (
    Column("cars", "name"), Column("gap from", "value", digits=1), Column("trusted", "count"),
    Column("turned", "count"), Column("of them, %", "rate"), Column("right ones kept, %", "rate"),
    Column("yaw, deg", "value", digits=2),
)  # fmt: skip


@dataclass(frozen=True, eq=False)
class Fits:
    """Fits of cars whose yaw is known, one row each, those that fit well enough."""

    error: Array
    """How far the yaw is off, degrees."""
    gap: Array
    """`FittedCars.turned_gap`."""


def made_fits(hourglass: Hourglass, seeds: int, frames: int) -> Iterator[Fits]:
    """The fits to cars of junctions, drive by drive."""
    for scene in SCENES:
        for seed in range(FIRST_SEED, FIRST_SEED + seeds):
            episode = record(
                find_scene(scene, frames=frames, profile="rrc"), seed, renderer="raster"
            )
            true = Sightings.from_truth(episode.exact, episode.vehicles)
            for frame in episode:
                here = np.flatnonzero((true.frames == frame.index) & (true.visible >= PLAIN))
                boxes = frame.detections.boxes
                if not len(here) or not len(boxes) or frame.image is None:
                    continue
                overlap = box_iou(boxes[:, None], true.boxes[here][None])
                sure = np.flatnonzero(overlap.max(axis=1) >= SAME)
                yaw = true.cuboids.yaw[here[overlap[sure].argmax(axis=1)]]
                keypoints = hourglass(frame.image[:, :, ::-1], boxes[sure]).keypoints
                sides = boxes[sure, 2:] - boxes[sure, :2]
                fitted = FIT(keypoints, episode.camera, SHARE * sides)
                off = np.degrees(np.abs(wrap_angle(fitted.yaw - yaw)))
                yield Fits(off[fitted.fits], fitted.turned_gap[fitted.fits])


def rows_of(name: str, fits: list[Fits]) -> list[Row]:
    """A row of the table for each setting."""
    error = np.concatenate([each.error for each in fits])
    gap = np.concatenate([each.gap for each in fits])
    right, rows = error <= 90.0, list[Row]()
    for least in GAPS:
        kept = gap >= least
        turned, count = int((kept & ~right).sum()), int(kept.sum())
        rows.append((
            name, None if np.isinf(least) else least, count, turned, turned / max(count, 1),
            float(kept[right].mean()), float(np.median(error[kept])) if count else None,
        ))  # fmt: skip
    return rows


def main() -> None:
    """Print the table, and the setting that the made cars choose."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", type=int, default=2)
    parser.add_argument("--frames", type=int, default=40)
    parser.add_argument("--weights", type=Path, help="an ONNX file; the shipped one unless given")
    parser.add_argument("--root", type=Path)
    told = parser.parse_args()
    hourglass = Hourglass.load(told.weights)
    made = rows_of("made", list(made_fits(hourglass, told.seeds, told.frames)))
    rows = list(made)
    if told.root is not None:
        for what, detected in (("labels' boxes", False), ("rrc's boxes", True)):
            scored = [one for _, one in clips(hourglass, told.root, detected)]
            for kind in ("Car", "Van"):
                some = [
                    Fits(one.error[wanted], one.turned_gap[wanted])
                    for one in scored
                    for wanted in [one.fits & (one.labels.kinds == kind)]
                ]
                rows += rows_of(f"real {kind}s, {what}", some)
    print(Table(COLUMNS, tuple(rows), "Fits, and those turned round").as_markdown())
    shares = zip(GAPS, (row[5] for row in made), strict=True)
    best = max(least for least, kept in shares if isinstance(kept, float) and kept >= KEPT)
    print(f"made cars: {100 * KEPT:g} % of the right fits stay with min_turned_gap {best:g}")


if __name__ == "__main__":
    main()
