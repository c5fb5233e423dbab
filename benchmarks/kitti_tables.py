"""Tracking quality on KITTI's ten given sequences, beside what others reach on the same boxes.

    python -m benchmarks.kitti_tables --root KITTI [--table default paper ablation reference]

Rows marked * are quoted, not measured here: other trackers on the same boxes (TrackEval 1.3.0,
each at its best threshold), and the paper's Table III (2018 devkit, all 21 sequences).
"""

import argparse
import logging
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

from mot_sim.datasets import kitti_sequence, read_results
from mot_sim.datasets.recorded import DetectionLog, RecordedSequence
from mot_sim.evaluation.runs import track_sequence
from mot_sim.metrics import Scores, evaluate
from tracker import Camera, Detections, Tracker, Tracks
from tracker.association import Greedy
from tracker.box_filter import BoxFilter
from tracker.car_filter import CarFilter
from tracker.costs import ImageOverlap, Reprojection, Volume
from tracker.dynamics import ConstantPosition
from tracker.existence import ExistenceFilter
from tracker.lifecycle import Lifecycle
from tracker.suppression import Suppression

GIVEN = ("0000", "0002", "0003", "0004", "0005", "0007", "0009", "0011", "0017", "0020")
Build = Callable[[Camera], Tracker]
Drives = list[RecordedSequence]

TRACKEVAL = ("MOTA", "HOTA", "DetA", "AssA", "IDF1", "CLR_FP", "CLR_FN", "IDSW", "Frag")
DEVKIT = (
    "MOTA", "MOTP", "CLR_Re", "CLR_Pr", "MTR", "PTR", "MLR", "CLR_TP", "CLR_FP", "IDSW", "Frag",
)  # fmt: skip
COUNTS = {"CLR_TP", "CLR_FP", "CLR_FN", "IDSW", "Frag"}

PEERS = {
    "rrc": {
        "* SORT": "88.11 74.93 - 73.76 87.50 140 1512 213 179",
        "* OC-SORT": "88.55 79.65 - 78.40 89.04 159 1427 211 164",
        "* ByteTrack": "88.86 80.24 - 79.58 89.79 141 1470 137 161",
        "* BoT-SORT, no camera compensation": "88.67 80.84 - 80.94 90.95 73 1558 147 157",
        "* C-BIoU": "89.33 81.01 - 80.97 90.88 81 1481 113 151",
        "* perfect association of the raw boxes": "91.05 84.41 - 86.84 95.39 227 1177 0 173",
    },
    "pointrcnn": {
        "* ByteTrack": "75.36 70.95 - - - - - 55 172",
        "* C-BIoU": "77.25 71.30 - - - - - 62 157",
        "* AB3DMOT (LiDAR 3D boxes)": "77.80 72.23 - - - - - 32 80",
    },
    "degraded": {
        "* ByteTrack": "75.28 58.25 - 55.75 77.25 81 3642 156 2235",
        "* SORT": "73.48 59.01 - 56.69 77.57 66 3768 327 2248",
    },
    "permatrack": {},
}
PAPER_TABLE_III = {
    "* paper, all 21: 3D-2D": "86.91 89.83 94.65 98.47 87.76 10.63 1.59 25309 392 1328 1507",
    "* paper, all 21: 3D-3D": "87.56 89.83 94.65 98.47 87.76 10.63 1.59 25309 392 1170 1333",
    "* paper, all 21: all cues": "91.40 89.83 94.65 98.47 87.76 10.63 1.59 25309 392 232 423",
}


def drives(root: Path, detections: str, ego: str, names: tuple[str, ...] = GIVEN) -> Drives:
    """The sequences with their detections and ego-motion."""
    return [kitti_sequence(root, name, detections=detections, ego=ego) for name in names]


def tracked(build: Build, sequences: Drives) -> tuple[dict[str, Tracks], float]:
    """Every sequence's tracks, and the share of pairs that the search areas spared."""
    results, pairs, compared = {}, 0, 0
    for sequence in sequences:
        tracker = build(sequence.camera)
        results[sequence.name], _ = track_sequence(tracker, sequence)
        pairs += tracker.state.statistics.pairs
        compared += tracker.state.statistics.compared
    return results, 1.0 - compared / max(pairs, 1)


