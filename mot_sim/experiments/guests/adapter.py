"""Runs a tracker of the package `trackers` on a folder of detections; a program of its own.

    python -I adapter.py NAME DETECTIONS RESULTS [parameter=value ...]
    python -I adapter.py NAME live [parameter=value ...]     # a JSON line a frame, in and out

Needs only the guest's environment: nothing of this project is imported, and this file must stay
so. Images are never given, so no guest compensates for the camera's motion.
"""

import inspect
import json
import sys
import warnings
from collections import defaultdict
from collections.abc import Callable, Iterator
from importlib import import_module
from pathlib import Path
from time import process_time
from typing import Any, TextIO

import numpy as np

CLASSES = {
    "sort": "SORTTracker",
    "bytetrack": "ByteTrackTracker",
    "oc-sort": "OCSORTTracker",
    "c-biou": "CBIoUTracker",
}
Row = tuple[int, int, float, float, float, float, float]  # frame id x1 y1 x2 y2 score


def maker(name: str, settings: list[str]) -> Callable[[float], Any]:
    """What makes the tracker for a frame rate; its parameters are given as `name=value`."""
    kind = getattr(import_module("trackers"), CLASSES[name])
    chosen = dict(setting.split("=", 1) for setting in settings)
    known = inspect.signature(kind).parameters
    unknown = sorted(set(chosen) - set(known))
    if unknown:
        raise SystemExit(f"{name} has no parameter {unknown[0]!r}; it has {', '.join(known)}")
    values = {name: json.loads(value) for name, value in chosen.items()}
    return lambda frame_rate: kind(**{"frame_rate": frame_rate} | values)


def detections_by_frame(path: Path) -> dict[int, Any]:
    """The boxes of every frame that has some, as `supervision` wants them."""
    rows = defaultdict(list)
    for line in path.read_text().splitlines():
        frame, *values = line.split(",")
        rows[int(frame)].append([float(value) for value in values])
    return {frame: detections_of(values) for frame, values in rows.items()}


def detections_of(rows: list[list[float]]) -> Any:
    """Rows x1 y1 x2 y2 score as `supervision` wants them."""
    sv = import_module("supervision")
    grid = np.array(rows, dtype=float)
    if len(grid) == 0:
        return sv.Detections.empty()
    kinds = np.zeros(len(grid), dtype=int)
    return sv.Detections(xyxy=grid[:, :4], confidence=grid[:, 4], class_id=kinds)


def track_rows(tracker: Any, frames: list[int], given: dict[int, Any]) -> tuple[list[Row], float]:
    """The rows of one sequence, and the CPU seconds of the tracker's calls alone."""
    nothing = detections_of([])
    rows: list[Row] = []
    seconds = 0.0
    for frame in frames:
        detections = given.get(frame, nothing)
        start = process_time()
        tracked = tracker.update(detections)
        seconds += process_time() - start
        rows.extend(named(frame, tracked))
    return rows, seconds


def named(frame: int, tracked: Any) -> Iterator[Row]:
    """The rows that a tracker put a name to."""
    if len(tracked) == 0:
        return
    columns = (tracked.tracker_id.tolist(), tracked.xyxy.tolist(), tracked.confidence.tolist())
    for number, box, score in zip(*columns, strict=True):
        if number >= 0:
            yield (frame, int(number), *box, score)


def live(tracker: Any, lines: TextIO, answers: TextIO) -> None:
    """Answer every line of rows with rows, one frame after the other, until there is no more."""
    for frame, line in enumerate(lines):
        tracked = tracker.update(detections_of(json.loads(line)))
        rows = [row[1:] for row in named(frame, tracked)]
        answers.write(json.dumps(rows) + "\n")
        answers.flush()


def run_adapter(name: str, detections: str, *more: str) -> None:
    """Track every sequence of the folder; results, then the seconds of each. Or track live."""
    warnings.simplefilter("ignore")  # of the guests' own dependencies
    if detections == "live":
        frame_rate = float(sys.stdin.readline())
        live(maker(name, list(more))(frame_rate), sys.stdin, sys.stdout)
        return
    results, *settings = more
    make = maker(name, settings)
    sequences = json.loads((Path(detections) / "sequences.json").read_text())
    seconds = {}
    for sequence, described in sequences.items():
        given = detections_by_frame(Path(detections) / f"{sequence}.txt")
        tracker = make(described["frame_rate"])
        rows, seconds[sequence] = track_rows(tracker, described["frames"], given)
        text = "".join(" ".join(map(str, row)) + "\n" for row in rows)
        (Path(results) / f"{sequence}.txt").write_text(text)
    (Path(results) / "seconds.json").write_text(json.dumps(seconds))


if __name__ == "__main__":
    run_adapter(*sys.argv[1:])
