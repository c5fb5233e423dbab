"""The tracks after a frame: those detected in it, those that live on without, those that begin."""

from math import nan

import numpy as np

from tracker.kernels.box_gains import filter_boxes
from tracker.kernels.compiling import (
    A1,
    A_I1,
    BOOL,
    F1,
    F2,
    F3,
    F4,
    FLOAT,
    I1,
    INT,
    OUT1,
    OUT2,
    OUT3,
    OUT4,
    OUT_I1,
    inlined,
    kernel,
)
from tracker.kernels.existing import is_in_view, judge_rows
from tracker.kernels.lifting import correct_places
from tracker.kernels.tables import belief_columns


@kernel(F1, INT, INT, OUT1, INT, INT, allocates=False)
def copy_belief(beliefs, n, row, out, m, at):
    """The same belief, of n packed ones, in a packed table of m."""
    for first, width in ((0, 3), (3, 1), (4, 3), (7, 2), (9, 16), (25, 4)):
        source, target = first * n + width * row, first * m + width * at
        for number in range(width):
            out[target + number] = beliefs[source + number]


@kernel(F1, INT, INT, A1, F1, FLOAT, FLOAT, allocates=False)
def is_alive(tracks, n, row, depth_of, far, min_depth, max_gap):
    """Whether a packed track that was not detected lives on: not too long unseen, and in view."""
    place, box = tracks[3 * row : 3 * row + 3], tracks[25 * n + 4 * row : 25 * n + 4 * row + 4]
    return tracks[29 * n + row] <= max_gap and is_in_view(place, box, depth_of, far, min_depth)


@inlined
def put_together(
    rows, columns, born, scores, tracks, ints, n, existence, seen, m, now, off, fresh, which,
    living, next_id, floats, whole,
):  # fmt: skip
    """The tracks after a frame, packed, and where they come from; how many there are.

    They keep their order, or have that of `rows` where all were detected. rows, columns: of those
    detected, by which detection; now: what they are then, packed, off: their innovations, in that
    order. Others that are `living` stay as they are. existence: after the frame. born: detections
    (`seen`) that begin tracks, which exist as `fresh` says. which: of the `rows` a track is, or
    -1. places, the last third of `whole`: where a row comes from, counted through the tracks
    before, the detected ones and the detections.
    """
    k, count = len(rows), len(rows) + len(born)
    for row in range(n):
        count += which[row] < 0 and living[row]
    at = 0
    for turn in range(n):
        row = rows[turn] if k == n else turn
        detected = which[row]
        if detected < 0 and not living[row]:
            continue
        if detected >= 0:
            copy_belief(now, k, detected, floats, count, at)
            floats[29 * count + at], floats[35 * count + at] = 0.0, scores[columns[detected]]
            whole[count + at], whole[2 * count + at] = ints[n + row] + 1, n + detected
        else:
            copy_belief(tracks, n, row, floats, count, at)
            floats[29 * count + at], floats[35 * count + at] = tracks[29 * n + row], nan
            whole[count + at], whole[2 * count + at] = ints[n + row], row
        for side in range(4):
            before = tracks[31 * n + 4 * row + side]
            innovation = off[detected, side] if detected >= 0 else before
            floats[31 * count + 4 * at + side] = innovation
        whole[at], floats[30 * count + at] = ints[row], existence[row]
        at += 1
    for begun in range(len(born)):
        column = born[begun]
        copy_belief(seen, m, column, floats, count, at)
        floats[29 * count + at], floats[30 * count + at] = 0.0, fresh[begun]
        floats[35 * count + at] = scores[column]
        for side in range(4):
            floats[31 * count + 4 * at + side] = nan
        whole[at], whole[count + at], whole[2 * count + at] = next_id + begun, 1, n + k + column
        at += 1
    return count


@inlined
def copy_car(means, covs, log_weights, row, out, at):
    """The same hypotheses in another table."""
    out_means, out_covs, out_log_weights = out
    for which in range(means.shape[1]):
        out_log_weights[at, which] = log_weights[row, which]
        for line in range(9):
            out_means[at, which, line] = means[row, which, line]
            for column in range(9):
                out_covs[at, which, line, column] = covs[row, which, line, column]


