"""Weights of all cues in Table V: what each vector brings over 2D-2D alone, in every framework.

    python -m benchmarks.cue_weights --root KITTI [--made 32] [--out DIR] [--jobs 1]

Tracker, drives and rules are those of `mot-sim tables --table V`. A row a weight vector: its HOTA
less that of image_overlap alone, in points. With --root: KITTI's given sequences together, a
column a detector and framework; then the vector is chosen by the mean of the columns on all folds
but one, and scored on that one. With --made N: N drives of the intersection, profile `rrc` with
cues, seeds from 1000, on which no table reports; means ± half of the 95 % interval, drive by
drive. DIR keeps every result: the same command goes on after Ctrl-C.
"""

import argparse
import logging
from collections.abc import Mapping, Sequence
from contextlib import nullcontext
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import NamedTuple

import numpy as np
from numpy import ndarray as Array

from mot_sim.cli.terminal import Terminal
from mot_sim.experiments.paper.cue_sets import SINGLE, in_frameworks, with_cues
from mot_sim.experiments.paper.intersections import TUNING_SEEDS
from mot_sim.experiments.sweep.paths import Level
from mot_sim.experiments.sweep.tracker_specs import TrackerSpec
from mot_sim.experiments.tuning.folds import balanced_folds, traits_of
from mot_sim.experiments.tuning.labelled import LabelledSequence, kitti_drives, made_drives
from mot_sim.experiments.tuning.measuring import KittiBenchmark
from mot_sim.metrics import Scores, combine
from mot_sim.tables import Column, Interval, Row, Table, mean_column
from tracker import FRAMEWORKS
from tracker.errors import TrackingError


class Weights(NamedTuple):
    """One weight a cost; 0: without it."""

    image_overlap: float
    volume: float = 0.0
    reprojection: float = 0.0
    appearance: float = 0.0
    shape_pose: float = 0.0

    def __str__(self) -> str:
        """As a tracker's setting."""
        return "+".join(f"{name}={weight:g}" for name, weight in self._asdict().items() if weight)


Found = list[dict[str, Scores]]  # a drive, a tracker
ALONE = SINGLE["2D-2D"]
# The first of each is what Table V had before any was chosen.
ON_KITTI = (
    Weights(0.8, 0.1, 0.1), Weights(0.9, 0.02, 0.08), Weights(0.85, 0.05, 0.1),
    Weights(0.9, 0.05, 0.05), Weights(0.85, 0.03, 0.12), Weights(0.95, 0.025, 0.025),
)  # fmt: skip
ON_MADE = (
    Weights(0.6, 0.1, 0.1, 0.15, 0.05), Weights(0.4, 0.15, 0.02, 0.42, 0.01),
    Weights(0.5, 0.15, 0.03, 0.31, 0.01), Weights(0.7, 0.0, 0.0, 0.3),
    Weights(0.3, 0.2, 0.02, 0.47, 0.01), Weights(0.6, 0.05, 0.05, 0.29, 0.01),
    Weights(0.5, 0.2, 0.02, 0.27, 0.01),
)  # fmt: skip


def by_drive(
    bench: KittiBenchmark,
    what: str,
    drives: Sequence[LabelledSequence],
    rivals: Sequence[TrackerSpec],
    rules: str,
) -> Found:
    """The scores of each tracker on each drive alone."""
    found = (bench.measure(f"{what}, {drive.name}", [drive], rivals) for drive in drives)
    return [{name: scores[rules] for name, scores in each.items()} for each in found]


def show(title: str, heads: Sequence[str], rows: Sequence[Row]) -> None:
    """A Markdown table."""
    print(f"**{title}**\n\n{Table(tuple(map(Column, heads)), tuple(rows)).as_markdown()}")


def hota(found: Mapping[str, Found], chosen: Sequence[str], places: Sequence[int]) -> Array:
    """HOTA in % of these drives together by detector and framework; chosen: costs a drive."""
    parts = (
        [each[n][f"{chosen[n]}, {framework}"] for n in places]
        for each in found.values()
        for framework in FRAMEWORKS
    )
    return np.array([100.0 * combine(part)["HOTA"] for part in parts])


