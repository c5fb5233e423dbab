"""Runs a tracker of an installed package on a folder of detections; a program of its own.

    python -I run.py PACKAGE:CLASS DETECTIONS RESULTS [parameter=value ...]
    python -I run.py PACKAGE:CLASS live [parameter=value ...]     # a JSON line a frame, in and out

PACKAGE_package.py beside this file knows the package. Needs only the guest's environment: nothing
of this project is imported but that file, by its path, and both must stay so. Images are never
given, so no guest compensates for the camera's motion.
"""

import inspect
import json
import runpy
import sys
import warnings
from collections import defaultdict
from collections.abc import Callable, Iterable
from importlib import import_module
from pathlib import Path
from time import process_time
from typing import Any, Protocol, TextIO

Box = list[float]  # x1 y1 x2 y2 score
Row = tuple[int, float, float, float, float, float]  # id x1 y1 x2 y2 score


class PackageAdapter(Protocol):
    """What a file PACKAGE_package.py offers as ADAPTER: one tracker of the package, for a drive."""

    def __init__(self, kind: Any, frame_rate: float, settings: dict[str, Any]) -> None:
        """kind: the tracker's class. settings: by the names of its parameters."""

    def detections(self, boxes: list[Box]) -> Any:
        """The boxes of a frame as the package wants them."""

    def update(self, detections: Any) -> Any:
        """The tracker's step, which alone is timed; what the package answers."""

    def rows(self, answer: Any) -> Iterable[Row]:
        """The rows that the package's answer holds."""


def maker(tracker: str, settings: list[str]) -> Callable[[float], PackageAdapter]:
    """What makes the tracker for a frame rate; its parameters are given as `name=value`."""
    package, _, name = tracker.partition(":")
    adapter = runpy.run_path(str(Path(__file__).with_name(f"{package}_package.py")))["ADAPTER"]
    try:
        kind = getattr(import_module(package), name)
    except ImportError as error:
        raise SystemExit(
            f"{error}; the environment of {sys.executable} is damaged: without its folder, "
            "`mot-sim compare --setup` makes it anew"
        ) from None
    chosen = dict(setting.split("=", 1) for setting in settings)
    known = inspect.signature(kind).parameters
    unknown = sorted(set(chosen) - set(known))
    if unknown:
        raise SystemExit(f"{name} has no parameter {unknown[0]!r}; it has {', '.join(known)}")
    values = {name: json.loads(value) for name, value in chosen.items()}
    return lambda frame_rate: adapter(kind, frame_rate, values)


def boxes_by_frame(path: Path) -> dict[int, list[Box]]:
    """The boxes of every frame that has some."""
    boxes = defaultdict(list)
    for line in path.read_text().splitlines():
        frame, *values = line.split(",")
        boxes[int(frame)].append([float(value) for value in values])
    return boxes


def track_frames(
    adapter: PackageAdapter, frames: list[int], boxes: dict[int, list[Box]]
) -> tuple[list[str], float]:
    """The lines of one drive, and the CPU seconds of the tracker's calls alone."""
    lines: list[str] = []
    seconds = 0.0
    for frame in frames:
        detections = adapter.detections(boxes.get(frame, []))
        start = process_time()
        answer = adapter.update(detections)
        seconds += process_time() - start
        lines.extend(" ".join(map(str, (frame, *row))) for row in adapter.rows(answer))
    return lines, seconds


def live(adapter: PackageAdapter, lines: TextIO, answers: TextIO) -> None:
    """Answer every line of boxes with rows, one frame after the other, until there is no more."""
    for line in lines:
        answer = adapter.update(adapter.detections(json.loads(line)))
        answers.write(json.dumps(list(adapter.rows(answer))) + "\n")
        answers.flush()


def run_adapter(tracker: str, detections: str, *more: str) -> None:
    """Track every sequence of the folder; results, then the seconds of each. Or track live."""
    warnings.simplefilter("ignore")  # of the guests' own dependencies
    if detections == "live":
        frame_rate = float(sys.stdin.readline())
        live(maker(tracker, list(more))(frame_rate), sys.stdin, sys.stdout)
        return
    results, *settings = more
    make = maker(tracker, settings)
    sequences = json.loads((Path(detections) / "sequences.json").read_text())
    seconds = {}
    for sequence, described in sequences.items():
        boxes = boxes_by_frame(Path(detections) / f"{sequence}.txt")
        adapter = make(described["frame_rate"])
        lines, seconds[sequence] = track_frames(adapter, described["frames"], boxes)
        (Path(results) / f"{sequence}.txt").write_text("".join(f"{line}\n" for line in lines))
    (Path(results) / "seconds.json").write_text(json.dumps(seconds))


if __name__ == "__main__":
    run_adapter(*sys.argv[1:])
