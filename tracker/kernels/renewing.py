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

BELIEFS = A2, A1, A2, A2, F3, A2
OUT_BELIEFS = OUT2, OUT1, OUT2, OUT2, OUT3, OUT2


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
def renew_tracks(
    rows, columns, born, scores, ids, base, yaw, size, velocity, cov, boxes, since, hits,
    existence, old_innovations, new_base, new_yaw, new_size, new_velocity, new_cov, new_boxes,
    innovations, seen_base, seen_yaw, seen_size, seen_velocity, seen_cov, seen_boxes, fresh,
    next_id, max_gap, depth_of, far, min_depth, out_ids, out_base, out_yaw, out_size,
    out_velocity, out_cov, out_boxes, out_since, out_hits, out_existence, out_innovations,
    out_scores, places,
):  # fmt: skip
    """The tracks after a frame, see `renewed`; how many there are.

    They keep their order, or have that of `rows` where all were detected. rows, columns: of those
    detected, by which detection; what they are then is given in `new_...` and `innovations`, in
    that order. Others that live on stay as they are. born: detections (`seen_...`) that begin
    tracks. existence: after the frame. places: where a row comes from, counted through the tracks
    before, the detected ones and the detections.
    """
    n, k, count = len(ids), len(rows), 0
    before = base, yaw, size, velocity, cov, boxes
    updated = new_base, new_yaw, new_size, new_velocity, new_cov, new_boxes
    seen = seen_base, seen_yaw, seen_size, seen_velocity, seen_cov, seen_boxes
    out = out_base, out_yaw, out_size, out_velocity, out_cov, out_boxes
    for row in range(n):
        places[row] = row
    for at in range(k):
        places[rows[at]] = n + at
    for at in range(n):
        row = rows[at] if k == n else at
        place = n + at if k == n else places[row]
        if place >= n:
            which = place - n
            copy_belief(updated, which, out, count)
            copy_numbers(innovations[which], out_innovations[count])
            out_since[count], out_hits[count] = 0.0, hits[row] + 1
            out_scores[count] = scores[columns[which]]
        elif since[row] <= max_gap and is_in_view(base[row], boxes[row], depth_of, far, min_depth):
            copy_belief(before, row, out, count)
            copy_numbers(old_innovations[row], out_innovations[count])
            out_since[count], out_hits[count], out_scores[count] = since[row], hits[row], nan
        else:
            continue
        out_ids[count], out_existence[count], places[count] = ids[row], existence[row], place
        count += 1
    for at in range(len(born)):
        copy_belief(seen, born[at], out, count)
        for side in range(4):
            out_innovations[count, side] = nan
        out_since[count], out_hits[count] = 0.0, 1
        out_scores[count], out_existence[count] = scores[born[at]], fresh[at]
        out_ids[count], places[count] = next_id + at, n + k + born[at]
        count += 1
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
    A_I1, A_I1, A_I1, A_I1, A1, A_I1, *BELIEFS[:5], F2, F1, I1, F1, F2, *BELIEFS, BOOL, BOOL, BOOL,
    I1, F1, FLOAT, FLOAT, F1, FLOAT, F2, F2, F2, F1, FLOAT, FLOAT, F1, INT, FLOAT, A1, F1, FLOAT,
    OUT_I1, *OUT_BELIEFS, OUT1, OUT_I1, OUT1, OUT2, OUT1, OUT_I1, OUT_I1, OUT2, OUT2, OUT2,
)  # fmt: skip
def step_tracks(
    rows, columns, missed, born, scores, ids, base, yaw, size, velocity, cov, boxes, since, hits,
    existence, innovations, seen_base, seen_yaw, seen_size, seen_velocity, seen_cov, seen_boxes,
    moves, judges, filters, detector, settings, dt, one_step, existence_limits, right, gains,
    pairs, power, sizes, border, prior, gain_limits, next_id, max_gap, depth_of, far, min_depth,
    out_ids, out_base, out_yaw, out_size, out_velocity, out_cov, out_boxes, out_since, out_hits,
    out_existence, out_innovations, out_scores, places, learned, new_gains, new_pairs, new_power,
):  # fmt: skip
    """The tracks after a frame, by the kernels of its parts; how many there are.

    moves: whether a Kalman filter corrects places (`correct_places`), else detections are taken as
    they are; judges: `judge_rows`; filters: `filter_boxes`. The rest as these have it, and
    `renew_tracks`.
    """
    k = len(rows)
    seen = seen_base, seen_yaw, seen_size, seen_velocity, seen_cov, seen_boxes
    now = gathered(seen, columns)
    old = gathered((base, yaw, size, velocity, cov, boxes), rows)
    if moves:
        place, observed_cov = now[0].copy(), now[4].copy()
        correct_places(old[0], old[3], old[4], place, observed_cov, now[0], now[3], now[4])
    off, mixed = np.empty((k, 4)), np.empty((k, 4))
    old_hits, old_since, old_off = np.empty(k, np.int64), np.empty(k), np.empty((k, 4))
    for at in range(k):
        old_hits[at], old_since[at] = hits[rows[at]], since[rows[at]]
        copy_numbers(innovations[rows[at]], old_off[at])
    if filters:
        if k:
            filter_boxes(
                gains, pairs, power, sizes, old[5], now[5], old_hits, old_since, old_off, dt, far,
                border, prior, gain_limits, mixed, off, new_gains, new_pairs, new_power,
            )  # fmt: skip
        else:
            new_gains[:], new_pairs[:], new_power[:] = gains, pairs, power
    else:
        mixed[:], off[:] = now[5], old_off
    after, fresh = np.ones(len(ids)), np.ones(len(born))
    if judges:
        judge_rows(
            existence, hits, since, boxes, rows, columns, missed, scores, born, seen_boxes,
            detector, settings, one_step, existence_limits, right, after, fresh, learned,
        )  # fmt: skip
    else:
        learned[:] = detector
        for at in range(len(missed)):
            after[missed[at]] = existence[missed[at]]
    return renew_tracks(
        rows, columns, born, scores, ids, base, yaw, size, velocity, cov, boxes, since, hits, after,
        innovations, now[0], now[1], now[2], now[3], now[4], mixed, off, seen_base, seen_yaw,
        seen_size, seen_velocity, seen_cov, seen_boxes, fresh, next_id, max_gap, depth_of, far,
        min_depth, out_ids, out_base, out_yaw, out_size, out_velocity, out_cov, out_boxes,
        out_since, out_hits, out_existence, out_innovations, out_scores, places,
    )  # fmt: skip
