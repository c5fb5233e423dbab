"""A detector that looks at every Nth frame only: what predicted rows are worth.

    python -m benchmarks.skipped_frames --root KITTI [--detections rrc] [--ego oxts]

KITTI's ten given sequences, TrackEval's rules. all: rows and labels of all frames, of which every
Nth was looked at. looked at: of those frames alone. given only those: a run that knows nothing of
the other frames, scored on the same. empty: the other frames count as looked at and empty, which
is what a tracker has to assume that is not told.
"""

import argparse
import logging
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

from benchmarks.kitti_tables import Drives, cells, drives, head, line
from mot_sim.datasets.recorded import DetectionLog, RecordedSequence
from mot_sim.evaluation.runs import track_sequence
from mot_sim.metrics import evaluate
from tracker import FRAMEWORKS, Camera, Delayed, Tracker, Tracks

COLUMNS = ("MOTA", "HOTA", "DetA", "AssA", "CLR_FP", "CLR_FN", "IDSW")
INTERVALS = (1, 2, 3, 5)
Build = Callable[[Camera], Tracker | Delayed]


def with_empty_frames(drive: RecordedSequence, every: int) -> RecordedSequence:
    """The drive with the boxes of every so many-th frame, the others as if nothing was found."""
    frames = drive.log.frames
    kept = frames % every == 0
    return replace(drive, log=DetectionLog(frames[kept], drive.log.detections.select(kept)))


def at_frames(tracks: Tracks, every: int) -> Tracks:
    """The rows of every so many-th frame."""
    return tracks.select(tracks.frames % every == 0)


def rows(name: str, build: Build, sequences: Drives, every: int) -> None:
    """The four rows of one interval."""
    said = ("all", "looked at", "given only those", "empty")
    parts: dict[str, dict[str, tuple[Tracks, Tracks, int]]] = {each: {} for each in said}
    for drive in sequences:
        count, truth = drive.frame_count, drive.truth
        skipped = drive.looked_at_every(every)
        few = drive.subset(range(0, count, every))
        empty = with_empty_frames(drive, every)
        runs = [track_sequence(build(drive.camera), each)[0] for each in (skipped, few, empty)]
        some = at_frames(truth, every)
        parts["all"][drive.name] = truth, runs[0], count
        parts["looked at"][drive.name] = some, at_frames(runs[0], every), count
        parts["given only those"][drive.name] = some, runs[1], count
        parts["empty"][drive.name] = truth, runs[2], count
    for each, scored in parts.items():
        line(f"{name}, N = {every}, {each}", cells(evaluate(scored).combined, COLUMNS))


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("--root", type=Path, required=True, help="the KITTI tree")
    parser.add_argument("--detections", default="rrc")
    parser.add_argument("--ego", default="oxts")
    known = ("default", "window", "network_flow", "paper")
    parser.add_argument("--trackers", nargs="+", choices=known, default=known[:2])
    arguments = parser.parse_args()
    logging.basicConfig(level=logging.ERROR)
    sequences = drives(arguments.root, arguments.detections, arguments.ego)
    head(f"{arguments.detections} boxes in every Nth frame, ego {arguments.ego}", COLUMNS)
    builds: dict[str, Build] = {"default": Tracker.default, "paper": Tracker.paper}
    for name in ("window", "network_flow"):
        builds[name] = lambda camera, name=name: FRAMEWORKS[name](Tracker.default(camera))
    for name in arguments.trackers:
        for every in INTERVALS:
            rows(name, builds[name], sequences, every)


if __name__ == "__main__":
    main()
