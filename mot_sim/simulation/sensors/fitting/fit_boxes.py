"""Fits how boxes are off, and the scores of boxes that are right."""

import numpy as np
from jaxtyping import Float
from numpy import ndarray as Array
from scipy.optimize import minimize
from scipy.special import ndtr, ndtri
from scipy.stats import rankdata

from mot_sim.simulation import random_numbers
from mot_sim.simulation.sensors.boxes import Component, Jitter
from mot_sim.simulation.sensors.correlated_noise import Autocorrelation
from mot_sim.simulation.sensors.fitting.fit_misses import LAGS
from mot_sim.simulation.sensors.fitting.measure import Found
from mot_sim.simulation.sensors.fitting.statistics import lag_correlation, lagged
from mot_sim.simulation.sensors.fitting.tetrachoric import (
    both_below,
    correlation_of,
    nearest_autocorrelation,
)
from mot_sim.simulation.sensors.misses import HEIGHT_KNOTS, VISIBLE_KNOTS, Misses, hat_functions
from mot_sim.simulation.sensors.scores import ScoreNoise

PROBABILITIES = np.linspace(0.02, 0.98, 49)
KNOT_PROBABILITIES = np.concatenate(
    ([0.002, 0.01, 0.03], np.linspace(0.06, 0.94, 23), [0.97, 0.99, 0.998])
)
MAX_COUPLING = 0.7  # beyond, scores would foretell every miss
IMPUTATION_ROUNDS = 8  # of imputing tied scores
LOW_SCORE_SHARE = 0.05  # whose flickering is matched: near trackers' thresholds


def fit_jitter(found: Found, step: float) -> Jitter:
    """The four errors of the boxes that were matched."""
    hits = found.select(found.hit)
    parts = [fit_component(hits, hits.errors[:, column], step) for column in range(4)]
    return Jitter(*parts)


def fit_component(hits: Found, errors: Float[Array, " n"], step: float) -> Component:
    """Growth by least squares on the logarithm, tails by quantiles, then the autocorrelation."""
    sightings, middle = hits.sightings, float(np.median(errors))
    visible, height = sightings.visible, np.maximum(sightings.height, 5.0)
    logs = np.log(np.abs(errors - middle) + 1e-3)
    design = np.stack((np.ones(len(logs)), 0.95 - visible, np.log(height / 50.0)), axis=1)
    _, hidden, by_height = np.linalg.lstsq(design, logs, rcond=None)[0]
    growth = np.exp(hidden * (0.95 - visible)) * (height / 50.0) ** by_height
    rest = (errors - middle) / growth
    quantiles, normal = np.quantile(rest, PROBABILITIES), ndtri(PROBABILITIES)
    start = np.array([0.0, np.log(np.std(quantiles) + 1e-6), 0.7, 0.0])
    weight = np.sqrt(np.exp(-0.5 * normal**2))  # of the density: what moves the distribution most

    def made(parameters: Float[Array, "4"]) -> Component:
        _, spread, tail, skew = parameters.tolist()
        return Component(float(np.exp(spread)), tail=abs(tail), skew=skew)

    def loss(parameters: Float[Array, "4"]) -> float:
        part = made(parameters)
        model = parameters[0] + part.spread * part.shape(normal)
        return float(np.square((model - quantiles) * weight).sum())

    best = minimize(loss, start, method="Nelder-Mead", options={"maxiter": 2000}).x
    part = made(best)
    ranks = ndtri((rankdata(rest) - 0.5) / len(rest))
    return Component(
        spread=part.spread,
        bias=middle + float(best[0] * np.mean(growth)),
        tail=part.tail,
        skew=part.skew,
        hidden=float(hidden),
        by_height=float(by_height),
        autocorrelation=value_autocorrelation(ranks, hits, step),
    )


def value_autocorrelation(x: Float[Array, " n"], hits: Found, step: float) -> Autocorrelation:
    """The autocorrelation of a normal value that was measured itself."""
    correlations = [lag_correlation(x, hits.ids, hits.frames, lag) for lag in LAGS]
    weights = [len(lagged(hits.ids, hits.frames, lag)[0]) for lag in LAGS]
    return nearest_autocorrelation([lag * step for lag in LAGS], correlations, weights)


