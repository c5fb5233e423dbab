"""KITTI's rows of labels and results, as `Tracks`, and their cuboids in the road frame.

The frame of the labels is camera 0. T_road_label carries its points to the road frame. In a
pitched or rolled camera KITTI's rotation_y is the yaw projected on the camera's +y.
"""

from pathlib import Path

import numpy as np
from jaxtyping import Bool, Float, Int, Shaped
from numpy import ndarray as Array

from mot_sim.datasets.box_checks import (
    CUBOID_COLUMNS,
    inverted_cure,
    refuse_normalised,
    require_cuboid_rows,
)
from mot_sim.datasets.estimate_files import with_estimates, write_estimates
from mot_sim.files.text import TextTable, read_table
from mot_sim.files.writing import write_lines
from tracker.errors import BadFile, BadTracks
from tracker.geometry import invert, transform, wrap_angle
from tracker.types import KITTI_KINDS, Cuboids, Tracks, is_kitti_kind, spelled_as_kitti

# What KITTI writes where there is no cuboid: in results, and in DontCare labels.
NO_CUBOID = (-1.0, -1.0, -1.0, -1000.0, -1000.0, -1000.0, -10.0)
NO_CUBOID_DONT_CARE = (-1000.0, -1000.0, -1000.0, -10.0, -1.0, -1.0, -1.0)
NO_ALPHA = -10.0
UNKNOWN_PLACE = -1000.0
LABEL_COLUMNS = (
    "frame", "id", "type", "truncated", "occluded", "alpha", "x1", "y1", "x2", "y2",
    *CUBOID_COLUMNS,
)  # fmt: skip
LABEL_BOX_COLUMNS = LABEL_COLUMNS[6:10]
RESULT_COLUMNS = (*LABEL_COLUMNS, "score")
AUTHORS_COLUMNS = ("frame", "id", *LABEL_BOX_COLUMNS, "score")
COLUMNS_BY_COUNT = {
    len(columns): columns for columns in (AUTHORS_COLUMNS, LABEL_COLUMNS, RESULT_COLUMNS)
}


def cuboids_of_rows(
    rows: Float[Array, "n 7"], T_road_label: Float[Array, "4 4"]
) -> tuple[Cuboids, Bool[Array, " n"]]:
    """The cuboids of `h w l x y z rotation_y`, and which rows have one.

    What is not known is NaN: a size that is not positive, a rotation_y of -10, a place of -1000.
    Rows without a place have no cuboid at all, nor have those without a size whose z is not ahead
    of the camera: other tools write -1 or 0 for everything.
    """
    sized = np.asarray((rows[:, :3] > 0.0).all(axis=1))
    placed = np.asarray((rows[:, 3:6] > UNKNOWN_PLACE).all(axis=1))
    known = placed & (sized | (rows[:, 5] > 0.0))
    base = transform(T_road_label, rows[:, 3:6])
    rotation_y = rows[:, 6]
    facing = np.linalg.solve(_plane_turn(T_road_label), _facing(rotation_y)).T
    yaw = rotation_y + wrap_angle(np.arctan2(-facing[:, 1], facing[:, 0]) - rotation_y)
    size = rows[:, [2, 0, 1]]
    absent = ~known
    base[absent], yaw[absent] = np.nan, np.nan
    size[absent | ~sized] = np.nan
    yaw[rotation_y == NO_ALPHA] = np.nan
    return Cuboids(base, yaw, size), known


def rows_of_cuboids(cuboids: Cuboids, T_road_label: Float[Array, "4 4"]) -> Float[Array, "n 7"]:
    """`h w l x y z rotation_y` of cuboids: the inverse of `cuboids_of_rows`. NaN stays NaN."""
    facing = (_plane_turn(T_road_label) @ _facing(cuboids.yaw)).T
    rotation_y = cuboids.yaw + wrap_angle(np.arctan2(-facing[:, 1], facing[:, 0]) - cuboids.yaw)
    base_label = transform(invert(T_road_label), cuboids.base)
    return np.column_stack([cuboids.size[:, [1, 2, 0]], base_label, rotation_y])


def alpha_of(rows: Float[Array, "n 7"]) -> Float[Array, " n"]:
    """The observation angle of `h w l x y z rotation_y`: rotation_y less the viewing azimuth."""
    return np.asarray(wrap_angle(rows[:, 6] - np.arctan2(rows[:, 3], rows[:, 5])))