def scores(results: dict[str, Tracks], sequences: Drives, rules: str = "trackeval") -> Scores:
    """The combined scores of the ten sequences."""
    truths = {
        drive.name: (drive.truth, results[drive.name], drive.frame_count) for drive in sequences
    }
    return evaluate(truths, rules=rules).combined


def line(name: str, values: list[str]) -> None:
    """A row of a Markdown table."""
    print(f"| {name} | {' | '.join(values)} |")


def head(title: str, columns: tuple[str, ...], extra: tuple[str, ...] = ()) -> None:
    """The title and the head of a Markdown table."""
    print(f"\n{title}\n")
    line("", [column.removeprefix("CLR_") for column in columns] + list(extra))
    print("|" + "---|" * (len(columns) + len(extra) + 1))


def cells(score: Scores, columns: tuple[str, ...]) -> list[str]:
    """Counts as they are, everything else in percent."""
    return [
        f"{score[name]:.0f}" if name in COUNTS else f"{100 * score[name]:.2f}" for name in columns
    ]


def default_table(root: Path) -> None:
    """Tracker.default with every detector and every source of ego-motion."""
    for detector, peers in PEERS.items():
        head(
            f"{detector} boxes, ten given sequences, TrackEval rules", TRACKEVAL, ("pairs skipped",)
        )
        for ego in ("oxts", "orbslam3", "none"):
            sequences = drives(root, detector, ego)
            for name, build in (("default", Tracker.default), ("paper", Tracker.paper)):
                results, skipped = tracked(build, sequences)
                share = f"{100 * skipped:.1f} %"
                line(f"{name}, ego {ego}", [*cells(scores(results, sequences), TRACKEVAL), share])
        for peer, values in peers.items():
            line(peer, [*values.split(), ""])


def paper_table(root: Path) -> None:
    """Tracker.paper's rows under both rule sets, beside the paper's."""
    cues = {
        "3D-2D": ((1.0, Reprojection()),),
        "3D-3D": ((1.0, Volume()),),
        "3D-3D + 3D-2D": ((0.6, Volume()), (0.4, Reprojection())),
    }
    sequences = drives(root, "rrc", "oxts")
    results = {
        name: tracked(lambda c, w=w: Tracker.paper(c, w), sequences) for name, w in cues.items()
    }
    head("Tracker.paper, RRC, OXTS, TrackEval rules", TRACKEVAL, ("pairs skipped",))
    for name, (tracks, skipped) in results.items():
        share = f"{100 * skipped:.1f} %"
        line(name, [*cells(scores(tracks, sequences), TRACKEVAL), share])
    head("Tracker.paper, RRC, OXTS, devkit2018 rules", DEVKIT)
    for name, (tracks, _) in results.items():
        line(name, cells(scores(tracks, sequences, "devkit2018"), DEVKIT))
    for name, values in PAPER_TABLE_III.items():
        line(name, values.split())


