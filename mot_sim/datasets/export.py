"""Exports for other people's evaluators: MOTChallenge files and TrackEval's folders for KITTI."""

from collections.abc import Iterator, Mapping
from pathlib import Path

import numpy as np
from jaxtyping import Float, Int, Shaped
from numpy import ndarray as Array

from mot_sim.datasets.kitti.labels import write_labels, write_results
from mot_sim.files.writing import write_lines
from tracker.errors import BadConfig, BadTracks
from tracker.types import (
    MOT_CLASSES,
    MOT_DISTRACTOR,
    Detections,
    Sequence,
    Tracks,
    spelled_as_kitti,
)

DEFAULT_FRAME_RATE = 10.0

# Frames, ids, boxes, confidences and classes: the columns of a MOTChallenge file.
MotRows = tuple[
    Int[Array, " n"], Int[Array, " n"], Float[Array, "n 4"], Float[Array, " n"], Int[Array, " n"]
]


def export_motchallenge(
    folder: Path, sequence: Sequence, truth: Tracks | None = None, results: Tracks | None = None
) -> None:
    """Write `<folder>/<name>/`: seqinfo.ini, det/det.txt, and gt/gt.txt, res/res.txt if given.

    Rows are `frame,id,left,top,width,height,conf,class,-1,-1`; frames and ids count from 1, so a
    KITTI id i becomes i + 1, and detections have id -1. Classes are MOT16's, see MOT_CLASSES; rows
    that do not say theirs are cars. Pixel coordinates stay as they are. In gt.txt conf is 1 for the
    classes that the results (without them the detections) hold and 0 for every other kind, which
    evaluators leave out; DontCare regions have no counterpart and are not written.
    """
    indices, times, parts = [], [], []
    for frame in sequence:
        indices.append(frame.index)
        times.append(frame.time)
        found = frame.found
        parts.append(
            Detections(found.boxes, found.scores, kinds=kinds_or_cars(found.kinds, len(found)))
        )
    length = indices[-1] + 1 if indices else 0
    tables = {"det": _detection_rows(np.array(indices, dtype=np.int64), parts)}
    classes = tables["det"][4]
    if results is not None:
        results.require_unique_ids(f"results of {sequence.name}")
        tables["res"] = _result_rows(results)
        classes = tables["res"][4]
    if truth is not None:
        tables["gt"] = _truth_rows(truth, set(classes.tolist()) or {MOT_CLASSES["Car"]})
    home = folder / sequence.name
    for kind, table in tables.items():
        _require_frames(table[0], length, f"{kind} of {sequence.name}")
        write_lines(home / kind / f"{kind}.txt", _lines(*table))
    width, height = sequence.camera.image_size
    rate = (indices[1] - indices[0]) / (times[1] - times[0]) if length > 1 else DEFAULT_FRAME_RATE
    write_lines(
        home / "seqinfo.ini",
        [
            "[Sequence]",
            f"name={sequence.name}",
            "imDir=img1",
            f"frameRate={rate:g}",
            f"seqLength={length}",
            f"imWidth={width}",
            f"imHeight={height}",
            "imExt=.png",
        ],
    )


def export_trackeval(
    folder: Path,
    tracker: str,
    lengths: Mapping[str, int],
    truths: Mapping[str, Tracks],
    results: Mapping[str, Tracks],
    Ts_road_label: Mapping[str, Float[Array, "4 4"]] | None = None,
) -> None:
    """Write what TrackEval's Kitti2DBox reads, for the sequences that `lengths` counts.

    GT_FOLDER is `<folder>/gt` (evaluate_tracking.seqmap.training and label_02/SSSS.txt),
    TRACKERS_FOLDER is `<folder>/trackers` (<tracker>/data/SSSS.txt). Cuboids, with the states
    beside, are written where Ts_road_label says how, for others who read these folders: TrackEval
    reads boxes. Raises BadConfig for a sequence without truth or results, BadTracks
    for frames outside a sequence.
    """
    for what, given in {"truth": truths, "results": results}.items():
        missing = [name for name in lengths if name not in given]
        if missing:
            raise BadConfig(
                f"no {what} for sequence {missing[0]}: TrackEval needs it; leave it out"
            )
    for name, length in lengths.items():
        _require_frames(truths[name].frames, length, f"truth of {name}")
        _require_frames(results[name].frames, length, f"results of {name}")
        T_road_label = None if Ts_road_label is None else Ts_road_label[name]
        write_labels(truths[name], folder / "gt" / "label_02" / f"{name}.txt", T_road_label)
        place = folder / "trackers" / tracker / "data" / f"{name}.txt"
        write_results(results[name], place, T_road_label)
    write_lines(
        folder / "gt" / "evaluate_tracking.seqmap.training",
        (f"{name} empty 000000 {length:06d}" for name, length in lengths.items()),
    )


def motchallenge_lines(tracks: Tracks) -> Iterator[str]:
    """The lines of a file of MOTChallenge with these rows; frames and ids count from 1."""
    return _lines(*_result_rows(tracks))


def _result_rows(tracks: Tracks) -> MotRows:
    classes = _classes(kinds_or_cars(tracks.kinds, len(tracks)))
    return tracks.frames, tracks.ids + 1, tracks.boxes, scores_or_ones(tracks), classes


def _detection_rows(indices: Int[Array, " k"], parts: list[Detections]) -> MotRows:
    detections = Detections.concatenate(parts) if parts else Detections.empty()
    frames = np.repeat(indices, [len(part) for part in parts])
    classes = _classes(kinds_or_cars(detections.kinds, len(detections)))
    return frames, np.full(len(frames), -1), detections.boxes, detections.scores, classes


def _truth_rows(truth: Tracks, scored: set[int]) -> MotRows:
    named = truth.select(truth.ids >= 0)
    classes = _classes(kinds_or_cars(named.kinds, len(named)))
    counted = np.where(np.isin(classes, list(scored)), 1.0, 0.0)
    return named.frames, named.ids + 1, named.boxes, counted, classes


def kinds_or_cars(kinds: Shaped[Array, " n"] | None, count: int) -> Shaped[Array, " n"]:
    """The classes of rows, cars where they do not say."""
    return np.full(count, "Car") if kinds is None else spelled_as_kitti(kinds)


def scores_or_ones(tracks: Tracks) -> Float[Array, " n"]:
    """The scores of rows, 1 where they do not say."""
    return np.ones(len(tracks)) if tracks.scores is None else tracks.scores


def _classes(kinds: Shaped[Array, " n"]) -> Int[Array, " n"]:
    """MOT16's numbers of KITTI's classes."""
    numbers = [MOT_CLASSES.get(str(kind), MOT_DISTRACTOR) for kind in kinds.tolist()]
    return np.array(numbers, dtype=np.int64)


def _require_frames(frames: Int[Array, " n"], length: int, what: str) -> None:
    outside = frames[(frames < 0) | (frames >= length)]
    if len(outside):
        raise BadTracks(f"{what}: frame {outside[0]} is outside the sequence of {length} frames")


def _lines(
    frames: Int[Array, " n"],
    ids: Int[Array, " n"],
    boxes: Float[Array, "n 4"],
    confidences: Float[Array, " n"],
    classes: Int[Array, " n"],
) -> Iterator[str]:
    sides = np.hstack([boxes[:, :2], boxes[:, 2:] - boxes[:, :2]])
    for row in np.argsort(frames, kind="stable").tolist():
        box = ",".join(f"{value:.6f}" for value in sides[row].tolist())
        yield f"{frames[row] + 1},{ids[row]},{box},{confidences[row]:.9g},{classes[row]},-1,-1"
