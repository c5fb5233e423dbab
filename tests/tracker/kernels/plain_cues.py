"""Hypotheses of cars after measured yaws and sizes, in plain NumPy."""

import numpy as np
from jaxtyping import Bool, Float
from numpy import ndarray as Array

from tracker.car_filter import CarCues, CueModel
from tracker.car_filter.states import LOG_SIZE, YAW
from tracker.geometry import wrap_angle

SIZE_COLUMNS = range(LOG_SIZE.start, LOG_SIZE.stop)


def plain_cues(
    how: CueModel,
    means: Float[Array, "h 9"],
    covs: Float[Array, "h 9 9"],
    cues: CarCues,
    hidden: Bool[Array, " h"],
    is_first: bool,
) -> tuple[Float[Array, "h 9"], Float[Array, "h 9 9"], Float[Array, " h"]]:
    """Hypotheses after the cues of their cars, row by row, and what those count for, nats."""
    repetition, evidence = (1.0, 1.0) if is_first else (how.repetition, how.evidence)
    means, covs, fit = means.copy(), covs.copy(), np.zeros(len(means))
    known = np.isfinite(cues.yaw).nonzero()[0]
    if len(known):
        some = means[known], covs[known], cues.select(known), hidden[known], repetition
        means[known], covs[known], fit[known] = plain_yaw(how, *some)
        fit *= evidence
    known = np.isfinite(cues.log_size).all(axis=1).nonzero()[0]
    if len(known):
        mean, cov = means[known], covs[known]
        step = np.zeros_like(mean)
        for column, std in zip(SIZE_COLUMNS, how.size_std, strict=True):
            off = cues.log_size[known, column - LOG_SIZE.start] - mean[:, column]
            cov = _corrected(cov, step, column, off, repetition * std**2)
        means[known], covs[known] = mean + step, cov
    return means, covs, fit


def plain_yaw(
    how: CueModel,
    means: Float[Array, "h 9"],
    covs: Float[Array, "h 9 9"],
    cues: CarCues,
    hidden: Bool[Array, " h"],
    repetition: float,
) -> tuple[Float[Array, "h 9"], Float[Array, "h 9 9"], Float[Array, " h"]]:
    """Hypotheses after yaws that are right, off by half a turn, or tell nothing; how likely."""
    var = np.where(np.isnan(cues.yaw_var), how.yaw_std**2, how.yaw_factor**2 * cues.yaw_var)
    var = repetition * (var + how.yaw_floor**2)
    total = covs[:, YAW, YAW] + var
    off = np.asarray(wrap_angle(cues.yaw - means[:, YAW]))
    turned = np.where(hidden, how.hidden_turned_share, how.turned_share)
    is_opposite = np.abs(off) > 0.5 * np.pi
    folded = np.where(is_opposite, wrap_angle(off - np.pi), off)
    share = (1.0 - how.wrong_share) * np.where(is_opposite, turned, 1.0 - turned)
    told = share * np.exp(-0.5 * folded**2 / total) / np.sqrt(2.0 * np.pi * total)
    likelihood = told + how.wrong_share / (2.0 * np.pi)
    step = np.zeros_like(means)
    # a yaw that tells something with probability p: its variance over p
    trust = np.maximum(told / likelihood, 1e-6)
    covs = _corrected(covs, step, YAW, folded, total / trust - covs[:, YAW, YAW])
    return means + step, covs, np.log(likelihood)


def _corrected(
    covs: Float[Array, "h 9 9"],
    step: Float[Array, "h 9"],
    column: int,
    off: Float[Array, " h"],
    var: Float[Array, " h"] | float,
) -> Float[Array, "h 9 9"]:
    """Covariances after a direct measurement of a column; its correction is added to `step`.

    off: the measurement less the mean.
    """
    Ph = covs[:, :, column]
    gain = Ph / (covs[:, column, column] + var)[:, None]
    step += gain * (off - step[:, column])[:, None]
    corrected: Float[Array, "h 9 9"] = covs - gain[:, :, None] * Ph[:, None, :]
    return corrected
