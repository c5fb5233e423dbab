"""Hypotheses of cars after their boxes: the extended Kalman filter's update, edge by edge."""

from math import inf, log, sqrt

import numpy as np

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
    OUT2,
    OUT3,
    OUT4,
    inlined,
    inlined_with_arrays,
    kernel,
)  # fmt: skip


@inlined
def is_censored(which, edge, expected, far, border):
    """Whether the image's border may have cut an edge: the car is expected to go on beyond."""
    if which < 2:
        return edge < border and (expected - edge) * -1.0 > 0.0
    return far - edge < border and expected - edge > 0.0


@inlined
def shifted_by(H, edge):
    """What an edge takes of a state: of all but speed and yaw rate, which shift none."""
    by_place = H[edge, 0], H[edge, 1], H[edge, 2], H[edge, 3]
    return *by_place, H[edge, 5], H[edge, 6], H[edge, 7]


@inlined
def product(a, b):
    """The sum of the products of seven numbers, in their order."""
    by_place = a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3]
    return by_place + a[4] * b[4] + a[5] * b[5] + a[6] * b[6]


@inlined
def put_by_state(H, cov, count, by_state):
    """Covariances of edges with the state, (36,): H P.

    One loop over flat arrays, whose end the compiler does not know, is one that it works off
    several columns at a time.
    """
    left, top, right, bottom = (
        shifted_by(H, 0), shifted_by(H, 1), shifted_by(H, 2), shifted_by(H, 3)
    )  # fmt: skip
    for at in range(count):
        by_place = cov[at], cov[9 + at], cov[18 + at], cov[27 + at]
        column = *by_place, cov[45 + at], cov[54 + at], cov[63 + at]
        by_state[at], by_state[9 + at] = product(left, column), product(top, column)
        by_state[18 + at], by_state[27 + at] = product(right, column), product(bottom, column)


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
                by_state[9 * later + column] -= gain * by_state[9 * edge + column]
            for column in range(later, 4):
                by_edge[later, column] -= gain * by_edge[edge, column]
        square = weights[edge] * bounded[edge] ** 2
        fit += tightness * log(var) + square
        misfit += square
    return -0.5 * fit, misfit


@inlined
def subtract_gains(cov, gains, by_state, count, cov_out):
    """The covariance (81,) less what the edges told, one after the other. gains: (36,)."""
    for at in range(count):
        one, two, three, four = by_state[at], by_state[9 + at], by_state[18 + at], by_state[27 + at]
        for row in range(9):
            left = cov[9 * row + at] - gains[4 * row] * one - gains[4 * row + 1] * two
            cov_out[9 * row + at] = left - gains[4 * row + 2] * three - gains[4 * row + 3] * four


@inlined
def update_car(mean, cov, H, off, told, variances, scratch, limits, mean_out, cov_out):
    """A hypothesis after its box; what the box counts for, and its squared deviation.

    cov: (81,). scratch: covariances of edges with the state and with later edges, weights, bounded
    deviations, gains.
    """
    by_state, by_edge, weights, bounded, gains = scratch
    put_by_state(H, cov, len(mean), by_state)
    for edge in range(4):
        for other in range(edge, 4):
            total = 0.0
            for column in range(8):
                total += by_state[9 * edge + column] * H[other, column]
            by_edge[edge, other] = total
    fit, misfit = weigh_edges(
        off, variances, told, by_state, by_edge, weights, bounded, limits[1], limits[2]
    )
    for row in range(9):
        corrected = mean[row]
        for edge in range(4):
            gains[4 * row + edge] = weights[edge] * by_state[9 * edge + row]
            corrected += weights[edge] * bounded[edge] * by_state[9 * edge + row]
        mean_out[row] = corrected
    subtract_gains(cov, gains, by_state, len(mean), cov_out)
    return fit, misfit


@inlined_with_arrays
def room_for_update():
    """Arrays that `update_hypothesis` writes to, made once for many hypotheses."""
    of_edges = np.empty(36), np.empty((4, 4)), np.empty(4), np.empty(4), np.empty(36)
    return np.empty(4), np.empty(4), np.empty(4), np.empty((4, 9)), np.empty((8, 3)), of_edges


@inlined
def update_hypothesis(
    mean, cov, at, is_linear_given, seen, lens, limits, scratch, mean_out, cov_out
):  # fmt: skip
    """A hypothesis after its box, linearised at `at`; it may be written where it is read.

    cov: (81,).
    """
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


@inlined
def update_in_room(
    means, covs, log_weights, min_log_weight, linear, is_linear_given, boxes, variances, P, signs,
    edges, far, limits, means_out, covs_out, fits, misfits, room,
):  # fmt: skip
    """What `update_cars` does."""
    lens, flat = (P, signs, edges, far), (len(means), means.shape[1], 81)
    covs, covs_out = covs.reshape(flat), covs_out.reshape(flat)
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
