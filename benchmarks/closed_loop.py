"""Does the testbed foretell what a tracker does on KITTI? Fifteen trackers on both kinds of drive.

    mot-sim compare --setup all
    python -m benchmarks.closed_loop --root KITTI [--detections rrc] [--seeds 5] [--out DIR]
    python -m benchmarks.closed_loop --root KITTI --profile all
    python -m benchmarks.closed_loop --root KITTI --profile rrc --scenes street,town --scenes-only
    python -m benchmarks.closed_loop --root KITTI ... --scenes roundabout --scenes-only --by-turns

What `mot-sim validate-sim` does, on the ten given sequences, and a verdict beside the goals. The
labelled cars are re-enacted: replayed as worlds, cast with cars of our fleet, drawn, and measured
pixel by pixel; a profile sees them in place of the detector: fitted to five sequences, judged on
the other five, both ways (--profile all: fitted to all ten and judged on them).
"""

import argparse
import logging
import sys
from collections.abc import Iterator, Mapping
from dataclasses import replace
from itertools import compress
from pathlib import Path

from rich.console import Console

from benchmarks.kitti_tables import GIVEN
from mot_sim.datasets import kitti_sequence
from mot_sim.experiments.validation import METRICS, TOLERANCES, Agreement, find_contestants
from mot_sim.experiments.validation.agreement_tables import scenes_table, validation_tables
from mot_sim.experiments.validation.likeness import kitti_reference
from mot_sim.experiments.validation.scene_ranks import write_ranks
from mot_sim.experiments.validation.validate import HALVES, Plan, validate
from mot_sim.simulation.drive_statistics import DRIVE_STATISTICS
from mot_sim.simulation.registry import SCENES
from mot_sim.tables import Table

LEAST_RANK = 0.9
MOST_OVERSTATED = 0.006  # of the lead over the best guest, MOTA and HOTA
TURNING_RATE = 8.0  # deg/s that our car turns faster than in a tenth of a drive that turns
ROWS_THAT_MAY_BE_FAR = 2  # of those within the near limit, by MOTA, HOTA and IDSW


def verdict(agreement: Agreement) -> None:
    """Each figure beside what it has to reach."""
    rows = len(agreement.names)
    for metric in METRICS:
        near, far = agreement.within(metric).sum(), agreement.within(metric, far=True).sum()
        limits, least = TOLERANCES[metric], rows - ROWS_THAT_MAY_BE_FAR
        said(
            f"{metric} within {limits.near:g}: {near:.0f} rows of {rows}", f"{least}", near >= least
        )
        said(f"{metric} within {limits.far:g}: {far:.0f} rows of {rows}", f"{rows}", far == rows)
        rank = agreement.rank_correlation(metric)
        said(f"{metric}, Spearman {rank:.3f}", f"{LEAST_RANK:g}", rank >= LEAST_RANK)
    for metric in ("MOTA", "HOTA"):
        both = agreement.leads(metric)
        if both is not None:
            over = both[1].points - both[0].points
            goal = f"{100 * MOST_OVERSTATED:g}"
            said(
                f"{metric}, lead overstated by {100 * over:+.2f}",
                goal,
                abs(over) <= MOST_OVERSTATED,
            )


def by_turns(root: Path, scenes: Mapping[str, Agreement]) -> Iterator[Table]:
    """How the scenes rank beside the real drives in which our car turns, and beside the others."""
    statistic = DRIVE_STATISTICS["ego_yaw_rate"]
    turns = {
        drive.name for drive in kitti_reference(root).drives if statistic.of([drive]) > TURNING_RATE
    }
    for title, is_in in (
        ("that turn", [name in turns for name in GIVEN]),
        ("that hardly turn", [name not in turns for name in GIVEN]),
    ):
        part = {
            scene: replace(
                agreement,
                real={
                    name: list(compress(scores, is_in)) for name, scores in agreement.real.items()
                },
            )
            for scene, agreement in scenes.items()
        }
        drives = ", ".join(compress(GIVEN, is_in))
        yield replace(scenes_table(part), title=f"Beside the drives {title}: {drives}")


def said(what: str, goal: str, is_reached: bool) -> None:
    """One line of the verdict."""
    print(f"{what:42s} goal {goal:>4s}  {'reached' if is_reached else 'MISSED'}")


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("--root", type=Path, required=True, help="the KITTI tree")
    parser.add_argument("--detections", default="rrc")
    parser.add_argument("--seeds", type=int, default=5)
    parser.add_argument("--trackers", help="names, separated by commas; all without")
    parser.add_argument("--profile", default=HALVES, help="halves, all, a name or a file")
    parser.add_argument("--scenes", help="names, separated by commas, or all; none without")
    parser.add_argument("--scenes-only", action="store_true", help="without re-enactments")
    parser.add_argument(
        "--by-turns", action="store_true", help="also beside real drives that turn, and others"
    )
    parser.add_argument("--keep-ranks", action="store_true", help="keep them with the package")
    parser.add_argument("--frames", type=int, help="of a scene's run")
    parser.add_argument("--out", type=Path, help="folder that keeps what is done")
    parser.add_argument("--jobs", type=int, default=1)
    arguments = parser.parse_args()
    logging.basicConfig(level=logging.ERROR)
    names, scenes = (
        [] if given is None else given.split(",")
        for given in (arguments.trackers, arguments.scenes)
    )
    if scenes == ["all"]:
        scenes = list(SCENES)
    plan = Plan(
        find_contestants(names), arguments.seeds, arguments.profile, scenes, arguments.frames,
        arguments.out, arguments.jobs, arguments.scenes_only,
    )  # fmt: skip
    drives = [kitti_sequence(arguments.root, name, arguments.detections) for name in GIVEN]
    found = validate(plan, drives, lambda what: print(what, file=sys.stderr, flush=True))
    title = f"{arguments.detections}, profile {arguments.profile}, {arguments.seeds} seeds"
    console = Console(width=220)
    for table in validation_tables(found, title):
        console.print(table)
    if arguments.by_turns:
        for table in by_turns(arguments.root, found.scenes):
            console.print(table)
    if found.reenacted is not None:
        verdict(found.reenacted)
    if arguments.keep_ranks:
        write_ranks(found.scenes)


if __name__ == "__main__":
    main()
