"""The steps of many drives at once: each row with what its own drive knows.

`drive` gives the drive of every row, `starts` (one more than there are drives) where the rows of
each begin, `places` where the cars of rows lie in the arrays of all cars, which are written where
they are read. The numbers are those that the kernels of one drive give.
"""

from math import inf

import numpy as np

from tracker.kernels.box_gains import filter_boxes
from tracker.kernels.car_boxes import carry_in_room, room_to_carry
from tracker.kernels.car_hypotheses import (
    believe_heights,
    estimate_in_room,
    room_to_estimate,
    state_covariances,
    watch_traffic,
    weigh_cars,
    weigh_directions,
)
from tracker.kernels.car_motion import (
    kept_in,
    moved,
    predict_hypothesis,
    room_to_predict,
)
from tracker.kernels.car_scene import hide_edges, sum_flatness, sum_slopes
from tracker.kernels.car_update import room_for_update, update_hypothesis
from tracker.kernels.compiling import (
    B1,
    F1,
    F2,
    F3,
    FLOAT,
    I1,
    I2,
    OUT1,
    OUT2,
    OUT3,
    OUT4,
    OUT_B2,
    inlined,
    kernel,
)
from tracker.kernels.lifting import carry_beliefs


@kernel(
    F2, F2, F2, F3, F2, F2, I1, F3, F2, F3, F1, F3, F2, F3, F1, OUT2, OUT2, OUT3, OUT2
)  # fmt: skip
def carry_each(
    base, size, velocity, covs, boxes, shift, starts, T_road, road_shift, motion_cov, depth_of,
    H, pixels, by_moved, limits, base_now, velocity_now, covs_now, boxes_now,
):  # fmt: skip
    """`carry_beliefs` of every drive; T_road, motion_cov, H, pixels, by_moved: one per drive."""
    for drive in range(len(starts) - 1):
        a, b = starts[drive], starts[drive + 1]
        carry_beliefs(
            base[a:b], size[a:b], velocity[a:b], covs[a:b], boxes[a:b], shift[a:b], T_road[drive],
            road_shift, motion_cov[drive], depth_of, H[drive], pixels[drive], by_moved[drive],
            limits, base_now[a:b], velocity_now[a:b], covs_now[a:b], boxes_now[a:b],
        )  # fmt: skip


PREDICT = OUT3, OUT4, F2, FLOAT, I1, I1, F3, F2, F1, F1, F2, F1, F2, F2, F3


@inlined
def predict_each_in_room(
    means, covs, log_weights, min_log_weight, places, drives, T_road, steps, rates, noise,
    off_road, log_size, log_size_cov, place_shift, motion_cov, room,
):  # fmt: skip
    """What `predict_each` does."""
    half, covs = means.shape[1] // 2, covs.reshape(len(means), means.shape[1], 81)
    for row in range(len(places)):
        car, drive = places[row], drives[row]
        step = steps[drive]
        kept, ego = kept_in(step[1], rates), (place_shift, motion_cov[drive])
        shared = T_road[drive], step, rates, kept, noise, off_road[drive], log_size, log_size_cov
        for which in range(means.shape[1]):
            if log_weights[car, which] > min_log_weight:
                mean, cov = means[car, which], covs[car, which]
                predict_hypothesis(mean, cov, which >= half, shared, ego, room, mean, cov)


@kernel(*PREDICT)
def predict_each(
    means, covs, log_weights, min_log_weight, places, drives, T_road, steps, rates, noise,
    off_road, log_size, log_size_cov, place_shift, motion_cov,
):  # fmt: skip
    """`predict_cars` of rows; T_road, steps, off_road, motion_cov: one per drive."""
    predict_each_in_room(
        means, covs, log_weights, min_log_weight, places, drives, T_road, steps, rates, noise,
        off_road, log_size, log_size_cov, place_shift, motion_cov, room_to_predict(),
    )  # fmt: skip


CARRY = F2, F2, I1, F3, F2, F1, F1, F2, FLOAT, F2, I2, FLOAT, OUT2


