"""Hypotheses of cars after their boxes: the extended Kalman filter's update, edge by edge."""

from math import inf, log, sqrt

import numpy as np
from numba.types import Tuple

from tracker.kernels.car_boxes import put_box
from tracker.kernels.car_motion import copy_hypothesis
from tracker.kernels.compiling import (
    A2,
    BOOL,
    F1,
    F2,
    F3,
    F4,
    FLOAT,
    I2,
    OUT1,
    OUT2,
    OUT3,
    OUT4,
    inlined,
    kernel,
)  # fmt: skip

ROOM_FOR_UPDATE = Tuple((OUT1, OUT1, OUT1, OUT2, OUT2, Tuple((OUT2, OUT2, OUT1, OUT1))))


@inlined
def is_censored(which, edge, expected, far, border):
    """Whether the image's border may have cut an edge: the car is expected to go on beyond."""
    if which < 2:
        return edge < border and (expected - edge) * -1.0 > 0.0
    return far - edge < border and expected - edge > 0.0


@inlined
def weigh_edges(
    off, variances, told, by_state, by_edge, weights, bounded, max_deviation, tightness
):
    """Edge after edge given those before; what they count for, and their squared deviations."""
    fit, misfit = 0.0, 0.0
    for edge in range(4):
        var = by_edge[edge, edge] + variances[edge]
        limit = max_deviation * sqrt(var)
        bounded[edge] = min(max(off[edge], -limit), limit)
        weights[edge] = told[edge] / var
        for later in range(edge + 1, 4):
            gain = by_edge[edge, later] * weights[edge]
            off[later] -= gain * bounded[edge]
            for column in range(9):
                by_state[later, column] -= gain * by_state[edge, column]
            for column in range(edge + 1, 4):
                by_edge[later, column] -= gain * by_edge[edge, column]
        square = weights[edge] * bounded[edge] ** 2
        fit += tightness * log(var) + square
        misfit += square
    return -0.5 * fit, misfit


@inlined
def update_car(mean, cov, H, off, told, variances, scratch, limits, mean_out, cov_out):
    """A hypothesis after its box; what the box counts for, and its squared deviation.

    scratch: covariances of edges with the state and with edges, weights, bounded deviations.
    """
    by_state, by_edge, weights, bounded = scratch
    for edge in range(4):
        for column in range(9):
            by_state[edge, column] = 0.0
        for row in range(9):
            if H[edge, row] != 0.0:  # speed and yaw rate shift no edge
                for column in range(9):
                    by_state[edge, column] += H[edge, row] * cov[row, column]
        for other in range(4):
            by_edge[edge, other] = 0.0
            for column in range(9):
                by_edge[edge, other] += by_state[edge, column] * H[other, column]
    fit, misfit = weigh_edges(
        off, variances, told, by_state, by_edge, weights, bounded, limits[1], limits[2]
    )
    for row in range(9):
        mean_out[row] = mean[row]
        for column in range(9):
            cov_out[row, column] = cov[row, column]
        for edge in range(4):
            gain = weights[edge] * by_state[edge, row]
            mean_out[row] += weights[edge] * bounded[edge] * by_state[edge, row]
            for column in range(9):
                cov_out[row, column] -= gain * by_state[edge, column]
    return fit, misfit


@inlined
def room_for_update():
    """Arrays that `update_hypothesis` writes to, made once for many hypotheses."""
    of_edges = np.empty((4, 9)), np.empty((4, 4)), np.empty(4), np.empty(4)
    return np.empty(4), np.empty(4), np.empty(4), np.empty((4, 9)), np.empty((8, 3)), of_edges


@inlined
def update_hypothesis(
    mean, cov, at, is_linear_given, seen, lens, limits, scratch, mean_out, cov_out
):  # fmt: skip
    """A hypothesis after its box, linearised at `at`; it may be written where it is read."""
    off, told, expected, H, pixels, of_edges = scratch
    P, signs, edges, far = lens
    box, variances = seen
    put_box(at, P, far[0], signs, edges, pixels, expected, H, True)
    for edge in range(4):
        off[edge] = box[edge] - expected[edge]
        if is_linear_given:
            for column in range(9):
                off[edge] -= H[edge, column] * (mean[column] - at[column])
        cut = is_censored(edge, box[edge], expected[edge], far[edge], limits[0])
        told[edge] = 0.0 if cut else 1.0
    return update_car(mean, cov, H, off, told, variances, of_edges, limits, mean_out, cov_out)


@kernel(
    F3, F4, F2, FLOAT, F3, BOOL, A2, F2, F2, F2, I2, F1, F1, OUT3, OUT4, OUT2, OUT2,
    ROOM_FOR_UPDATE, allocates=False,
)  # fmt: skip
def update_in_room(
    means, covs, log_weights, min_log_weight, linear, is_linear_given, boxes, variances, P, signs,
    edges, far, limits, means_out, covs_out, fits, misfits, room,
):  # fmt: skip
    """What `update_cars` does."""
    lens = P, signs, edges, far
    for car in range(len(means)):
        for which in range(means.shape[1]):
            mean, cov = means[car, which], covs[car, which]
            mean_out, cov_out = means_out[car, which], covs_out[car, which]
            if not log_weights[car, which] > min_log_weight:
                copy_hypothesis(mean, cov, mean_out, cov_out)
                fits[car, which], misfits[car, which] = 0.0, inf
                continue
            at = linear[car, which] if is_linear_given else mean
            seen = boxes[car], variances[car]
            fits[car, which], misfits[car, which] = update_hypothesis(
                mean, cov, at, is_linear_given, seen, lens, limits, room, mean_out, cov_out
            )


@kernel(F3, F4, F2, FLOAT, F3, BOOL, A2, F2, F2, F2, I2, F1, F1, OUT3, OUT4, OUT2, OUT2)
def update_cars(
    means, covs, log_weights, min_log_weight, linear, is_linear_given, boxes, variances, P, signs,
    edges, far, limits, means_out, covs_out, fits, misfits,
):  # fmt: skip
    """Hypotheses (n, k, 9), covariances, log-likelihoods, squared deviations after boxes (n, 4).

    The projection is linearised at `linear`, where it is given, else at `means`. Hypotheses that
    are not followed stay as they are: log-likelihood 0, deviation inf. limits: border of the
    image, px; most standard deviations; tightness.
    """
    update_in_room(
        means, covs, log_weights, min_log_weight, linear, is_linear_given, boxes, variances, P,
        signs, edges, far, limits, means_out, covs_out, fits, misfits, room_for_update(),
    )  # fmt: skip
