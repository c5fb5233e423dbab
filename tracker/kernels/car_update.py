"""Hypotheses of cars after their boxes: the extended Kalman filter's update, edge by edge."""

from math import log, sqrt

import numpy as np

from tracker.kernels.compiling import BOOL, F1, F2, F3, FLOAT, OUT1, OUT2, OUT3, inlined, kernel


@inlined
def add_scaled(out, factor, row):
    """Add a row times a factor."""
    for column in range(len(out)):
        out[column] += factor * row[column]


@inlined
def dot(a, b):
    """The scalar product."""
    total = 0.0
    for column in range(len(a)):
        total += a[column] * b[column]
    return total


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
            add_scaled(by_state[later], -gain, by_state[edge])
            for column in range(edge + 1, 4):
                by_edge[later, column] -= gain * by_edge[edge, column]
        square = weights[edge] * bounded[edge] ** 2
        fit += tightness * log(var) + square
        misfit += square
    return -0.5 * fit, misfit


@kernel(F2, F3, F2, F2, F2, F3, F2, BOOL, F1, FLOAT, FLOAT, FLOAT, OUT2, OUT3, OUT1, OUT1)
def update_cars(
    means, covs, boxes, variances, expected, jacobians, linear, is_linear_given, far,
    border, max_deviation, tightness, means_out, covs_out, fit, misfit,
):  # fmt: skip
    """States (h, 9), covariances, log-likelihoods and squared deviations after boxes (h, 4).

    expected, jacobians: the boxes of the states in `linear`, where it is given, else of `means`.
    """
    off, told, weights, bounded = np.empty(4), np.empty(4), np.empty(4), np.empty(4)
    by_state, by_edge = np.empty((4, 9)), np.empty((4, 4))
    for car in range(len(means)):
        mean, cov, H = means[car], covs[car], jacobians[car]
        for edge in range(4):
            off[edge] = boxes[car, edge] - expected[car, edge]
            if is_linear_given:
                for column in range(9):
                    off[edge] -= H[edge, column] * (mean[column] - linear[car, column])
            cut = is_censored(edge, boxes[car, edge], expected[car, edge], far[edge], border)
            told[edge] = 0.0 if cut else 1.0
            by_state[edge] = 0.0
            for row in range(9):
                add_scaled(by_state[edge], H[edge, row], cov[row])
            for other in range(4):
                by_edge[edge, other] = dot(by_state[edge], H[other])
        fit[car], misfit[car] = weigh_edges(
            off, variances[car], told, by_state, by_edge, weights, bounded, max_deviation, tightness
        )
        for row in range(9):
            means_out[car, row] = mean[row]
            for column in range(9):
                covs_out[car, row, column] = cov[row, column]
        for edge in range(4):
            add_scaled(means_out[car], weights[edge] * bounded[edge], by_state[edge])
            for row in range(9):
                gain = weights[edge] * by_state[edge, row]
                add_scaled(covs_out[car, row], -gain, by_state[edge])
