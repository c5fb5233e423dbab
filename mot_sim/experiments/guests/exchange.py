"""The files between us and a guest: detections out, result rows in, strictly checked."""

import json
from collections.abc import Sequence
from math import isfinite
from pathlib import Path

import numpy as np

from mot_sim.datasets.kitti.labels import (
    COLUMNS_BY_COUNT,
    LABEL_BOX_COLUMNS,
    in_order,
    levels_or_shares,
    require_boxes,
    tracks_of_table,
)
from mot_sim.datasets.recorded import RecordedSequence
from mot_sim.files.documents import read_json
from mot_sim.files.text import TextTable, read_table
from mot_sim.files.writing import write_lines
from tracker.errors import BadFile
from tracker.types import Tracks

SEQUENCES, SECONDS = "sequences.json", "seconds.json"
PLAIN = ("frame", "id", *LABEL_BOX_COLUMNS, "score")
LAYOUTS = {**COLUMNS_BY_COUNT, len(PLAIN): PLAIN}


def write_detections(drives: Sequence[RecordedSequence], min_score: float, folder: Path) -> None:
    """The detections of the delivered frames as SSSS.txt, and `sequences.json`; see docs/guests.md.

    Rows are `frame,x1,y1,x2,y2,score`, frames from 0; scores below min_score are left out.
    """
    for drive in drives:
        lines = []
        for index in drive.frame_indices.tolist():
            seen = drive.log.at(index)
            rows = zip(seen.boxes.tolist(), seen.scores.tolist(), strict=True)
            lines += [
                f"{index},{','.join(f'{side:.9g}' for side in box)},{score:.9g}"
                for box, score in rows
                if score >= min_score
            ]
        write_lines(folder / f"{drive.name}.txt", lines)
    write_lines(folder / SEQUENCES, [json.dumps(describe(drives), indent=1)])


def describe(drives: Sequence[RecordedSequence]) -> dict[str, dict[str, object]]:
    """What `sequences.json` says of each drive."""
    return {
        drive.name: {
            "frame_count": drive.frame_count,
            "frames": drive.frame_indices.tolist(),
            "frame_rate": drive.frame_rate,
            "image_width": drive.camera.image_size[0],
            "image_height": drive.camera.image_size[1],
        }
        for drive in drives
    }


def read_guest_results(drives: Sequence[RecordedSequence], folder: Path) -> dict[str, Tracks]:
    """The rows that a guest wrote for every drive.

    Reads `frame id x1 y1 x2 y2 score`, frames from 0 (`mot-sim evaluate` takes such files as the
    authors', from 1), and KITTI's rows. Raises BadFile with file and line for rows of another
    layout, NaN, inverted boxes, frames that were not given, ids below 0 or twice in a frame, for
    a drive without a file, and for files of no drive.
    """
    names = {drive.name for drive in drives}
    strange = sorted(path.name for path in folder.glob("*.txt") if path.stem not in names)
    if strange:
        raise BadFile(
            f"{folder / strange[0]}: results of no sequence that was given; write SSSS.txt for "
            f"{', '.join(sorted(names))}"
        )
    return {drive.name: _read_drive(drive, folder / f"{drive.name}.txt") for drive in drives}


def _read_drive(drive: RecordedSequence, path: Path) -> Tracks:
    """The rows of one drive."""
    if not path.is_file():
        raise BadFile(f"{path}: not written; where nothing is tracked, write an empty file")
    table = read_table(path, lambda fields: LAYOUTS.get(len(fields)), words=["type"])
    table.reject(
        ~np.isin(table.frames(drive.frame_count), drive.frame_indices),
        "frame that was not given",
        ["frame"],
        f"{SEQUENCES} lists the frames",
    )
    ids = table.integers("id")
    table.reject(ids < 0, "id below 0", ["frame", "id"], "leave out rows that belong to no track")
    if "type" in (table.rows.dtype.names or ()):
        truncation = levels_or_shares(table, "truncated")
        return tracks_of_table(table, None, drive.frame_count, truncation)
    return _plain_tracks(table)


def _plain_tracks(table: TextTable) -> Tracks:
    """The tracks of `frame id x1 y1 x2 y2 score` rows, frames from 0."""
    scores = table.finite(["score"])[:, 0]
    ids = table.integers("id")
    return in_order(Tracks(table.frames(), ids, require_boxes(table), scores), table)


def read_seconds(drives: Sequence[RecordedSequence], folder: Path) -> dict[str, float] | None:
    """The CPU seconds of the tracker's calls alone, by drive; None when the guest tells none.

    Raises BadFile for a `seconds.json` that does not hold a number above 0 for every drive.
    """
    path = folder / SECONDS
    if not path.is_file():
        return None
    try:
        told = read_json(path, "not a number of seconds for every sequence")
        seconds = {drive.name: float(told[drive.name]) for drive in drives}
    except (ValueError, TypeError, KeyError) as error:
        raise BadFile(f"{path}: not a number of seconds for every sequence: {error!r}") from None
    for name, value in seconds.items():
        if not (isfinite(value) and value >= 0.0):
            raise BadFile(f"{path}: {value:g} seconds for {name}; give a number, 0 or more")
    return seconds