@kernel(
    I1, F3, F4, F2, F3, F4, F2, F3, F4, F2, OUT3, OUT4, OUT2, allocates=False
)  # fmt: skip
def renew_cars(
    places, means, covs, log_weights, new_means, new_covs, new_log_weights, fresh_means,
    fresh_covs, fresh_log_weights, out_means, out_covs, out_log_weights,
):  # fmt: skip
    """The cars behind `renew_tracks`: as before, as updated, and those that begin, in order."""
    n, k, begun = len(means), len(new_means), 0
    out = out_means, out_covs, out_log_weights
    for at in range(len(out_means)):
        place = places[at]
        if place < n:
            copy_car(means, covs, log_weights, place, out, at)
        elif place < n + k:
            copy_car(new_means, new_covs, new_log_weights, place - n, out, at)
        else:
            copy_car(fresh_means, fresh_covs, fresh_log_weights, begun, out, at)
            begun += 1


@kernel(
    A_I1, A_I1, A_I1, A_I1, A1, F1, I1, INT, F1, INT, BOOL, BOOL, BOOL, INT, INT, INT, INT, F1,
    FLOAT, FLOAT, F1, FLOAT, F2, F2, F2, F1, FLOAT, FLOAT, F1, INT, FLOAT, A1, F1, FLOAT, OUT1,
    OUT_I1, OUT1,
)  # fmt: skip
def step_tracks(
    rows, columns, missed, born, scores, tracks, ints, n, seen, m, moves, judges, filters, hit,
    tries, confirmed, newborns, settings, dt, one_step, existence_limits, right, gains, pairs,
    power, sizes, border, prior, gain_limits, next_id, max_gap, depth_of, far, min_depth, floats,
    whole, learned_gains,
):  # fmt: skip
    """The tracks after a frame, packed, by the kernels of its parts; how many there are.

    tracks, seen: packed. moves: whether a Kalman filter corrects places (`correct_places`), else
    detections are taken as they are; judges: `judge_rows`; filters: `filter_boxes`. hit, tries,
    confirmed, newborns: what is known of the detector. floats, whole: see `put_together`; whole
    ends with what is known of the detector then. learned_gains: gains, power and pairs, one after
    the other. The rest as these have it.
    """
    k = len(rows)
    old, found, now = np.empty(29 * k), np.empty(29 * k), np.empty(29 * k)
    old_hits, which, living = np.empty(k, np.int64), np.empty(n, np.int64), np.empty(n, np.bool_)
    old_since, old_off, off = np.empty(k), np.empty((k, 4)), np.empty((k, 4))
    after, fresh = np.empty(n), np.empty(len(born))
    for row in range(n):
        living[row] = is_alive(tracks, n, row, depth_of, far, min_depth, max_gap)
        which[row], after[row] = -1, tracks[30 * n + row]
    for at in range(k):
        row = rows[at]
        which[row], after[row] = at, 1.0
        copy_belief(tracks, n, row, old, k, at)
        copy_belief(seen, m, columns[at], found, k, at)
        copy_belief(seen, m, columns[at], now, k, at)
        old_hits[at], old_since[at] = ints[n + row], tracks[29 * n + row]
        for side in range(4):
            old_off[at, side] = off[at, side] = tracks[31 * n + 4 * row + side]
    was, is_seen, then = belief_columns(old, k), belief_columns(found, k), belief_columns(now, k)
    if moves:
        correct_places(was[0], was[3], was[4], is_seen[0], is_seen[4], then[0], then[3], then[4])
    if filters:
        filter_boxes(
            gains, pairs, power, sizes, was[5], is_seen[5], old_hits, old_since, old_off, dt, far,
            border, prior, gain_limits, then[5], off, learned_gains[:12].reshape((3, 4)),
            learned_gains[24:].reshape((3, 1)), learned_gains[12:24].reshape((3, 4)),
        )  # fmt: skip
    learned = whole[-4:]
    learned[0], learned[1], learned[2], learned[3] = hit, tries, confirmed, newborns
    for begun in range(len(born)):
        fresh[begun] = 1.0
    if judges:
        judge_rows(
            tracks[30 * n : 31 * n], ints[n : 2 * n], tracks[29 * n : 30 * n],
            tracks[25 * n : 29 * n].reshape((n, 4)), rows, columns, missed, scores, born,
            seen[25 * m : 29 * m].reshape((m, 4)), learned, settings, one_step, existence_limits,
            right, after, fresh, learned,
        )  # fmt: skip
    return put_together(
        rows, columns, born, scores, tracks, ints, n, after, seen, m, now, off, fresh, which,
        living, next_id, floats, whole,
    )  # fmt: skip
