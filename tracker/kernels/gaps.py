"""What tells whether the predicted boxes of undetected cars are right."""

from math import log, sqrt

import numpy as np

from tracker.kernels.car_boxes import put_box
from tracker.kernels.compiling import A2, F1, F2, F3, FLOAT, I1, I2, OUT1, OUT2, inlined, kernel


@inlined
def covariance_of(a, b, cov):
    """The covariance of two numbers with these derivatives by a state."""
    total = 0.0
    for row in range(9):
        along = 0.0
        for column in range(9):
            along += cov[row, column] * b[column]
        total += a[row] * along
    return total


@inlined
def within(number, low, high):
    """The number, or the nearer limit."""
    return min(max(number, low), high)


@kernel(A2, F1, I1, F2, F3, F2, F1, F2, I2, F2, FLOAT, FLOAT, OUT2)
def tell_gaps(
    boxes, existence, hits, means, covs, P, far, signs, edges, limits, min_std, margin, features
):
    """Features (n, 6) of undetected cars, see `gap_features`.

    limits: of logits, of logarithms of hits and of heights. margin: of the border, px.
    """
    pixels, projected, jacobian = np.empty((8, 3)), np.empty(4), np.empty((4, 9))
    for car in range(len(boxes)):
        left, right = within(boxes[car, 0], 0.0, far[0]), within(boxes[car, 2], 0.0, far[0])
        top, bottom = within(boxes[car, 1], 0.0, far[1]), within(boxes[car, 3], 0.0, far[1])
        across, height = max(right - left, 1.0), max(bottom - top, 1.0)
        put_box(means[car], P, far[0], signs, edges, pixels, projected, jacobian, True)
        var_left = covariance_of(jacobian[0], jacobian[0], covs[car])
        var_right = covariance_of(jacobian[2], jacobian[2], covs[car])
        shared = covariance_of(jacobian[0], jacobian[2], covs[car])
        place = 0.5 * (sqrt(var_left) + sqrt(var_right)) / across
        width = sqrt(max(var_left + var_right - 2.0 * shared, 0.0)) / across
        logit = log(existence[car] / (1.0 - existence[car]))
        features[car, 0] = within(logit, limits[0, 0], limits[0, 1])
        features[car, 1] = within(log(hits[car]), limits[1, 0], limits[1, 1])
        features[car, 2], features[car, 3] = log(place + min_std), log(width + min_std)
        features[car, 4] = within(log(height), limits[2, 0], limits[2, 1])
        features[car, 5] = 1.0 if min(left, far[0] - right) < margin else 0.0


@kernel(F2, F1, OUT1, allocates=False)
def weigh_gaps(features, weights, logits):
    """Logits: the first weight, then features (n, 6) times the others, in the same order for each.

    (A product of matrices adds up in an order of its own for each number of rows.)
    """
    for car in range(len(features)):
        total = 0.0
        for column in range(features.shape[1]):
            total += features[car, column] * weights[column + 1]
        logits[car] = weights[0] + total
