"""The tracks after a frame: those detected in it, those that live on without, those that begin."""

from math import nan

import numpy as np

from tracker.kernels.box_gains import filter_boxes
from tracker.kernels.compiling import (
    A1,
    A2,
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
from tracker.kernels.tables import belief_columns, moment_columns

BELIEFS = A2, A1, A2, A2, F3, A2


@inlined
def copy_numbers(numbers, out):
    """The same numbers."""
    for column in range(len(out)):
        out[column] = numbers[column]


@inlined
def copy_belief(beliefs, row, out, at):
    """The same place, yaw, size, velocity, covariance and box in another table."""
    base, yaw, size, velocity, cov, boxes = beliefs
    out_base, out_yaw, out_size, out_velocity, out_cov, out_boxes = out
    out_yaw[at] = yaw[row]
    copy_numbers(base[row], out_base[at])
    copy_numbers(size[row], out_size[at])
    copy_numbers(velocity[row], out_velocity[at])
    copy_numbers(boxes[row], out_boxes[at])
    for line in range(4):
        for column in range(4):
            out_cov[at, line, column] = cov[row, line, column]


@inlined
def is_alive(place, box, since, view, max_gap):
    """Whether a track that was not detected lives on: not too long unseen, and in view."""
    return since <= max_gap and is_in_view(place, box, view[0], view[1], view[2])


@inlined
def put_together(rows, columns, born, scores, old, updated, seen, of_life, floats, whole):
    """The tracks after a frame, packed, and where they come from; how many there are.

    They keep their order, or have that of `rows` where all were detected. rows, columns: of those
    detected, by which detection; updated: what they are then, and their innovations, in that
    order. old: the tracks before, others that live on stay as they are; existence: after the
    frame. born: detections (`seen`) that begin tracks. places, the last third of `whole`: where a
    row comes from, counted through the tracks before, the detected ones and the detections.
    """
    before, since, hits, ids, old_innovations, existence, fresh = old
    now, innovations = updated
    next_id, max_gap, view = of_life
    base, boxes = before[0], before[5]
    n, k, count = len(ids), len(rows), len(rows) + len(born)
    which = np.full(n, -1)
    for at in range(k):
        which[rows[at]] = at
    for row in range(n):
        if which[row] < 0 and is_alive(base[row], boxes[row], since[row], view, max_gap):
            count += 1
    out, last = belief_columns(floats, count), moment_columns(floats, count)
    out_since, out_existence, out_innovations, out_scores = last
    out_ids, out_hits, places = whole[:count], whole[count : 2 * count], whole[2 * count :]
    at = 0
    for turn in range(n):
        row = rows[turn] if k == n else turn
        detected = which[row]
        if detected >= 0:
            copy_belief(now, detected, out, at)
            copy_numbers(innovations[detected], out_innovations[at])
            out_since[at], out_hits[at] = 0.0, hits[row] + 1
            out_scores[at], places[at] = scores[columns[detected]], n + detected
        elif is_alive(base[row], boxes[row], since[row], view, max_gap):
            copy_belief(before, row, out, at)
            copy_numbers(old_innovations[row], out_innovations[at])
            out_since[at], out_hits[at] = since[row], hits[row]
            out_scores[at], places[at] = nan, row
        else:
            continue
        out_ids[at], out_existence[at] = ids[row], existence[row]
        at += 1
    for begun in range(len(born)):
        copy_belief(seen, born[begun], out, at)
        for side in range(4):
            out_innovations[at, side] = nan
        out_since[at], out_hits[at] = 0.0, 1
        out_scores[at], out_existence[at] = scores[born[begun]], fresh[begun]
        out_ids[at], places[at] = next_id + begun, n + k + born[begun]
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


@inlined
def gathered(beliefs, rows):
    """These rows of the columns of beliefs, in arrays of their own."""
    k = len(rows)
    out = (
        np.empty((k, 3)), np.empty(k), np.empty((k, 3)), np.empty((k, 2)), np.empty((k, 4, 4)),
        np.empty((k, 4)),
    )  # fmt: skip
    for at in range(k):
        copy_belief(beliefs, rows[at], out, at)
    return out


@kernel(
    A_I1, A_I1, A_I1, A_I1, A1, F1, I1, INT, *BELIEFS, BOOL, BOOL, BOOL, INT, INT, INT, INT, F1,
    FLOAT, FLOAT, F1, FLOAT, F2, F2, F2, F1, FLOAT, FLOAT, F1, INT, FLOAT, A1, F1, FLOAT, OUT1,
    OUT_I1, OUT1,
)  # fmt: skip
def step_tracks(
    rows, columns, missed, born, scores, floats, ints, n, seen_base, seen_yaw, seen_size,
    seen_velocity, seen_cov, seen_boxes, moves, judges, filters, hit, tries, confirmed, newborns,
    settings, dt, one_step, existence_limits, right, gains, pairs, power, sizes, border, prior,
    gain_limits, next_id, max_gap, depth_of, far, min_depth, floats_now, ints_now, learned_gains,
):  # fmt: skip
    """The tracks after a frame, packed, by the kernels of its parts; how many there are.

    moves: whether a Kalman filter corrects places (`correct_places`), else detections are taken as
    they are; judges: `judge_rows`; filters: `filter_boxes`. hit, tries, confirmed, newborns: what
    is known of the detector. ints_now: `put_together`, at last what is known of the detector then.
    learned_gains: gains, power and pairs, one after the other. The rest as these have it.
    """
    k = len(rows)
    before = belief_columns(floats, n)
    since, existence, innovations, _ = moment_columns(floats, n)
    ids, hits = ints[:n], ints[n : 2 * n]
    seen = seen_base, seen_yaw, seen_size, seen_velocity, seen_cov, seen_boxes
    now, old = gathered(seen, columns), gathered(before, rows)
    if moves:
        place, observed_cov = now[0].copy(), now[4].copy()
        correct_places(old[0], old[3], old[4], place, observed_cov, now[0], now[3], now[4])
    off = np.empty((k, 4))
    old_hits, old_since, old_off = np.empty(k, np.int64), np.empty(k), np.empty((k, 4))
    for at in range(k):
        old_hits[at], old_since[at] = hits[rows[at]], since[rows[at]]
        copy_numbers(innovations[rows[at]], old_off[at])
        copy_numbers(old_off[at], off[at])
    if filters:
        new_gains, new_power = learned_gains[:12].reshape((3, 4)), learned_gains[12:24]
        new_pairs = learned_gains[24:].reshape((3, 1))
        if k:
            observed_boxes = now[5].copy()
            filter_boxes(
                gains, pairs, power, sizes, old[5], observed_boxes, old_hits, old_since, old_off,
                dt, far, border, prior, gain_limits, now[5], off, new_gains, new_pairs,
                new_power.reshape((3, 4)),
            )  # fmt: skip
        else:
            new_gains[:], new_pairs[:], new_power[:] = gains, pairs, power.reshape(12)
    detector, learned = np.array((hit, tries, confirmed, newborns)), ints_now[-4:]
    after, fresh = np.ones(n), np.ones(len(born))
    if judges:
        judge_rows(
            existence, hits, since, before[5], rows, columns, missed, scores, born, seen_boxes,
            detector, settings, one_step, existence_limits, right, after, fresh, learned,
        )  # fmt: skip
    else:
        learned[:] = detector
        for at in range(len(missed)):
            after[missed[at]] = existence[missed[at]]
    tracks = before, since, hits, ids, innovations, after, fresh
    of_life = next_id, max_gap, (depth_of, far, min_depth)
    return put_together(
        rows, columns, born, scores, tracks, (now, off), seen, of_life, floats_now, ints_now
    )
