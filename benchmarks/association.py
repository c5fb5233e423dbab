"""One tracker's costs in every framework: two frames, a window, the whole drive at once.

    python -m benchmarks.association --root KITTI [--detections rrc] [--table frameworks lags costs]

frameworks: on KITTI's ten given sequences. lags: of the window. costs: every number of the flow
halved and doubled, and what choosing among these on three folds gives on the fourth.
"""

import argparse
import logging
from collections.abc import Callable
from dataclasses import fields, replace
from pathlib import Path

from benchmarks.kitti_tables import TRACKEVAL, Drives, cells, drives, head, line, scores
from mot_sim.evaluation.runs import track_sequence
from tracker import FRAMEWORKS, Camera, Delayed, Tracker, Tracks
from tracker.multi_frame import FlowCosts, NetworkFlow, Window

# Sequences by cars: 0020 holds nearly a third of them; 0017 has none.
FOLDS = (("0020",), ("0009", "0000"), ("0011", "0003", "0004"), ("0007", "0005", "0002", "0017"))
LAGS = (3, 5, 10, 20, 30)
Results = dict[str, Tracks]


def tracked(build: Callable[[Camera], Tracker | Delayed], sequences: Drives) -> tuple[Results, str]:
    """Every sequence's tracks, and frames per second of wall time."""
    results, frames, seconds = {}, 0, 0.0
    for sequence in sequences:
        results[sequence.name], counts = track_sequence(build(sequence.camera), sequence)
        frames, seconds = frames + counts.frames, seconds + counts.seconds
    return results, f"{frames / seconds:.0f}"


def frameworks_table(detections: str, sequences: Drives) -> None:
    """A row a framework."""
    head(f"Tracker.default, {detections}, OXTS", TRACKEVAL, ("frames/s",))
    for name, framework in FRAMEWORKS.items():
        results, speed = tracked(lambda c, f=framework: f(Tracker.default(c)), sequences)
        line(name, [*cells(scores(results, sequences), TRACKEVAL), speed])


def lags_table(detections: str, sequences: Drives) -> None:
    """A row a lag of the window."""
    head(f"window by its lag in frames, {detections}, OXTS", TRACKEVAL, ("frames/s",))
    for lag in LAGS:
        results, speed = tracked(lambda c, n=lag: Window(Tracker.default(c), lag=n), sequences)
        line(str(lag), [*cells(scores(results, sequences), TRACKEVAL), speed])


def neighbours() -> dict[str, FlowCosts]:
    """The default, and every number of it halved and doubled."""
    default = FlowCosts()
    found = {"default": default}
    for field in fields(FlowCosts):
        for factor in (0.5, 2.0):
            value = factor * getattr(default, field.name)
            found[f"{field.name} {value:g}"] = replace(default, **{field.name: value})
    return found


def costs_table(detections: str, sequences: Drives) -> None:
    """A row a neighbour, then leaving folds out."""
    head(f"network_flow, one number changed, {detections}, OXTS", TRACKEVAL)
    every: dict[str, Results] = {}
    for name, costs in neighbours().items():
        every[name], _ = tracked(lambda c, f=costs: NetworkFlow(Tracker.default(c), f), sequences)
        line(name, cells(scores(every[name], sequences), TRACKEVAL))
    head("chosen by HOTA on the other folds", ("HOTA default", "HOTA chosen", "MOTA chosen"))
    held_out: Results = {}
    for fold in FOLDS:
        inside = [drive for drive in sequences if drive.name in fold]
        others = [drive for drive in sequences if drive.name not in fold]
        best = max(every, key=lambda name: scores(every[name], others)["HOTA"])
        held_out |= {drive.name: every[best][drive.name] for drive in inside}
        default, chosen = scores(every["default"], inside), scores(every[best], inside)
        shares = (default["HOTA"], chosen["HOTA"], chosen["MOTA"])
        line(f"{' '.join(fold)}: {best}", [f"{100 * share:.2f}" for share in shares])
    default, chosen = scores(every["default"], sequences), scores(held_out, sequences)
    shares = (default["HOTA"], chosen["HOTA"], chosen["MOTA"])
    line("all, each by the others", [f"{100 * share:.2f}" for share in shares])


TABLES = {"frameworks": frameworks_table, "lags": lags_table, "costs": costs_table}


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("--root", type=Path, required=True, help="the KITTI tree")
    parser.add_argument("--detections", nargs="+", default=["rrc"])
    parser.add_argument("--table", nargs="+", choices=TABLES, default=list(TABLES))
    arguments = parser.parse_args()
    logging.basicConfig(level=logging.ERROR)
    for detections in arguments.detections:
        sequences = drives(arguments.root, detections, "oxts")
        for table in arguments.table:
            TABLES[table](detections, sequences)


if __name__ == "__main__":
    main()
