"""Compares our scores with TrackEval 1.3.0, through files, and times both side by side.

Run from the root of the repository: python -m benchmarks.metrics.compare_trackeval [--bless]
TrackEval gets an environment of its own (its dependencies would overwrite ours). Exit status 1
when any score differs by more than 1e-9. "memory" times what lies between parsed rows and all
scores, overlaps included, on both sides; "files" times the same from text files. Both are the
least of --repeats runs in one process; making environment, folders and processes is not timed.
"""

import argparse
import json
import os
import subprocess
import sys
import tempfile
import venv
from collections.abc import Callable
from pathlib import Path
from time import perf_counter

import numpy as np

from benchmarks.metrics.folders import World, kitti_world, synthetic_world
from benchmarks.metrics.golden import GOLDEN_FILE, bless
from mot_sim.metrics import Evaluation, Scores, evaluate

PACKAGE = "trackeval==1.3.0"
TOLERANCE = 1e-9


def main() -> int:
    """The exit status: 0 when all scores agree."""
    arguments = parse()
    python = environment(arguments.env)
    worst: dict[str, tuple[float, str]] = {}
    references = {}
    with tempfile.TemporaryDirectory() as folder:
        for world in worlds(Path(folder), arguments):
            theirs = references[world.name] = drive(python, world, arguments.repeats)
            for tracker in world.trackers:
                ours, seconds = score(world, tracker, arguments.repeats)
                note_differences(f"{world.name} {tracker}", ours, theirs[tracker], worst)
                report_speed(f"{world.name} {tracker}", seconds, theirs[tracker]["seconds"])
    for family, (difference, where) in sorted(worst.items()):
        print(f"{family:9} largest absolute difference {difference:.2e}  ({where})")
    if arguments.bless:
        print(f"{bless(references)} bytes written to {GOLDEN_FILE.name}")
    return int(any(not difference <= TOLERANCE for difference, _ in worst.values()))


def parse() -> argparse.Namespace:
    """The command line."""
    cache = Path(os.environ.get("XDG_CACHE_HOME", Path.home() / ".cache"))
    root = os.environ.get("MOT_SIM_KITTI_ROOT")
    parser = argparse.ArgumentParser(description=str(__doc__).splitlines()[0])
    parser.add_argument("--root", type=Path, default=Path(root) if root else None)
    parser.add_argument("--golden", type=Path, help="folder of TRACKER/SSSS.txt result files")
    parser.add_argument("--env", type=Path, default=cache / "mot-sim" / "trackeval-1.3.0")
    parser.add_argument("--repeats", type=int, default=5, help="timed runs; the least counts")
    parser.add_argument("--bless", action="store_true", help="rewrite the tests' golden file")
    return parser.parse_args()


def worlds(folder: Path, arguments: argparse.Namespace) -> list[World]:
    """What is compared: the synthetic cases, and KITTI where it is given."""
    found = [synthetic_world(folder / "synthetic")]
    if arguments.root and arguments.golden:
        return [*found, kitti_world(folder / "kitti", arguments.root, arguments.golden)]
    print("KITTI is left out: give --golden, and --root or MOT_SIM_KITTI_ROOT")
    return found


def environment(folder: Path) -> Path:
    """The Python of an environment with TrackEval, made there if need be."""
    python = folder / ("Scripts/python.exe" if os.name == "nt" else "bin/python")
    if not python.exists():
        venv.create(folder, with_pip=True)
    check = [python, "-c", "import trackeval"]
    if subprocess.run(check, check=False, capture_output=True).returncode:
        subprocess.run([python, "-m", "pip", "install", "--quiet", PACKAGE], check=True)
    return python


def drive(python: Path, world: World, repeats: int) -> dict[str, dict]:
    """TrackEval's scores and seconds for every tracker of a world."""
    script, out = Path(__file__).with_name("drive_trackeval.py"), world.folder / "scores.json"
    folders = [world.folder / "gt", world.folder / "trackers"]
    subprocess.run([python, script, *folders, str(repeats), out], check=True)
    return json.loads(out.read_text())


def score(world: World, tracker: str, repeats: int) -> tuple[Evaluation, dict[str, float]]:
    """Our scores of one tracker, and the least seconds from memory and from files."""
    rows = world.rows(tracker)
    seconds = {"memory": least_seconds(lambda: evaluate(rows), repeats)}
    if world.name != "synthetic":  # those rows come from no file
        seconds["files"] = least_seconds(lambda: evaluate(world.rows(tracker)), repeats)
    return evaluate(rows), seconds


def least_seconds(work: Callable[[], object], repeats: int) -> float:
    """The least of some runs' seconds; a busy machine only adds."""
    seconds = []
    for _ in range(repeats):
        start = perf_counter()
        work()
        seconds.append(perf_counter() - start)
    return min(seconds)


def note_differences(
    label: str, ours: Evaluation, theirs: dict, worst: dict[str, tuple[float, str]]
) -> None:
    """Keep the largest difference of every family, and where it is."""
    pairs = [(name, ours.sequences[name], theirs["sequences"][name]) for name in ours.sequences]
    for sequence, scores, reference in [*pairs, ("combined", ours.combined, theirs["combined"])]:
        for family, values in reference.items():
            for name, value in values.items():
                difference = difference_of(scores, name, value)
                if not difference <= worst.get(family, (-1.0, ""))[0]:
                    worst[family] = difference, f"{label} {sequence} {name}"


def difference_of(scores: Scores, name: str, value: float | list[float]) -> float:
    """The largest absolute difference of one score, over all alphas where it has them."""
    if isinstance(value, list):
        assert scores.hota is not None
        return float(np.abs(np.subtract(getattr(scores.hota, name), value)).max())
    return abs(scores[name] - value)


def report_speed(label: str, ours: dict[str, float], theirs: dict[str, float]) -> None:
    """One line for each start: memory and files."""
    for start, seconds in ours.items():
        print(
            f"{label:24} from {start:6}: ours {1e3 * seconds:7.1f} ms, TrackEval "
            f"{1e3 * theirs[start]:7.1f} ms, {theirs[start] / seconds:5.1f} times faster"
        )


if __name__ == "__main__":
    sys.exit(main())
