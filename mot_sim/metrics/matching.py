"""Which boxes share a frame and how much they overlap, and the best matching of every frame.

Frames are independent, and most hold no real choice. A pair that outweighs its best rival in
the row plus its best rival in the column is in every best matching: putting it in place of at
most one pair of that row and one of that column always gains. Such pairs are peeled off
over all frames at once. What is left, ties above all, goes to the Hungarian algorithm with the
frame's whole matrix, so that ties fall as they do in the reference evaluators.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from jaxtyping import Bool, Float, Int
from numpy import ndarray as Array

from tracker.errors import BadTracks
from tracker.geometry import box_iou
from tracker.types import Tracks

# The slack that TrackEval gives its comparisons of overlaps; here for the same verdict at ties.
EPSILON = float(np.finfo(float).eps)
# A lead below this may be rounding of the solver: such frames are left to the solver.
MIN_LEAD = 1e-9
# Beyond this a float skips whole numbers.
MAX_WHOLE = 2.0**53


def same_frame_pairs(
    a_frames: Int[Array, " n"], b_frames: Int[Array, " m"]
) -> tuple[Int[Array, " p"], Int[Array, " p"]]:
    """Every (row of a, row of b) that stand in one frame, in the order of a, then of b.

    The frames of b must ascend.
    """
    first = np.searchsorted(b_frames, a_frames, side="left")
    counts = np.searchsorted(b_frames, a_frames, side="right") - first
    rows = np.repeat(np.arange(len(a_frames)), counts)
    before = np.cumsum(counts) - counts
    return rows, np.arange(len(rows)) + np.repeat(first - before, counts)


@dataclass(frozen=True, eq=False)
class Overlaps:
    """Labels and output of one sequence, and every pair of one frame that overlaps at all.

    Pairs are in the order of rows, then columns, so also in the order of frames.
    """

    truth: Tracks
    """The labels: only frames, ids and boxes, in the order of frames."""
    output: Tracks
    """The tracker's rows: likewise."""
    rows: Int[Array, " p"]
    """Row of `truth` in each pair."""
    columns: Int[Array, " p"]
    """Row of `output` in each pair."""
    iou: Float[Array, " p"]
    """Intersection over union of the two boxes, > 0."""

    @classmethod
    def between(cls, truth: Tracks, output: Tracks) -> "Overlaps":
        """The overlaps of two tables whose rows are in the order of frames."""
        rows, columns = same_frame_pairs(truth.frames, output.frames)
        iou = box_iou(truth.boxes[rows], output.boxes[columns])
        touching = iou > 0.0
        return cls(truth, output, rows[touching], columns[touching], iou[touching])

    @cached_property
    def frames(self) -> Int[Array, " p"]:
        """The frame of every pair; ascending."""
        return self.truth.frames[self.rows]

    @cached_property
    def truth_ids(self) -> Int[Array, " p"]:
        """The label's id in every pair."""
        return self.truth.ids[self.rows]

    @cached_property
    def output_ids(self) -> Int[Array, " p"]:
        """The output's id in every pair."""
        return self.output.ids[self.columns]

    @cached_property
    def id_counts(self) -> tuple[int, int]:
        """How many ids the truth and the output hold, when they are numbered from 0."""
        return int(self.truth.ids.max(initial=-1)) + 1, int(self.output.ids.max(initial=-1)) + 1

    @cached_property
    def id_pairs(self) -> Int[Array, " p"]:
        """One number for the two ids of every pair, when they are numbered from 0."""
        return self.truth_ids * self.id_counts[1] + self.output_ids

    def keep(self, truth: Bool[Array, " n"], output: Bool[Array, " m"]) -> "Overlaps":
        """What is left with only the rows where the masks hold; ids are numbered from 0."""
        pairs = truth[self.rows] & output[self.columns]
        return Overlaps(
            numbered(self.truth.select(truth)),
            numbered(self.output.select(output)),
            (np.cumsum(truth) - 1)[self.rows[pairs]],
            (np.cumsum(output) - 1)[self.columns[pairs]],
            self.iou[pairs],
        )


def numbered(tracks: Tracks) -> Tracks:
    """The same rows with ids 0, 1, 2, ..., in the order of the old ids."""
    return Tracks(tracks.frames, np.unique(tracks.ids, return_inverse=True)[1], tracks.boxes)


def bare_rows(tracks: Tracks, rows: Bool[Array, " n"], frame_count: int, where: str) -> Tracks:
    """Frames, ids and boxes of the given rows, in the order of frames.

    Raises BadTracks for frames outside [0, frame_count), for boxes that are not finite and for
    an id that stands twice in a frame.
    """
    picked = Tracks(tracks.frames[rows], tracks.ids[rows], tracks.boxes[rows])
    outside = (picked.frames < 0) | (picked.frames >= frame_count)
    if outside.any():
        raise BadTracks(
            f"{where}: frame {picked.frames[outside][0]} is outside the sequence; its "
            f"{frame_count} frames count from 0 to {frame_count - 1}"
        )
    broken = ~np.isfinite(picked.boxes).all(axis=1)
    if broken.any():
        row = int(np.flatnonzero(broken)[0])
        raise BadTracks(
            f"{where}: box {picked.boxes[row].tolist()} of id {picked.ids[row]} in frame "
            f"{picked.frames[row]} is not finite; leave the row out"
        )
    picked.require_unique_ids(where)
    if (np.diff(picked.frames) < 0).any():
        return picked.select(np.argsort(picked.frames, kind="stable"))
    return picked