@inlined
def carry_boxes_each_in_room(
    boxes, states, drives, T_road, steps, rates, log_size, P, far_x, signs, edges, max_growth,
    carried, later, room,
):  # fmt: skip
    """What `carry_boxes_each` does."""
    for row in range(len(boxes)):
        one, drive = slice(row, row + 1), drives[row]
        moved(states[one], T_road[drive], steps[drive], rates, log_size, later)
        carry_in_room(
            boxes[one], states[one], later, P, far_x, signs, edges, max_growth, carried[one], room
        )


@kernel(*CARRY)
def carry_boxes_each(
    boxes, states, drives, T_road, steps, rates, log_size, P, far_x, signs, edges, max_growth,
    carried,
):  # fmt: skip
    """Boxes (n, 4) of cars in these states (n, 9) after the step of their drive."""
    carry_boxes_each_in_room(
        boxes, states, drives, T_road, steps, rates, log_size, P, far_x, signs, edges, max_growth,
        carried, np.empty((1, 9)), room_to_carry(),
    )  # fmt: skip


@kernel(
    OUT3, OUT3, OUT3, F1, F2, F2, I1, F1, F2, I1, F1, F1, FLOAT, FLOAT, F1, OUT2, OUT2
)  # fmt: skip
def filter_boxes_each(
    gains, pairs, power, sizes, expected, boxes, hits, since, before, starts, dt, far, border,
    prior, limits, filtered, innovations,
):  # fmt: skip
    """`filter_boxes` of every drive that has rows; gains, pairs, power: of drives, renewed."""
    after = np.empty((3, 4)), np.empty((3, 1)), np.empty((3, 4))
    for drive in range(len(starts) - 1):
        a, b = starts[drive], starts[drive + 1]
        if b > a:
            filter_boxes(
                gains[drive], pairs[drive], power[drive], sizes, expected[a:b], boxes[a:b],
                hits[a:b], since[a:b], before[a:b], dt[drive], far, border, prior, limits,
                filtered[a:b], innovations[a:b], after[0], after[1], after[2],
            )  # fmt: skip
            gains[drive], pairs[drive], power[drive] = after[0], after[1], after[2]


@kernel(F2, F2, I1, I1, FLOAT, F1, FLOAT, OUT_B2)
def hide_each(boxes, others, starts, other_starts, min_lower, least_share, margin_share, hidden):
    """`hide_edges` of every drive."""
    for drive in range(len(starts) - 1):
        a, b = starts[drive], starts[drive + 1]
        beside = others[other_starts[drive] : other_starts[drive + 1]]
        hide_edges(boxes[a:b], beside, min_lower, least_share, margin_share, hidden[a:b])


@kernel(F3, F2, I1, I1, F1, F1, B1, FLOAT, FLOAT, F1, F1, OUT2)
def sum_roads_each(
    means, log_weights, places, starts, fall, reach, is_usable, camera_height, mean_height,
    of_slopes, of_flatness, sums,
):  # fmt: skip
    """What the boxes of cars tell of the road of each drive: `sum_slopes` and `sum_flatness`.

    sums: (drives, 3). of_slopes, of_flatness: the noise, in the order of those kernels.
    """
    heights = np.empty(len(places))
    for row in range(len(places)):
        car = slice(places[row], places[row] + 1)
        believe_heights(means[car], log_weights[car], heights[row : row + 1])
    for drive in range(len(starts) - 1):
        a, b = starts[drive], starts[drive + 1]
        seen = fall[a:b], reach[a:b], is_usable[a:b]
        sums[drive, 0], sums[drive, 1] = sum_slopes(
            seen[0], seen[1], seen[2], camera_height, heights[a:b],
            of_slopes[0], of_slopes[1], of_slopes[2], of_slopes[3],
        )  # fmt: skip
        sums[drive, 2] = sum_flatness(
            seen[0], seen[1], seen[2], camera_height, mean_height,
            of_flatness[0], of_flatness[1], of_flatness[2], of_flatness[3],
        )  # fmt: skip


UPDATE = (
    OUT3, OUT4, OUT2, FLOAT, I1, F2, F2, F2, F2, I2, F1, F1, F2, FLOAT, FLOAT, F1, FLOAT, OUT1
)  # fmt: skip


