"""Hypotheses of cars after measured yaws and sizes."""

from math import exp, isfinite, isnan, log, pi, sqrt

from tracker.kernels.car_motion import copy_hypothesis
from tracker.kernels.compiling import (
    A1,
    A2,
    B1,
    F1,
    F2,
    F3,
    F4,
    FLOAT,
    OUT1,
    OUT2,
    OUT3,
    OUT4,
    inlined,
    kernel,
)  # fmt: skip

YAW, LOG_LENGTH = 3, 5


@inlined
def wrapped(angle):
    """The same angle in [-pi, pi)."""
    return (angle + pi) % (2.0 * pi) - pi


@inlined
def correct_column(mean, cov, column, off, var, scratch):
    """Correct a state by a direct measurement of one column, in place.

    cov: (81,). off: the measurement less the mean. scratch: (18,).
    """
    scale = cov[10 * column] + var
    rest = off / scale
    for row in range(9):
        scratch[row] = cov[9 * row + column]
        scratch[9 + row] = scratch[row] / scale
        mean[row] += scratch[row] * rest
    for other in range(len(mean)):
        for row in range(9):
            cov[9 * row + other] -= scratch[9 + row] * scratch[other]


@inlined
def follow_yaw(mean, cov, yaw, yaw_var, turned, how, repetition, scratch):
    """A hypothesis after a yaw that is right, off by half a turn, or tells nothing; how likely.

    how: variance and factor of yaws, their floor, the share of wrong ones.
    """
    var = how[0] if isnan(yaw_var) else how[1] * yaw_var
    var = repetition * (var + how[2])
    total = cov[10 * YAW] + var
    off = wrapped(yaw - mean[YAW])
    is_opposite = abs(off) > 0.5 * pi
    folded = wrapped(off - pi) if is_opposite else off
    share = (1.0 - how[3]) * (turned if is_opposite else 1.0 - turned)
    told = share * exp(-0.5 * folded**2 / total) / sqrt(2.0 * pi * total)
    likelihood = told + how[3] / (2.0 * pi)
    # a yaw that tells something with probability p: its variance over p
    trust = max(told / likelihood, 1e-6)
    correct_column(mean, cov, YAW, folded, total / trust - cov[10 * YAW], scratch)
    return log(likelihood)


@kernel(
    F3, F4, F2, FLOAT, A1, A1, A2, B1, F1, F1, F1, FLOAT, FLOAT, OUT3, OUT4, OUT2, OUT1,
    allocates=False,
)  # fmt: skip
def read_cues(
    means, covs, log_weights, min_log_weight, yaw, yaw_var, log_size, hidden, turned, how,
    size_vars, repetition, evidence, means_out, covs_out, told, scratch,
):  # fmt: skip
    """Hypotheses (n, k, 9) after the cues of their cars, and what those count for, see `CueModel`.

    turned: how often front is taken for rear, and where a box is hidden. how: as `follow_yaw` has
    it. size_vars: of measured logarithms. Hypotheses that are not followed stay as they are.
    """
    flat = len(means), means.shape[1], 81
    covs, covs_out = covs.reshape(flat), covs_out.reshape(flat)
    for car in range(len(means)):
        is_sized = isfinite(log_size[car, 0]) and isfinite(log_size[car, 1])
        is_sized = is_sized and isfinite(log_size[car, 2])
        share = turned[1] if hidden[car] else turned[0]
        for which in range(means.shape[1]):
            mean, cov = means_out[car, which], covs_out[car, which]
            copy_hypothesis(means[car, which], covs[car, which], mean, cov)
            told[car, which] = 0.0
            if not log_weights[car, which] > min_log_weight:
                continue
            if isfinite(yaw[car]):
                told[car, which] = evidence * follow_yaw(
                    mean, cov, yaw[car], yaw_var[car], share, how, repetition, scratch
                )
            if is_sized:
                for side in range(3):
                    off = log_size[car, side] - mean[LOG_LENGTH + side]
                    var = repetition * size_vars[side]
                    correct_column(mean, cov, LOG_LENGTH + side, off, var, scratch)