def kitti_tables(
    bench: KittiBenchmark, drives: Mapping[str, Sequence[LabelledSequence]], folds: int
) -> None:
    """All vectors on all drives, then each fold by the choice of the others; by detector."""
    one, costs = next(iter(drives.values())), [str(weights) for weights in ON_KITTI]
    fold_of = balanced_folds(np.array([traits_of(drive.truth) for drive in one]), folds)
    rivals = in_frameworks({each: each for each in (ALONE, *costs)})
    found = {
        name: by_drive(bench, name, some, rivals, "trackeval") for name, some in drives.items()
    }
    every, alone = range(len(one)), [ALONE] * len(one)

    def gains(chosen: Sequence[str], places: Sequence[int]) -> Array:
        return hota(found, chosen, places) - hota(found, alone, places)

    def cells(values: Array) -> tuple[str, ...]:
        return tuple(f"{value:+.2f}" for value in (*values, values.mean(), values.min()))

    columns = [f"{name}, {framework}" for name in drives for framework in FRAMEWORKS]
    heads = (*columns, "mean", "least")
    whole = (f"{value:.2f}" for value in hota(found, alone, every))
    lines = [(each, *cells(gains([each] * len(one), every))) for each in costs]
    title = f"KITTI, {len(one)} sequences, OXTS, rules TrackEval: HOTA less that of {ALONE}"
    show(title, ("weights", *heads), [(f"HOTA of {ALONE}", *whole, "", ""), *lines])
    chosen, lines = list(alone), []
    for fold in range(folds):
        inside = np.flatnonzero(fold_of == fold).tolist()
        others = np.flatnonzero(fold_of != fold).tolist()
        means = [float(gains([each] * len(one), others).mean()) for each in costs]
        for place in inside:
            chosen[place] = costs[int(np.argmax(means))]
        names = " ".join(one[place].name for place in inside)
        told = (names, chosen[inside[0]], f"{max(means):+.2f}")
        lines.append((*told, *cells(gains(chosen, inside))))
    lines.append(("all, each by the others", "", "", *cells(gains(chosen, every))))
    title = f"chosen by the mean on {folds - 1} of {folds} folds, scored on the other"
    show(title, ("held out", "chosen", "mean of the others", *heads), lines)


def made_table(bench: KittiBenchmark, seeds: range, frames: int) -> None:
    """All vectors on drives of the intersection."""
    profile, costs = with_cues("rrc", bench.folder), [str(weights) for weights in ON_MADE]
    settings: dict[str, Level] = {"scene.profile": profile, "scene.frames": frames}
    bench.tell("drives to make", 0, len(seeds))
    drives = made_drives(bench.folder / "drives", ("intersection",), seeds, settings)
    rivals = in_frameworks({each: each for each in (ALONE, *costs)})
    found = by_drive(bench, "made", drives, rivals, "trackeval")
    values = {
        each: np.array([[one[f"{each}, {name}"]["HOTA"] for one in found] for name in FRAMEWORKS])
        for each in (ALONE, *costs)
    }

    def cells(some: Array, signed: bool) -> tuple[str, ...]:
        return tuple(
            mean_column("HOTA", is_signed=signed).show(*Interval.of(row).cells)
            for row in (*some, some.mean(axis=0))
        )

    lines = [(each, *cells(values[each] - values[ALONE], True)) for each in costs]
    title = (
        f"made: intersection, profile rrc with cues, {len(seeds)} seeds from {seeds.start}, "
        f"{frames} frames, rules TrackEval: HOTA less that of {ALONE}, ± half of the 95 % interval"
    )
    first = (f"HOTA of {ALONE}", *cells(values[ALONE], False))
    show(title, ("weights", *FRAMEWORKS, "mean"), [first, *lines])


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("--root", type=Path, help="the KITTI tree")
    parser.add_argument("--detections", nargs="+", default=["rrc", "pointrcnn"])
    parser.add_argument("--sequences", default="given", help="with commas; all need labels")
    parser.add_argument("--folds", type=int, default=4)
    parser.add_argument("--made", type=int, default=0, metavar="N", help="drives to make")
    parser.add_argument("--frames", type=int, default=100, help="of each made drive")
    parser.add_argument("--out", type=Path, help="where results are kept")
    parser.add_argument("--jobs", type=int, default=1)
    given = parser.parse_args()
    if given.root is None and not given.made:
        parser.error("nothing to measure: give --root KITTI, --made N, or both")
    logging.basicConfig(level=logging.ERROR)
    place = nullcontext(str(given.out)) if given.out else TemporaryDirectory()
    with place as folder, Terminal().progress(lines=True) as tell:
        bench = KittiBenchmark(Path(folder), given.jobs, tell)
        try:
            if given.root is not None:
                loaded = {
                    name: kitti_drives(given.root, given.sequences, name)
                    for name in given.detections
                }
                kitti_tables(bench, loaded, given.folds)
            if given.made:
                made_table(bench, range(TUNING_SEEDS, TUNING_SEEDS + given.made), given.frames)
        except TrackingError as error:
            parser.error(str(error))


if __name__ == "__main__":
    main()