def fit_scores(found: Found, misses: Misses, step: float) -> ScoreNoise:
    """An ordered probit of the scores: ties are drawn anew, given what is expected of each row."""
    hits = found.select(found.hit)
    sightings, odds = hits.sightings, hits.log_odds
    low = (rankdata(odds, "min") - 1.0) / len(odds)
    high = rankdata(odds, "max") / len(odds)
    height = np.log(np.maximum(sightings.height, 1.0))
    tables = (
        hat_functions(sightings.visible, VISIBLE_KNOTS)[:, 1:3],
        hat_functions(height, tuple(np.log(HEIGHT_KNOTS))),
    )
    design = np.concatenate(tables, axis=1)
    rows = np.arange(len(odds))
    mean = np.zeros(len(odds))
    cuts = np.stack((low, high))
    for number in range(IMPUTATION_ROUNDS):
        # The latent's quantiles under the model so far, and a draw inside each row's own interval.
        noise = random_numbers.normal(0, "fit/scores", rows, np.full_like(rows, number))[:, 0]
        model = np.sort(mean + noise)
        below, above = np.interp(cuts, (np.arange(len(model)) + 0.5) / len(model), model)
        below = np.where(low <= 0.0, -8.0, below) - mean
        above = np.where(high >= 1.0, 8.0, above) - mean
        y = mean + _between(below, above, rows, number)
        ridge = design.T @ design + np.eye(design.shape[1])
        beta = np.linalg.solve(ridge, design.T @ y)
        mean = design @ beta
    half, partly, *heights = beta.tolist()
    noise = random_numbers.normal(0, "fit/scores", rows, np.full_like(rows, IMPUTATION_ROUNDS))[
        :, 0
    ]
    coupling, autocorrelation = fit_flicker(found, hits, mean, misses, step)
    return ScoreNoise(
        y_knots=tuple(np.quantile(mean + noise, KNOT_PROBABILITIES).tolist()),
        log_odds=tuple(np.quantile(odds, KNOT_PROBABILITIES).tolist()),
        by_visible=(half, half, partly, 0.0),
        by_height=tuple(heights),
        coupling=coupling,
        autocorrelation=autocorrelation,
    )


def _between(
    below: Float[Array, " n"], above: Float[Array, " n"], rows: Array, number: int
) -> Float[Array, " n"]:
    """Normal numbers between two bounds."""
    u = random_numbers.uniform(0, "fit/ties", rows, np.full_like(rows, number))[:, 0]
    low, high = ndtr(below), ndtr(above)
    return ndtri((low + u * (high - low)).clip(1e-9, 1.0 - 1e-9))


def fit_flicker(
    found: Found, hits: Found, mean: Float[Array, " n"], misses: Misses, step: float
) -> tuple[float, Autocorrelation]:
    """The coupling of low scores to misses, and the autocorrelation of the rest."""
    limit = np.quantile(hits.log_odds, LOW_SCORE_SHARE)
    event = hits.log_odds < limit
    noise = random_numbers.normal(
        0, "fit/low", np.arange(len(mean)), np.zeros(len(mean), np.int64)
    )[:, 0]
    at = np.quantile(mean + noise, max(event.mean(), 1e-3))
    rates = ndtr(at - mean)
    miss_rates = misses.rates(found.sightings)
    missed = ~found.hit & (found.sightings.kinds == "Car")
    low, odds = np.zeros(len(found), bool), np.full(len(found), np.nan)
    rows = np.flatnonzero(found.hit)
    low[rows], odds[rows] = event, rates
    first, second = lagged(found.ids, found.frames, 1)
    a, b = np.concatenate((first, second)), np.concatenate((second, first))
    usable = found.hit[a] & (found.sightings.kinds[b] == "Car")
    a, b = a[usable], b[usable]
    one = misses.autocorrelation.correlation(step) * (1.0 - misses.shared)
    # How often b is missed when a was found: a itself tells of its latent.
    x, y = ndtri(np.stack((miss_rates[a], miss_rates[b])).clip(1e-9, 1.0 - 1e-9))
    after_hit = (miss_rates[b] - both_below(x, y, one)) / (1.0 - miss_rates[a])
    together = correlation_of(odds[a], after_hit, low[a], missed[b])
    coupling = (
        float(np.clip(together / max(one, 0.1), 0.0, MAX_COUPLING))
        if np.isfinite(together)
        else 0.0
    )
    correlations, weights = [], []
    for lag in LAGS:
        first, second = lagged(hits.ids, hits.frames, lag)
        whole = correlation_of(rates[first], rates[second], event[first], event[second])
        theirs = coupling**2 * misses.autocorrelation.correlation(lag * step)
        correlations.append(float(np.clip((whole - theirs) / (1.0 - coupling**2), -1.0, 1.0)))
        weights.append(len(first))
    return round(coupling, 4), nearest_autocorrelation(
        [lag * step for lag in LAGS], correlations, weights
    )
