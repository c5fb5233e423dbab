"""Rates over seeds: what happened over how often it could have, with its 95 % interval."""

from math import inf, log, sqrt

import numpy as np
from jaxtyping import Float
from numpy import ndarray as Array

from mot_sim.tables import NO_INTERVAL, Interval
from mot_sim.tables.interval import CONFIDENCE, student

# With no case among n events, a rate of more than this over n would have shown one, 39 times of 40.
NONE_SEEN = -log(0.5 * (1.0 - CONFIDENCE))


def rate(parts: Float[Array, " n"], wholes: Float[Array, " n"], most: float = inf) -> Interval:
    """The sum of the parts over the sum of the wholes, one of each a run; None of nothing.

    The interval is Student's t with the spread of what the runs are off that rate (the delta
    method for a ratio of means), so that runs count by how much could happen in them. It does not
    go below 0, nor above `most`. Where nothing happened at all, its upper end is that of a Poisson
    rate.
    """
    used = wholes > 0.0
    count, whole = int(used.sum()), float(wholes.sum())
    if not count:
        return NO_INTERVAL
    mean = float(parts.sum()) / whole
    if mean == 0.0:
        return Interval(0.0, 0.0, min(NONE_SEEN / whole, most), count)
    if count == 1:
        return Interval(mean, None, None, 1)
    off = parts[used] - mean * wholes[used]
    half = student(count) * (sqrt(count / (count - 1) * float((off**2).sum())) / whole)
    return Interval(mean, max(mean - half, 0.0), min(mean + half, most), count)


def mean_count(counts: list[int]) -> Interval:
    """The mean of a count over runs."""
    return Interval.of(np.array(counts, float), (0.0, inf))


__all__ = ["mean_count", "rate"]
