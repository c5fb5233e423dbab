"""At which score the guests and the baselines are best: where `GUESTS`' defaults come from.

    mot-sim compare --setup all
    python -m benchmarks.peers --root KITTI [--detections rrc] [--trackers sort ...] [--scores ...]

The ten given sequences, TrackEval's rules. Each row is a tracker that is shown boxes from that
score on (a probability); its best MOTA is marked with *. `--settings` varies one parameter of
each guest at a time instead: memory, births, and what else its package has. The guests' commands
in `mot_sim/foreign/register.py` follow.
"""

import argparse
import logging
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from benchmarks.kitti_tables import GIVEN
from mot_sim.datasets import KittiSequence, kitti_sequence
from mot_sim.experiments.guests import (
    GUESTS,
    Entry,
    ExternalSequenceTracker,
    ExternalTracker,
    Failure,
    run_comparison,
)
from tracker.types import Tracks

SCORES = (0.2, 0.3, 0.5, 0.7)
BIRTHS = ("minimum_consecutive_frames=1", "minimum_consecutive_frames=3")
MEMORY = ("lost_track_buffer=30", "lost_track_buffer=90")
SETTINGS = {
    "sort": BIRTHS,
    "sort-3": MEMORY,
    "bytetrack": MEMORY,
    "oc-sort": BIRTHS,
    "oc-sort-3": MEMORY,
    "c-biou": MEMORY,
    "bot-sort": (*MEMORY, "minimum_consecutive_frames=1", "track_activation_threshold=0.5"),
    "norfair": (
        *(f"distance_threshold={value}" for value in (0.5, 0.7, 0.8, 0.9)),
        *(f"hit_counter_max={value}" for value in (5, 15, 30)),
        *(f"initialization_delay={value}" for value in (0, 1, 2)),
        *(f"pointwise_hit_counter_max={value}" for value in (1, 2, 4)),
    ),
    "motpy": (
        *(f'active_tracks_kwargs={{"max_staleness": {value}}}' for value in (1, 2, 999)),
        *(f'tracker_kwargs={{"max_staleness": {value}}}' for value in (12, 30)),
        *(f'matching_fn_kwargs={{"min_iou": {value}}}' for value in (0.01, 0.1, 0.2)),
        'model_spec="constant_velocity_and_static_box_size_2d"',
        'model_spec="constant_acceleration_and_static_box_size_2d"',
    ),
}
RATES = ("MOTA", "HOTA", "AssA", "IDF1")
COUNTS = ("CLR_FP", "CLR_FN", "IDSW", "Frag")


def with_setting(guest: ExternalTracker, setting: str) -> ExternalTracker:
    """The guest with one parameter of its tracker changed."""
    name = setting.partition("=")[0]
    kept = tuple(word for word in guest.command if not word.startswith(f"{name}="))
    return replace(guest, command=(*kept, setting))


def print_table(rows: dict[str, Entry | Failure]) -> None:
    """One table, in Markdown; the best MOTA is marked."""
    scored = {label: row for label, row in rows.items() if isinstance(row, Entry)}
    best = max(scored, key=lambda label: float(scored[label].evaluation.combined["MOTA"]))
    for label, row in rows.items():
        if isinstance(row, Failure):
            print(f"| {label} | failed: {row.reason} |")
            continue
        scores = row.evaluation.combined
        cells = [f"{100 * float(scores[rate]):.2f}" for rate in RATES]
        cells += [f"{scores[count]:.0f}" for count in COUNTS]
        speed = "" if row.frames_per_second is None else f"{row.frames_per_second:,.0f}"
        print(f"| {label}{' *' if label == best else ''} | {' | '.join(cells)} | {speed} |")


def measure(
    guest: ExternalTracker, drives: Sequence[KittiSequence], truths: dict[str, Tracks]
) -> Entry | Failure:
    """One guest on the drives."""
    return run_comparison([ExternalSequenceTracker(guest)], drives, truths).entries[guest.name]


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("--root", type=Path, required=True, help="the KITTI tree")
    parser.add_argument("--detections", default="rrc")
    parser.add_argument("--trackers", nargs="+", choices=list(GUESTS), default=list(GUESTS))
    parser.add_argument("--scores", nargs="+", type=float, default=SCORES)
    parser.add_argument("--settings", action="store_true", help="vary these, not the score")
    arguments = parser.parse_args()
    logging.basicConfig(level=logging.ERROR)
    drives = [
        kitti_sequence(arguments.root, name, arguments.detections, ego="none") for name in GIVEN
    ]
    truths = {drive.name: drive.truth for drive in drives if drive.truth is not None}
    columns = ("MOTA", "HOTA", "AssA", "IDF1", "FP", "FN", "IDSW", "Frag", "frames / CPU s")
    print(f"| {arguments.detections} | {' | '.join(columns)} |")
    print("|" + "---|" * (len(columns) + 1))
    for name in arguments.trackers:
        guest = GUESTS[name]
        if arguments.settings:
            variants = {
                f"{name}, {setting}": with_setting(guest, setting) for setting in SETTINGS[name]
            }
        else:
            variants = {
                f"{name}, from {score:g}": replace(guest, min_score=score)
                for score in arguments.scores
            }
        print_table(
            {label: measure(variant, drives, truths) for label, variant in variants.items()}
        )


if __name__ == "__main__":
    main()
