"""KITTI's label rows, `frame id type truncated occluded alpha x1 ... rotation_y`, as `Tracks`."""

from pathlib import Path

import numpy as np
from jaxtyping import Float
from numpy import ndarray as Array

from mot_sim.datasets.kitti.cuboid_rows import (
    NO_ALPHA,
    NO_CUBOID,
    NO_CUBOID_DONT_CARE,
    alpha_of,
    cuboids_of_rows,
    rows_of_cuboids,
)
from mot_sim.files.text import TextTable, read_table
from mot_sim.files.writing import write_lines
from tracker.errors import BadTracks
from tracker.types import Tracks

LABEL_COLUMNS = (
    "frame", "id", "type", "truncated", "occluded", "alpha", "x1", "y1", "x2", "y2",
    "h", "w", "l", "x", "y", "z", "rotation_y",
)  # fmt: skip
LABEL_BOX_COLUMNS = LABEL_COLUMNS[6:10]
CUBOID_COLUMNS = LABEL_COLUMNS[10:]


def read_labels(
    path: Path,
    T_road_label: Float[Array, "4 4"] | None = None,
    frame_count: int | None = None,
) -> Tracks:
    """The labels of a sequence, DontCare among them with id -1, in the order of frames.

    T_road_label: from camera 0 to the road frame (`KittiSequence.T_road_label`); without it the
    cuboids stay unread. Rows without a cuboid have NaN there. alpha is not kept. Raises BadFile
    with file and line for bad rows, frames outside the sequence and an id twice in a frame.
    """
    table = read_table(path, LABEL_COLUMNS, words=["type"])
    return tracks_of_table(table, T_road_label, frame_count)


def write_labels(
    tracks: Tracks, path: Path, T_road_label: Float[Array, "4 4"] | None = None
) -> None:
    """Write label rows, as a whole or not at all; `read_labels` gives the same back.

    Six decimals. alpha is computed from the cuboid. Without T_road_label no cuboid is written.
    Raises BadTracks for an id twice in a frame and for boxes that are not finite.
    """
    write_lines(path, label_lines(tracks, str(path), T_road_label))


def tracks_of_table(
    table: TextTable, T_road_label: Float[Array, "4 4"] | None, frame_count: int | None
) -> Tracks:
    """The tracks of a table with the columns of labels, and perhaps `score`."""
    cuboids = None
    if T_road_label is not None:
        cuboids, known = cuboids_of_rows(table.finite(CUBOID_COLUMNS), T_road_label)
        cuboids = cuboids if known.any() or not len(known) else None
    tracks = Tracks(
        table.frames(frame_count),
        table.integers("id", -1),
        require_boxes(table),
        table.finite(["score"])[:, 0] if "score" in (table.rows.dtype.names or ()) else None,
        table["type"],
        table.integers("truncated"),
        table.integers("occluded"),
        cuboids,
    )
    return in_order(tracks, table)


def require_boxes(table: TextTable) -> Float[Array, "n 4"]:
    """The boxes x1 y1 x2 y2 of a table; BadFile for NaN, infinity and inverted ones."""
    boxes = table.finite(LABEL_BOX_COLUMNS)
    inverted = np.asarray((boxes[:, 2:] < boxes[:, :2]).any(axis=1))
    table.reject(inverted, "inverted box", LABEL_BOX_COLUMNS, "x1 <= x2 and y1 <= y2 belong here")
    return boxes


def in_order(tracks: Tracks, table: TextTable) -> Tracks:
    """The tracks in the order of frames; BadFile with the line of an id twice in a frame."""
    order = np.lexsort((tracks.ids, tracks.frames))
    frames, ids = tracks.frames[order], tracks.ids[order]
    twice = np.zeros(len(tracks), dtype=bool)
    twice[order[1:]] = (frames[1:] == frames[:-1]) & (ids[1:] == ids[:-1]) & (ids[1:] >= 0)
    table.reject(twice, "an id twice in a frame", ["frame", "id"], "an id names one object a frame")
    return tracks.select(np.argsort(tracks.frames, kind="stable"))


def label_lines(tracks: Tracks, where: str, T_road_label: Float[Array, "4 4"] | None) -> list[str]:
    """The 17 columns of every row, in the order of frames."""
    tracks.require_unique_ids(where)
    if not np.isfinite(tracks.boxes).all():
        row = int(np.flatnonzero(~np.isfinite(tracks.boxes).all(axis=1))[0])
        raise BadTracks(f"{where}: box of row {row} is not finite: {tracks.boxes[row].tolist()}")
    count = len(tracks)
    kinds = ["Car"] * count if tracks.kinds is None else tracks.kinds.tolist()
    unsaid = np.full(count, -1)
    levels = np.stack(
        [unsaid if level is None else level for level in (tracks.truncation, tracks.occlusion)]
    ).T.tolist()
    numbers = np.column_stack(_alpha_and_cuboids(tracks, kinds, T_road_label)).tolist()
    lines = []
    for row in np.argsort(tracks.frames, kind="stable").tolist():
        alpha, *cuboid = numbers[row]
        values = [alpha, *tracks.boxes[row].tolist(), *cuboid]
        lines.append(
            f"{tracks.frames[row]} {tracks.ids[row]} {kinds[row]} "
            f"{levels[row][0]} {levels[row][1]} {' '.join(f'{value:.6f}' for value in values)}"
        )
    return lines


def _alpha_and_cuboids(
    tracks: Tracks, kinds: list[str], T_road_label: Float[Array, "4 4"] | None
) -> tuple[Float[Array, " n"], Float[Array, "n 7"]]:
    absent = np.array(
        [NO_CUBOID_DONT_CARE if kind == "DontCare" else NO_CUBOID for kind in kinds]
    ).reshape(-1, 7)
    if tracks.cuboids is None or T_road_label is None:
        return np.full(len(tracks), NO_ALPHA), absent
    rows = rows_of_cuboids(tracks.cuboids, T_road_label)
    known = np.isfinite(rows).all(axis=1)
    return np.where(known, alpha_of(rows), NO_ALPHA), np.where(known[:, None], rows, absent)