def whole_numbers(column: object, what: str, where: str) -> Int[Array, " n"]:
    """A column as signed integers of 64 bits, whatever its type; BadTracks for anything else."""
    numbers = np.asarray(column)
    if numbers.dtype.kind == "i":
        return numbers.astype(np.int64, copy=False)
    if numbers.dtype.kind not in "uf":
        raise BadTracks(
            f"{where}: {what}s are of type {numbers.dtype}, the first of them "
            f"{numbers.ravel()[:1].tolist()}; give whole numbers"
        )
    broken = ~(np.abs(numbers.astype(np.float64)) < MAX_WHOLE) | (numbers % 1 != 0)
    if broken.any():
        row = int(np.flatnonzero(broken)[0])
        raise BadTracks(f"{where}: {what} {numbers[row]} of row {row} is not a whole number")
    return numbers.astype(np.int64)


def corners(boxes: object, where: str) -> Float[Array, "n 4"]:
    """Boxes as rows of four floats, whatever their type; BadTracks for other shapes."""
    array = np.asarray(boxes, dtype=np.float64)
    if array.size == 0:
        return array.reshape(0, 4)
    if array.ndim != 2 or array.shape[1] != 4:
        raise BadTracks(
            f"{where}: boxes of shape {array.shape}: give n rows of x_min, y_min, x_max, y_max"
        )
    return array


def match(
    overlaps: Overlaps, pairs: Int[Array, " k"], weights: Float[Array, " k"]
) -> Int[Array, " j"]:
    """Those of the given pairs that together weigh most, no row or column used twice.

    pairs: ascending indices into the overlaps; all others weigh nothing. weights: > 0.
    """
    chosen, unclear = peel(overlaps.rows[pairs], overlaps.columns[pairs], weights)
    if unclear.any():
        frames = overlaps.frames[pairs]
        for frame in np.unique(frames[unclear]):
            here = slice(*np.searchsorted(frames, [frame, frame + 1]))
            chosen[here] = solve_frame(overlaps, int(frame), pairs[here], weights[here])
    return pairs[chosen]


def peel(
    rows: Int[Array, " k"], columns: Int[Array, " k"], weights: Float[Array, " k"]
) -> tuple[Bool[Array, " k"], Bool[Array, " k"]]:
    """Masks of the pairs that every best matching holds, and of those left undecided."""
    chosen = np.zeros(len(rows), dtype=bool)
    left = np.arange(len(rows))
    while len(left):
        row, column, weight = rows[left], columns[left], weights[left]
        certain = weight > best_rival(row, weight) + best_rival(column, weight) + MIN_LEAD
        if not certain.any():
            break
        chosen[left[certain]] = True
        taken_row, taken_column = np.zeros(row.max() + 1, bool), np.zeros(column.max() + 1, bool)
        taken_row[row[certain]] = True
        taken_column[column[certain]] = True
        left = left[~(taken_row[row] | taken_column[column])]
    unclear = np.zeros(len(rows), dtype=bool)
    unclear[left] = True
    return chosen, unclear


def best_rival(lines: Int[Array, " k"], weights: Float[Array, " k"]) -> Float[Array, " k"]:
    """The largest weight among the OTHER pairs of the same line; 0 where there is none."""
    best = np.zeros(lines.max() + 1)
    np.maximum.at(best, lines, weights)
    leads = weights == best[lines]
    second = np.zeros_like(best)
    np.maximum.at(second, lines[~leads], weights[~leads])
    alone = leads & (np.bincount(lines[leads], minlength=len(best))[lines] == 1)
    return np.where(alone, second[lines], best[lines])


def solve_frame(
    overlaps: Overlaps, frame: int, pairs: Int[Array, " k"], weights: Float[Array, " k"]
) -> Bool[Array, " k"]:
    """Which of one frame's pairs the Hungarian algorithm takes; the others weigh nothing."""
    from scipy.optimize import linear_sum_assignment

    top, bottom = np.searchsorted(overlaps.truth.frames, [frame, frame + 1])
    left, right = np.searchsorted(overlaps.output.frames, [frame, frame + 1])
    rows, columns = overlaps.rows[pairs] - top, overlaps.columns[pairs] - left
    matrix = np.zeros((bottom - top, right - left))
    matrix[rows, columns] = weights
    partner = np.full(bottom - top, -1)
    solved_rows, solved_columns = linear_sum_assignment(matrix, maximize=True)
    partner[solved_rows] = solved_columns
    return partner[rows] == columns