@inlined
def update_each_in_room(
    means, covs, log_weights, min_log_weight, places, boxes, variances, P, signs, edges, far,
    limits, told, evidence, begin, switching, starting_var, misfits, before, fits, parents, room,
):  # fmt: skip
    """What `update_each` does."""
    lens, flat = (P, signs, edges, far), covs.reshape(len(means), means.shape[1], 81)
    for row in range(len(places)):
        car, seen = places[row], (boxes[row], variances[row])
        misfits[row] = inf
        for which in range(means.shape[1]):
            before[0, which], fits[0, which] = log_weights[car, which], 0.0
            if log_weights[car, which] > min_log_weight:
                mean, cov = means[car, which], flat[car, which]
                fits[0, which], misfit = update_hypothesis(
                    mean, cov, mean, False, seen, lens, limits, room, mean, cov
                )
                misfits[row] = min(misfits[row], misfit)
        one = slice(car, car + 1)
        weigh_cars(
            means[one], covs[one], before, min_log_weight, fits, told[row : row + 1], evidence,
            begin, switching, starting_var, log_weights[one], parents,
        )  # fmt: skip


@kernel(*UPDATE)
def update_each(
    means, covs, log_weights, min_log_weight, places, boxes, variances, P, signs, edges, far,
    limits, told, evidence, begin, switching, starting_var, misfits,
):  # fmt: skip
    """Cars after their boxes, weights included: `update_cars` and `weigh_cars`.

    misfits: of each row the smallest of its hypotheses.
    """
    count = means.shape[1]
    update_each_in_room(
        means, covs, log_weights, min_log_weight, places, boxes, variances, P, signs, edges, far,
        limits, told, evidence, begin, switching, starting_var, misfits, np.empty((1, count)),
        np.empty((1, count)), np.empty((1, count), np.int64), room_for_update(),
    )  # fmt: skip


@kernel(F3, F2, I1, I1, F1, FLOAT, FLOAT, F1, OUT3, allocates=False)
def watch_each(
    means, log_weights, places, drives, borders, min_speed, min_probability, dt, traffic
):
    """`watch_traffic` of rows; dt, traffic: of drives."""
    for row in range(len(places)):
        car, drive = slice(places[row], places[row] + 1), drives[row]
        watch_traffic(
            means[car], log_weights[car], borders, min_speed, min_probability, dt[drive],
            traffic[drive],
        )  # fmt: skip


ESTIMATE = (
    OUT3, OUT4, OUT2, I1, I1, F3, F3, F1, F1, FLOAT, FLOAT, FLOAT, FLOAT, F1, F3, OUT2, OUT3, OUT1
)  # fmt: skip


@inlined
def estimate_each_in_room(
    means, covs, log_weights, places, drives, shares, traffic, borders, middle, concentration,
    prior, cos_same, min_weight, stating, own, means_out, covs_out, known, weights, cov, room,
):  # fmt: skip
    """What `estimate_each` does."""
    for row in range(len(places)):
        one, car, drive = slice(row, row + 1), slice(places[row], places[row] + 1), drives[row]
        weigh_directions(
            means[car], log_weights[car], shares, traffic[drive], borders, middle, concentration,
            prior, weights,
        )  # fmt: skip
        estimate_in_room(
            means[car], covs[car], weights, cos_same, min_weight, means_out[one], cov, known[one],
            room,
        )  # fmt: skip
        state_covariances(
            means_out[one], cov, stating[0], stating[1], stating[2], own[drive], covs_out[one]
        )


@kernel(*ESTIMATE)
def estimate_each(
    means, covs, log_weights, places, drives, shares, traffic, borders, middle, concentration,
    prior, cos_same, min_weight, stating, own, means_out, covs_out, known,
):  # fmt: skip
    """One state per row, with the covariance that rows state: `estimate_cars` and its neighbours.

    traffic, own: of drives. stating: factor, std of yaws, of speeds.
    """
    count = means.shape[1]
    estimate_each_in_room(
        means, covs, log_weights, places, drives, shares, traffic, borders, middle, concentration,
        prior, cos_same, min_weight, stating, own, means_out, covs_out, known,
        np.empty((1, count)), np.empty((1, 9, 9)), room_to_estimate(count),
    )  # fmt: skip
