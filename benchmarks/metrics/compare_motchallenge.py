"""Compares MOTChallenge's rules with TrackEval 1.3.0's MotChallenge2DBox, on made cases.

    python -m benchmarks.metrics.compare_motchallenge [--bless]

TrackEval runs in an environment of its own, see `compare_trackeval`. Exit status 1 when any score
differs by more than 1e-9. --bless rewrites the tests' golden file.
"""

import argparse
import json
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy import ndarray as Array

from benchmarks.metrics.compare_trackeval import TOLERANCE, environment
from mot_sim.metrics.motchallenge import motchallenge_scores
from tracker.types import Tracks

GOLDEN_FILE = Path(__file__).parents[2] / "tests" / "golden" / "metrics_motchallenge.json"
CASES, FRAMES = 12, 20
KEPT = (
    "HOTA", "DetA", "AssA", "LocA", "MOTA", "MOTP", "IDSW", "CLR_TP", "CLR_FP", "CLR_FN", "Frag",
    "MT", "ML", "IDF1", "IDTP",
)  # fmt: skip
DRIVER = """
import json, sys
import numpy as np
import trackeval
folder, out = sys.argv[1:]
config = {"GT_FOLDER": folder + "/gt", "TRACKERS_FOLDER": folder + "/trackers",
          "BENCHMARK": "MOT17", "SPLIT_TO_EVAL": "train", "PRINT_CONFIG": False,
          "SKIP_SPLIT_FOL": True, "SEQMAP_FILE": folder + "/seqmap.txt"}
data = trackeval.datasets.MotChallenge2DBox(config)
quiet = {"PRINT_CONFIG": False}
metrics = [trackeval.metrics.HOTA(quiet), trackeval.metrics.CLEAR(quiet),
           trackeval.metrics.Identity(quiet)]
found = {}
for name in data.seq_list:
    raw = data.get_raw_seq_data("mine", name)
    rows = data.get_preprocessed_seq_data(raw, "pedestrian")
    scores = {}
    for metric in metrics:
        for key, value in metric.eval_sequence(rows).items():
            scores[key] = float(np.mean(value))
    found[name] = scores
json.dump(found, open(out, "w"))
"""


@dataclass(frozen=True, eq=False)
class Case:
    """Labels with classes and marks, and output, frames from 0."""

    truth: Tracks
    classes: Array
    counted: Array
    output: Tracks


def made_case(seed: int) -> Case:
    """Walkers, distractors and other classes that overlap, and a tracker that errs."""
    rng = np.random.default_rng(seed)
    rows, answers = [], []
    for number in range(int(rng.integers(4, 10))):
        kind = int(rng.choice([1, 1, 1, 1, 2, 3, 7, 8, 12]))
        place, speed = rng.uniform(0, 60, 2), rng.normal(0, 4, 2)
        size = rng.uniform([20, 40], [40, 80])
        for frame in range(FRAMES):
            if rng.random() < 0.1:
                continue
            box = place + speed * frame
            marked = float(kind == 1 and rng.random() < 0.9)
            rows.append((frame, number, *box, *(box + size), kind, marked))
            if rng.random() < 0.85:
                shift = rng.normal(0, 5, 4)
                identity = number if rng.random() < 0.95 else number + 50
                answers.append((frame, identity, *(np.r_[box, box + size] + shift)))
    for frame in range(FRAMES):
        if rng.random() < 0.4:
            corner = rng.uniform(0, 200, 2)
            answers.append((frame, 100 + frame, *corner, *(corner + 30)))
    labels, found = np.array(rows), np.array(answers)
    return Case(tracks(labels), labels[:, 6].astype(np.int64), labels[:, 7] > 0.0, tracks(found))


def tracks(table: Array) -> Tracks:
    """Frames, ids and boxes."""
    return Tracks(table[:, 0].astype(np.int64), table[:, 1].astype(np.int64), table[:, 2:6])


def write(folder: Path, cases: dict[str, Case]) -> None:
    """The folders that MotChallenge2DBox reads."""
    for name, case in cases.items():
        home = folder / "gt" / name
        (home / "gt").mkdir(parents=True)
        (home / "seqinfo.ini").write_text(f"[Sequence]\nname={name}\nseqLength={FRAMES}\n")
        marks = zip(case.counted.astype(int).tolist(), case.classes.tolist(), strict=True)
        ends = [f"{mark},{kind},1" for mark, kind in marks]
        (home / "gt" / "gt.txt").write_text(text(case.truth, ends))
        results = folder / "trackers" / "mine" / "data" / f"{name}.txt"
        results.parent.mkdir(parents=True, exist_ok=True)
        results.write_text(text(case.output, ["1,-1,-1,-1"] * len(case.output)))
    (folder / "seqmap.txt").write_text("\n".join(["name", *cases]) + "\n")


def text(rows: Tracks, ends: list[str]) -> str:
    """Rows as MOTChallenge writes them; numbers to the last digit."""
    sides = np.hstack([rows.boxes[:, :2], rows.boxes[:, 2:] - rows.boxes[:, :2]]).tolist()
    return "".join(
        f"{frame + 1},{number + 1},{','.join(map(repr, box))},{end}\n"
        for frame, number, box, end in zip(
            rows.frames.tolist(), rows.ids.tolist(), sides, ends, strict=True
        )
    )


def main() -> int:
    """The exit status: 0 when all scores agree."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--env", type=Path, default=Path.home() / ".cache/mot-sim/trackeval-1.3.0")
    parser.add_argument("--bless", action="store_true", help="rewrite the tests' golden file")
    arguments = parser.parse_args()
    cases = {f"case-{seed:02d}": made_case(seed) for seed in range(CASES)}
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        write(folder, cases)
        (folder / "driver.py").write_text(DRIVER)
        out = folder / "scores.json"
        python = environment(arguments.env)
        subprocess.run([python, folder / "driver.py", folder, out], check=True)
        theirs = json.loads(out.read_text())
    worst = 0.0
    for name, case in cases.items():
        ours = motchallenge_scores(case.truth, case.classes, case.counted, case.output, FRAMES)
        for score in KEPT:
            worst = max(worst, abs(ours[score] - theirs[name][score]))
    print(f"{len(cases)} cases, {len(KEPT)} scores: largest difference {worst:.2e}")
    if arguments.bless:
        rows = {name: {score: round(theirs[name][score], 12) for score in KEPT} for name in cases}
        about = "TrackEval 1.3.0; rewritten by benchmarks.metrics.compare_motchallenge --bless"
        GOLDEN_FILE.write_text(json.dumps({"about": about, "rows": rows}, indent=1) + "\n")
    return int(not worst <= TOLERANCE)


if __name__ == "__main__":
    sys.exit(main())