def _facing(yaw: Float[Array, " n"]) -> Float[Array, "2 n"]:
    """x and z of where a car of this yaw faces."""
    return np.stack([np.cos(yaw), -np.sin(yaw)])


def _plane_turn(T_road_label: Float[Array, "4 4"]) -> Float[Array, "2 2"]:
    """x and z of a road direction, seen in the labels' frame."""
    R_label_road = T_road_label[:3, :3].T
    return R_label_road[np.ix_([0, 2], [0, 2])]


def read_labels(
    path: Path, T_road_label: Float[Array, "4 4"] | None = None, frame_count: int | None = None
) -> Tracks:
    """The labels of a sequence, DontCare among them with id -1, in the order of frames.

    T_road_label: from camera 0 to the road frame (`KittiSequence.T_road_label`); without it the
    cuboids stay unread. Rows without a cuboid have NaN there. alpha is not kept. Raises BadFile
    with file and line for bad rows, frames outside the sequence and an id twice in a frame.
    """
    table = read_table(path, LABEL_COLUMNS, words=["type"])
    return tracks_of_table(table, T_road_label, frame_count, levels(table, "truncated"))


def write_labels(
    tracks: Tracks, path: Path, T_road_label: Float[Array, "4 4"] | None = None
) -> None:
    """Write label rows, as a whole or not at all; `read_labels` gives the same back.

    Six decimals. alpha is computed from the cuboid. Without T_road_label no cuboid is written.
    Raises BadTracks for an id twice in a frame and for boxes that are not finite.
    """
    write_lines(path, label_lines(tracks, str(path), T_road_label))


def tracks_of_table(
    table: TextTable,
    T_road_label: Float[Array, "4 4"] | None,
    frame_count: int | None,
    truncation: Int[Array, " n"],
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
        kinds_of(table),
        truncation,
        levels(table, "occluded"),
        cuboids,
    )
    return in_order(tracks, table)


def levels(table: TextTable, column: str) -> Int[Array, " n"]:
    """A column of KITTI's levels; BadFile for shares, as its object benchmark has them."""
    cure = "tracking labels have levels 0, 1, 2 (occluded: 3 as well), or -1 where it is unknown"
    return table.integers(column, cure=cure)


def levels_or_shares(table: TextTable, column: str) -> Int[Array, " n"]:
    """A column of levels that may hold shares in 0..1 as well: no level is known (-1) there."""
    numbers = table.finite([column])[:, 0]
    shares = (numbers > 0.0) & (numbers < 1.0)
    cure = "write a level (0, 1, 2, -1 for unknown) or a share in 0..1"
    table.reject(~shares & (numbers % 1.0 != 0.0), f"{column} is no level", [column], cure)
    return np.where(shares, -1, numbers).astype(np.int64)


def kinds_of(table: TextTable) -> Shaped[Array, " n"]:
    """The column `type` in KITTI's spelling, whatever its case; BadFile for no class of KITTI."""
    kinds = spelled_as_kitti(table["type"])
    cure = f"KITTI's classes are {', '.join(KITTI_KINDS)} (case does not matter)"
    table.reject(~is_kitti_kind(kinds), "no class of KITTI", ["type"], cure)
    return kinds


def require_boxes(table: TextTable) -> Float[Array, "n 4"]:
    """The boxes x1 y1 x2 y2 of a table; BadFile for NaN, infinity and inverted ones."""
    boxes = table.finite(LABEL_BOX_COLUMNS)
    inverted = np.asarray((boxes[:, 2:] < boxes[:, :2]).any(axis=1))
    table.reject(
        inverted, "inverted box", LABEL_BOX_COLUMNS, inverted_cure(inverted, "x1 y1 x2 y2")
    )
    refuse_normalised(table, boxes, LABEL_BOX_COLUMNS)
    return boxes


def in_order(tracks: Tracks, table: TextTable) -> Tracks:
    """The tracks in the order of frames; BadFile with the line of an id twice in a frame."""
    table.reject_repeated(tracks.frames, tracks.ids)
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
    known = np.isfinite(rows)
    # DontCare is known as a whole or not at all; of other rows each part that is known is written.
    whole = known.all(axis=1) | np.array([kind != "DontCare" for kind in kinds], dtype=bool)
    alpha = np.where(known.all(axis=1), alpha_of(rows), NO_ALPHA)
    return alpha, np.where(known & whole[:, None], rows, absent)


