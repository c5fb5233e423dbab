"""What the intersections hide, and how trackers fare there.

    python -m benchmarks.intersections [--seeds 3] [--trackers default,paper,sort]

Every scene whose name begins with `intersection` is run, with its own knobs and with those of
VARIANTS. Printed are the labels' cars a frame, the share that is largely occluded, the length of
occlusions (median and the longest tenth), and the trackers' HOTA, MOTA and identity switches over
all runs. A guest such as sort needs its environment: mot-sim compare --setup sort.
"""

import argparse
from collections.abc import Iterator

import numpy as np

from mot_sim.experiments.validation import Contestant, find_contestant, run_contestants
from mot_sim.experiments.validation.worlds import World, scene_worlds
from mot_sim.metrics import Scores, combine
from mot_sim.simulation.drive_statistics import DRIVE_STATISTICS, MeasuredDrive, occluded_seconds
from mot_sim.simulation.episode import Episode
from mot_sim.simulation.registry import SCENES, Knob, find_scene
from mot_sim.tables import Column, Row, Table

VARIANTS: dict[str, tuple[dict[str, Knob], ...]] = {"intersection_left_turn": ({"truck": True},)}


def runs() -> Iterator[tuple[str, dict[str, Knob]]]:
    """Names and knobs of the rows."""
    for name in SCENES:
        if name.startswith("intersection"):
            for knobs in ({}, *VARIANTS.get(name, ())):
                yield name, knobs


def row_of(name: str, knobs: dict[str, Knob], seeds: int, contestants: list[Contestant]) -> Row:
    """The figures of a scene."""
    worlds = list(scene_worlds(find_scene(name, **knobs), range(seeds)))
    drives = [measured(world) for world in worlds]
    times = np.concatenate([occluded_seconds(drive) for drive in drives])
    median, long = np.quantile(times, (0.5, 0.9)).tolist() if len(times) else (None, None)
    cells: list[str | float | int | None] = [
        ", ".join([name, *(f"{knob}={value}" for knob, value in knobs.items())]),
        DRIVE_STATISTICS["cars"].of(drives), DRIVE_STATISTICS["occluded"].of(drives), median, long,
    ]  # fmt: skip
    outcome = run_contestants(contestants, worlds, None, 1, lambda *_: None)
    for each in contestants:
        by_world = outcome.scores.get(each.name, {})
        scores: list[Scores] = [one for found in by_world.values() for one in found]
        whole = combine(scores) if scores else None
        cells += [None] * 3 if whole is None else [whole["HOTA"], whole["MOTA"], int(whole["IDSW"])]
    return tuple(cells)


def measured(world: World) -> MeasuredDrive:
    """The one drive of a world of a scene, by its labels."""
    (episode,) = world.drives
    assert isinstance(episode, Episode)
    return MeasuredDrive.of_labels(episode.name, episode.traffic.ego, episode.truth)


def main() -> None:
    """Print the table as it grows, and at last as Markdown."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("--seeds", type=int, default=3, help="runs of every scene")
    parser.add_argument("--trackers", default="default,paper,sort")
    arguments = parser.parse_args()
    contestants = [find_contestant(name) for name in arguments.trackers.split(",")]
    columns = [
        Column("scene", "name"), Column("cars a frame", "value", digits=1),
        Column("largely occluded, %", "rate", digits=0),
        Column("occlusions, s: median", "value", digits=1), Column("90 %", "value", digits=1),
    ]  # fmt: skip
    for each in contestants:
        columns += [
            Column(f"{each.name}: HOTA", "rate", digits=1),
            Column("MOTA", "rate", f"{each.name} MOTA", 1),
            Column("IDSW", "count", f"{each.name} IDSW"),
        ]
    rows: list[Row] = []
    for name, knobs in runs():
        rows.append(row_of(name, knobs, arguments.seeds, contestants))
        print(rows[-1], flush=True)
    print(Table(tuple(columns), tuple(rows)).as_markdown())


if __name__ == "__main__":
    main()
