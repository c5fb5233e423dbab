"""The best one-to-one matching of every frame, solved only where it is not obvious.

Frames are independent, and most hold no real choice. A pair that outweighs its best rival in
the row plus its best rival in the column is in every best matching: putting it in place of at
most one pair of that row and one of that column always gains. Such pairs are peeled off
over all frames at once. What is left, ties above all, goes to the Hungarian algorithm with the
frame's whole matrix, so that ties fall as they do in the reference evaluators.
"""

import numpy as np
from jaxtyping import Bool, Float, Int
from numpy import ndarray as Array
from scipy.optimize import linear_sum_assignment

from mot_sim.metrics.overlaps import Overlaps

# A lead below this may be rounding of the solver: such frames are left to the solver.
MIN_LEAD = 1e-9


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
    top, bottom = np.searchsorted(overlaps.truth.frames, [frame, frame + 1])
    left, right = np.searchsorted(overlaps.output.frames, [frame, frame + 1])
    rows, columns = overlaps.rows[pairs] - top, overlaps.columns[pairs] - left
    matrix = np.zeros((bottom - top, right - left))
    matrix[rows, columns] = weights
    partner = np.full(bottom - top, -1)
    solved_rows, solved_columns = linear_sum_assignment(matrix, maximize=True)
    partner[solved_rows] = solved_columns
    return partner[rows] == columns