IMAGE = ImageOverlap(0.1)
# A prior worth more tries than there are: nothing is learned.
FIXED_RATES = ExistenceFilter(detection_prior=1e9, birth_prior=1e9)
ABLATION: dict[str, Callable[[Tracker], Tracker]] = {
    "default": lambda t: t,
    "costs .8 2D-2D + .2 3D-3D": lambda t: replace(t, costs=((0.8, IMAGE), (0.2, Volume()))),
    "costs .8 2D-2D + .2 3D-2D": lambda t: replace(t, costs=((0.8, IMAGE), (0.2, Reprojection()))),
    "costs .6 3D-3D + .4 3D-2D": lambda t: replace(
        t, costs=((0.6, Volume()), (0.4, Reprojection())), tie_break=1e-3
    ),
    "no buffer round the boxes": lambda t: replace(t, costs=((1.0, ImageOverlap()),)),
    "cars stand still": lambda t: replace(t, dynamics=ConstantPosition()),
    "depth by road contact alone": lambda t: replace(t, lift=replace(t.lift, use_box_height=False)),
    "one score stage": lambda t: replace(t, strong_score=0.0),
    "births from .5": lambda t: replace(t, lifecycle=Lifecycle(0.5, 3.0)),
    "memory 0.5 s": lambda t: replace(t, lifecycle=Lifecycle(0.8, 0.5)),
    "no memory": lambda t: replace(t, lifecycle=Lifecycle(0.8, 0.0)),
    "NMS at .5 for sure boxes too": lambda t: replace(t, suppress=Suppression(0.3, 0.5)),
    "NMS at .7 for all boxes": lambda t: replace(t, suppress=Suppression(0.3, 0.7)),
    "greedy": lambda t: replace(t, associate=Greedy(0.7)),
    "only what is seen is written": lambda t: replace(t, existence=None),
    "detection and birth rates fixed": lambda t: replace(t, existence=FIXED_RATES),
    "every newborn is written": lambda t: replace(t, existence=ExistenceFilter(birth_prior=1e9)),
    "boxes as they are": lambda t: replace(t, box_filter=None),
    "gain of the boxes fixed": lambda t: replace(t, box_filter=BoxFilter(prior=1e9)),
    "cars live 1.5 s": lambda t: replace(t, existence=ExistenceFilter(mean_lifetime=1.5)),
    "cars live 6 s": lambda t: replace(t, existence=ExistenceFilter(mean_lifetime=6.0)),
    "without car filter": lambda t: replace(t, car_filter=None),
    "boxes moved as windows": lambda t: replace(t, car_filter=CarFilter(carries_boxes=False)),
    "rows in gaps by existence alone": lambda t: replace(t, gap_rows=None),
    "same, predicted boxes good for 1 s": lambda t: replace(
        t, gap_rows=None, existence=ExistenceFilter(prediction_lifetime=1.0)
    ),
    "same, predicted boxes good for 4 s": lambda t: replace(
        t, gap_rows=None, existence=ExistenceFilter(prediction_lifetime=4.0)
    ),
}  # fmt: skip


def ablation_table(root: Path) -> None:
    """What each choice of Tracker.default is worth."""
    for detector in ("rrc", "degraded"):
        sequences = drives(root, detector, "oxts")
        head(f"Tracker.default, one choice changed: {detector}, OXTS, TrackEval rules", TRACKEVAL)
        for name, change in ABLATION.items():
            results, _ = tracked(lambda c, change=change: change(Tracker.default(c)), sequences)
            line(name, cells(scores(results, sequences), TRACKEVAL))


def reference_table(root: Path, published: Path) -> None:
    """Sequence 0005: our trackers on the authors' boxes against their published identities."""
    sequence = kitti_sequence(root, "0005")
    theirs = read_results(published / "train" / "0005.txt")
    raw = Detections.of(theirs.boxes, theirs.scores)
    given = replace(sequence, log=DetectionLog.of(theirs.frames, raw))
    for rules in ("trackeval", "devkit2018"):
        columns = ("MOTA", "IDSW", "Frag", "CLR_FP", "CLR_FN")
        head(f"0005, the authors' {len(theirs)} boxes, {rules} rules", columns)
        line("published identities", cells(scores({"0005": theirs}, [given], rules), columns))
        for name, build in (("paper", Tracker.paper), ("default", Tracker.default)):
            results, _ = tracked(build, [given])
            line(f"ours, {name}", cells(scores(results, [given], rules), columns))


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("--root", type=Path, required=True, help="the KITTI tree")
    parser.add_argument(
        "--published", type=Path, help="the authors' result files (for `reference`)"
    )
    tables = ("default", "paper", "ablation", "reference")
    parser.add_argument("--table", nargs="+", choices=tables, default=tables)
    arguments = parser.parse_args()
    logging.basicConfig(level=logging.ERROR)
    for table in arguments.table:
        if table == "reference":
            if arguments.published is None:
                print("\nThe reference table is left out: give --published.")
            else:
                reference_table(arguments.root, arguments.published)
        else:
            {"default": default_table, "paper": paper_table, "ablation": ablation_table}[table](
                arguments.root
            )


if __name__ == "__main__":
    main()