def read_cuboid_results(
    path: Path, T_road_label: Float[Array, "4 4"], frame_count: int | None = None
) -> Tracks:
    """The tracks in a result file that is to be scored in 3D; see `read_results`.

    Raises BadFile, too, where no row has a cuboid, for sizes that are not positive where a place
    is given, and for cuboids wholly behind the camera.
    """
    table = read_result_table(path)
    if "type" in (table.rows.dtype.names or ()):
        rows = table.finite(CUBOID_COLUMNS)
        placed = np.asarray((rows[:, 3:6] > UNKNOWN_PLACE).all(axis=1) & rows.any(axis=1))
        unsaid = np.asarray((rows[:, :3] < 0.0).all(axis=1))
        require_cuboid_rows(table, rows, placed & ~unsaid)
    tracks = _tracks_of_results(table, T_road_label, frame_count)
    if len(tracks) and tracks.cuboids is None:
        raise BadFile(
            f"{path}: none of {len(tracks)} rows has a cuboid (h w l x y z rotation_y), so it "
            "cannot be scored in 3D; write cuboids, or score it in 2D"
        )
    return tracks


COLUMNS_BY_COUNT[0] = RESULT_COLUMNS  # an empty file: nothing was tracked


def write_results(
    tracks: Tracks, path: Path, T_road_label: Float[Array, "4 4"] | None = None
) -> None:
    """Write rows for the KITTI server: label columns and a score, frames from 0.

    The file appears as a whole or not at all. Rows are Cars unless the tracks have kinds;
    unknown truncation and occlusion are -1, unknown scores 1. Cuboids are written in camera 0
    when T_road_label (`KittiSequence.T_road_label`) is given; what is not known of one is -1 -1 -1
    (size), -1000 -1000 -1000 (place) and -10 (rotation_y, alpha). The states that cuboids are part
    of (`Tracks.estimates`) go to a file beside, see `write_estimates`. Raises BadTracks for an id
    twice in a frame and for boxes and scores that are not finite.
    """
    scores = np.ones(len(tracks)) if tracks.scores is None else tracks.scores
    if not np.isfinite(scores).all():
        row = int(np.flatnonzero(~np.isfinite(scores))[0])
        raise BadTracks(f"{path}: score of row {row} is not finite: {scores[row]}")
    order = np.argsort(tracks.frames, kind="stable")
    lines = label_lines(tracks, str(path), T_road_label)
    write_estimates(tracks, path, T_road_label)
    write_lines(
        path,
        (f"{line} {score:.9g}" for line, score in zip(lines, scores[order].tolist(), strict=True)),
    )


def read_results(
    path: Path, T_road_label: Float[Array, "4 4"] | None = None, frame_count: int | None = None
) -> Tracks:
    """The tracks in a result file, in the order of frames.

    Reads KITTI's rows, with or without a score, and the authors' `frame id x1 y1 x2 y2 score`,
    whose frames count from 1; the number of values on the first line tells them apart. Cuboids
    are read when T_road_label is given and a row has one, and so are the states beside, see
    `with_estimates`. Raises BadFile with file and line for bad rows, frames outside the sequence
    and an id twice in a frame.
    """
    return _tracks_of_results(read_result_table(path), T_road_label, frame_count)


def read_result_table(path: Path) -> TextTable:
    """The rows of a result file, in KITTI's columns or the authors'."""
    return read_table(path, lambda fields: COLUMNS_BY_COUNT.get(len(fields)), words=["type"])


def _tracks_of_results(
    table: TextTable, T_road_label: Float[Array, "4 4"] | None, frame_count: int | None
) -> Tracks:
    """The tracks of a result file's table, in the order of frames."""
    if "type" in (table.rows.dtype.names or ()):
        truncation = levels_or_shares(table, "truncated")
        tracks = tracks_of_table(table, T_road_label, frame_count, truncation)
        return tracks if T_road_label is None else with_estimates(tracks, table.path, T_road_label)
    tracks = Tracks(
        table.frames(frame_count, first=1),
        table.integers("id", 0),
        require_boxes(table),
        table.finite(["score"])[:, 0],
    )
    return in_order(tracks, table)
