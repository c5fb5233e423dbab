"""Trackers' results: the KITTI server's rows, and the rows that the paper's authors published."""

from pathlib import Path

import numpy as np
from jaxtyping import Float
from numpy import ndarray as Array

from mot_sim.datasets.kitti.labels import (
    LABEL_BOX_COLUMNS,
    LABEL_COLUMNS,
    in_order,
    label_lines,
    require_boxes,
    tracks_of_table,
)
from mot_sim.files.text import read_table
from mot_sim.files.writing import write_lines
from tracker.errors import BadTracks
from tracker.types import Tracks

RESULT_COLUMNS = (*LABEL_COLUMNS, "score")
AUTHORS_COLUMNS = ("frame", "id", *LABEL_BOX_COLUMNS, "score")
COLUMNS_BY_COUNT = {
    len(columns): columns for columns in (AUTHORS_COLUMNS, LABEL_COLUMNS, RESULT_COLUMNS)
}
COLUMNS_BY_COUNT[0] = RESULT_COLUMNS  # an empty file: nothing was tracked


def write_results(
    tracks: Tracks, path: Path, T_road_label: Float[Array, "4 4"] | None = None
) -> None:
    """Write rows for the KITTI server: label columns and a score, frames from 0.

    The file appears as a whole or not at all. Rows are Cars unless the tracks have kinds;
    truncation and occlusion that nobody knows are -1, scores 1. Cuboids are written in camera 0
    when T_road_label (`KittiSequence.T_road_label`) is given; where there is none, the row says
    alpha -10 and -1 -1 -1 -1000 -1000 -1000 -10. Raises BadTracks for an id twice in a frame
    and for boxes and scores that are not finite.
    """
    scores = np.ones(len(tracks)) if tracks.scores is None else tracks.scores
    if not np.isfinite(scores).all():
        row = int(np.flatnonzero(~np.isfinite(scores))[0])
        raise BadTracks(f"{path}: score of row {row} is not finite: {scores[row]}")
    order = np.argsort(tracks.frames, kind="stable")
    lines = label_lines(tracks, str(path), T_road_label)
    write_lines(
        path,
        (f"{line} {score:.9g}" for line, score in zip(lines, scores[order].tolist(), strict=True)),
    )


def read_results(
    path: Path,
    T_road_label: Float[Array, "4 4"] | None = None,
    frame_count: int | None = None,
) -> Tracks:
    """The tracks in a result file, in the order of frames.

    Reads KITTI's rows, with or without a score, and the authors' `frame id x1 y1 x2 y2 score`,
    whose frames count from 1; the number of values on the first line tells them apart. Cuboids
    are read when T_road_label is given and a row has one. Raises BadFile with file and line for
    bad rows, frames outside the sequence and an id twice in a frame.
    """
    table = read_table(path, lambda fields: COLUMNS_BY_COUNT.get(len(fields)), words=["type"])
    if "type" in (table.rows.dtype.names or ()):
        return tracks_of_table(table, T_road_label, frame_count)
    tracks = Tracks(
        table.frames(frame_count, first=1),
        table.integers("id", 0),
        require_boxes(table),
        table.finite(["score"])[:, 0],
    )
    return in_order(tracks, table)
