"""The steps of the car filter in a frame, each by the kernels of its parts."""

from math import inf

import numpy as np

from tracker.kernels.car_boxes import carry_boxes
from tracker.kernels.car_hypotheses import (
    believe_heights,
    estimate_cars,
    state_covariances,
    weigh_cars,
    weigh_directions,
)
from tracker.kernels.car_motion import moved
from tracker.kernels.car_scene import (
    hide_edges,
    place_bases,
    sum_flatness,
    sum_slopes,
    weigh_edges_of_boxes,
)
from tracker.kernels.car_update import update_cars
from tracker.kernels.compiling import (
    A1,
    A2,
    F1,
    F2,
    F3,
    F4,
    FLOAT,
    I1,
    I2,
    OUT1,
    OUT2,
    OUT3,
    OUT4,
    OUT_B2,
    OUT_I2,
    kernel,
)


@kernel(
    A2, A1, A2, FLOAT, F1, FLOAT, F1, F1, FLOAT, FLOAT, F2, F1, FLOAT, F1, FLOAT, FLOAT, F3, F2,
    FLOAT, FLOAT, F1, F1, OUT_B2, OUT2, OUT2,
)  # fmt: skip
def see_cars(
    boxes, scores, others, min_lower, least_share, margin_share, bias, hidden_factors, edge_std,
    pixel_std, per_pixel, at_origin, focal, far, min_gap, min_score, means, log_weights,
    camera_height, mean_height, of_slopes, of_flatness, hidden, unbiased, variances,
):  # fmt: skip
    """`hide_edges`, `weigh_edges_of_boxes`, and what cars (n, k, 9) tell of the road.

    Gives `sum_slopes` and `sum_flatness`; of_slopes, of_flatness: the noise in their order.
    """
    n = len(boxes)
    fall, reach, heights, is_usable = np.empty(n), np.empty(n), np.empty(n), np.empty(n, np.bool_)
    hide_edges(boxes, others, min_lower, least_share, margin_share, hidden)
    weigh_edges_of_boxes(
        boxes, scores, hidden, bias, hidden_factors, edge_std, pixel_std, unbiased, variances
    )
    place_bases(
        unbiased, scores, hidden, per_pixel, at_origin, focal, far, min_gap, min_score, fall,
        reach, is_usable,
    )  # fmt: skip
    believe_heights(means, log_weights, heights)
    information, weighted = sum_slopes(
        fall, reach, is_usable, camera_height, heights, of_slopes[0], of_slopes[1], of_slopes[2],
        of_slopes[3],
    )  # fmt: skip
    told = sum_flatness(
        fall, reach, is_usable, camera_height, mean_height, of_flatness[0], of_flatness[1],
        of_flatness[2], of_flatness[3],
    )  # fmt: skip
    return information, weighted, told


@kernel(
    F3, F4, F2, FLOAT, A2, F2, F2, F2, I2, F1, F1, F2, FLOAT, FLOAT, F1, FLOAT, OUT3, OUT4, OUT2,
    OUT_I2, OUT1,
)  # fmt: skip
def fit_cars(
    means, covs, log_weights, min_log_weight, boxes, variances, P, signs, edges, far, limits, told,
    evidence, begin, switching, starting_var, means_out, covs_out, weights_out, parents, misfits,
):  # fmt: skip
    """Cars after their boxes, weights included: `update_cars` and `weigh_cars`.

    misfits: of each car the smallest of its hypotheses.
    """
    fits, off = np.empty(log_weights.shape), np.empty(log_weights.shape)
    update_cars(
        means, covs, log_weights, min_log_weight, means, False, boxes, variances, P, signs, edges,
        far, limits, means_out, covs_out, fits, off,
    )  # fmt: skip
    weigh_cars(
        means_out, covs_out, log_weights, min_log_weight, fits, told, evidence, begin, switching,
        starting_var, weights_out, parents,
    )  # fmt: skip
    for car in range(len(means)):
        misfits[car] = inf
        for which in range(means.shape[1]):
            misfits[car] = min(misfits[car], off[car, which])


@kernel(
    F3, F4, F2, F3, F2, F1, F1, FLOAT, FLOAT, FLOAT, FLOAT, FLOAT, FLOAT, FLOAT, F2, OUT2, OUT3,
    OUT1,
)  # fmt: skip
def state_cars(
    means, covs, log_weights, shares, traffic, borders, middle, concentration, prior, cos_same,
    min_weight, factor, yaw_std, speed_std, own, means_out, covs_out, known,
):  # fmt: skip
    """One state per car as rows state it: `weigh_directions`, `estimate_cars` and the rest."""
    weights, cov = np.empty(log_weights.shape), np.empty(covs_out.shape)
    weigh_directions(
        means, log_weights, shares, traffic, borders, middle, concentration, prior, weights
    )
    estimate_cars(means, covs, weights, cos_same, min_weight, means_out, cov, known)
    state_covariances(means_out, cov, factor, yaw_std, speed_std, own, covs_out)


@kernel(
    A2, A2, I1, F2, F2, F1, F1, F1, F2, FLOAT, F2, I2, FLOAT, OUT2
)  # fmt: skip
def expect_boxes(
    boxes, predicted, hits, states, T_road, step, rates, log_size, P, far_x, signs, edges,
    max_growth, expected,
):  # fmt: skip
    """`carry_boxes` of cars in these states after a step; `predicted` of those of a single hit."""
    later = np.empty(states.shape)
    moved(states, T_road, step, rates, log_size, later)
    carry_boxes(boxes, states, later, P, far_x, signs, edges, max_growth, expected)
    for car in range(len(boxes)):
        if hits[car] <= 1:
            for side in range(4):
                expected[car, side] = predicted[car, side]
