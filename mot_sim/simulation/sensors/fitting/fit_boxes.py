"""Fits how boxes are off, and the scores of boxes that are right."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from jaxtyping import Float
from numpy import ndarray as Array
from scipy.optimize import minimize
from scipy.special import expit, ndtr, ndtri
from scipy.stats import rankdata

from mot_sim.simulation import random_numbers
from mot_sim.simulation.sensors.correlated_noise import Autocorrelation
from mot_sim.simulation.sensors.fitting.fit_misses import LAGS
from mot_sim.simulation.sensors.fitting.measure import Found, ScoredSightings
from mot_sim.simulation.sensors.fitting.statistics import lag_correlation, lagged
from mot_sim.simulation.sensors.fitting.tetrachoric import (
    RatedEvents,
    both_below,
    correlation_of,
    nearest_autocorrelation,
)
from mot_sim.simulation.sensors.jitter import (
    HEIGHT_RANGE,
    MIN_SIDE_PIXELS,
    UNSURE_SCORE,
    USUAL_HEIGHT,
    USUAL_VISIBLE,
    EdgeNoise,
    Jitter,
    doubt,
    held_normals,
)
from mot_sim.simulation.sensors.misses import (
    HEIGHT_KNOTS,
    TRUNCATION_KNOTS,
    VISIBLE_KNOTS,
    Misses,
    hat_functions,
    truncation_growth,
)
from mot_sim.simulation.sensors.scores import ScoreNoise
from mot_sim.simulation.sensors.sightings import Sightings

PROBABILITIES = np.linspace(0.02, 0.98, 49)
KNOT_PROBABILITIES = np.concatenate(
    ([0.002, 0.01, 0.03], np.linspace(0.06, 0.94, 23), [0.97, 0.99, 0.998])
)
MIN_TIED_SHARE = 0.003  # of all scores that are equal, from which a value is kept as it is
MIN_EDGE_ERROR = 1e-3  # parts of a side; smaller errors tell no more
ABSOLUTE_ROUNDS = 30
HOLDS = (0.0, 0.1, 0.2, 0.3, 0.5, 0.8)  # seconds that are tried
UNSTEADY = (0.0, 0.02, 0.04, 0.08, 0.12, 0.2)  # shares that are tried
MIN_UNSURE_CHANGES = 50  # pairs of neighbouring frames of which one is unsure
CHANGE_PROBABILITIES = (0.5, 0.75, 0.9, 0.97, 0.99, 0.997)
HOLD_OBJECTS, HOLD_FRAMES = 300, 60  # of the simulations that are compared
MAX_COUPLING = 0.7  # beyond, scores would foretell every miss
IMPUTATION_ROUNDS = 8  # of imputing tied scores
LOW_SCORE_SHARES = (0.05, 0.2)  # whose flickering is matched: near trackers' thresholds


def fit_jitter(found: Found, step: float) -> Jitter:
    """The errors of the four edges of the boxes that were matched, and how they go together."""
    hits = found.select(found.hit)
    noises = [_fit_edge(hits, place) for place in range(4)]
    edges, own, shared = [], [], []
    for (first, x), (second, y) in ((noises[0], noises[2]), (noises[1], noises[3])):
        together = float(np.corrcoef(x, y)[0, 1])
        edges += [first, second]
        own += [x, (y - together * x) / np.sqrt(1.0 - together**2)]
        shared.append(round(together, 4))
    hold, unsteady, slow = fit_hold(own, hits, step)
    fitted = [replace(edge, autocorrelation=each) for edge, each in zip(edges, slow, strict=True)]
    left, right, upper, lower = fitted
    unsure = fit_unsure_own(own, hits)
    return Jitter(left, upper, right, lower, shared[0], shared[1], hold, unsteady, unsure)


def fit_unsure_own(own: Sequence[Float[Array, " n"]], hits: Found) -> float:
    """What share of their errors unsure boxes have of their own; see `Jitter.unsure_own`.

    own: the normal numbers of all four edges. Neighbouring frames of which one is unsure are less
    alike than those of which both are sure, or both unsure.
    """
    unsure, numbers = expit(hits.log_odds) < UNSURE_SCORE, np.stack(own)
    first, second = lagged(hits.ids, hits.frames, 1)
    change = unsure[first] != unsure[second]
    if min(change.sum(), (~change).sum()) < MIN_UNSURE_CHANGES:
        return 0.0
    same, other = (
        np.mean([np.corrcoef(x[first[rows]], x[second[rows]])[0, 1] for x in numbers])
        for rows in (~change, change)
    )
    return round(float(1.0 - (other / max(same, 0.1)).clip(0.0, 1.0) ** 2), 4)


def fit_hold(
    own: Sequence[Float[Array, " n"]], hits: Found, step: float
) -> tuple[float, float, list[Autocorrelation]]:
    """How long errors stay before they jump, what share trembles, and the autocorrelations.

    own: the normal numbers of all four edges. Of HOLDS and UNSTEADY those are taken whose changes
    from frame to frame have the quantiles of the real ones.
    """
    first, second = lagged(hits.ids, hits.frames, 1)
    numbers = np.stack(own, axis=1)
    real = change_quantiles(numbers[second] - numbers[first])
    ids = np.repeat(np.arange(HOLD_OBJECTS), HOLD_FRAMES)
    frames = np.tile(np.arange(HOLD_FRAMES), HOLD_OBJECTS)
    later = np.flatnonzero(frames > 0)
    best = (np.inf, 0.0, 0.0, [Autocorrelation()] * len(own))
    for unsteady in UNSTEADY:
        slow = [value_autocorrelation(x, hits, step, unsteady) for x in own]
        for hold in HOLDS:
            x = held_normals(0, "jitter", ids, frames, tuple(slow), step, hold, unsteady)
            made = change_quantiles(x[later] - x[later - 1])
            off = float(np.abs(np.log(made / real)).sum())
            if off < best[0]:
                best = off, hold, unsteady, slow
    return best[1:]


def change_quantiles(changes: Float[Array, "n 4"]) -> Float[Array, " q"]:
    """Of the size of changes, all edges together (root mean square); none below a hundredth."""
    sizes = np.sqrt(np.square(changes).mean(axis=1))
    return np.maximum(np.quantile(sizes, CHANGE_PROBABILITIES), 0.01)


def _fit_edge(hits: Found, place: int) -> tuple[EdgeNoise, Float[Array, " n"]]:
    """The noise of an edge without its autocorrelation, and its normal number in every row.

    The mean by least absolute errors, growth by least squares on the logarithm, tails by quantiles.
    """
    sightings, errors = hits.sightings, hits.edges[:, place]
    sides = sightings.boxes[:, 2:] - sightings.boxes[:, :2]
    side = np.maximum(sides[:, place % 2], MIN_SIDE_PIXELS)
    hidden = USUAL_VISIBLE - sightings.visible
    tall = np.log(sightings.height.clip(*HEIGHT_RANGE) / USUAL_HEIGHT)
    unsure = doubt(expit(hits.log_odds))
    one = np.ones(len(errors))
    means = np.stack((one, 1.0 / side, hidden), axis=1)
    mean = least_absolute(means, errors)
    rest = errors - means @ mean
    design = np.stack((one, hidden, tall, tall**2, unsure), axis=1)
    grows = np.linalg.lstsq(design, np.log(np.abs(rest) + MIN_EDGE_ERROR), rcond=None)[0]
    growth = np.exp(design[:, 1:] @ grows[1:])
    rest = rest / growth
    spread, tail, skew, shift = _fit_shape(rest)
    edge = EdgeNoise(
        spread=spread,
        bias=float(mean[0]) + shift * float(np.mean(growth)),
        bias_pixels=float(mean[1]),
        bias_hidden=float(mean[2]),
        tail=tail,
        skew=skew,
        hidden=float(grows[1]),
        by_height=float(grows[2]),
        by_extremes=float(grows[3]),
        unsure=float(grows[4]),
    )
    return edge, ndtri((rankdata(rest) - 0.5) / len(rest))


def least_absolute(design: Float[Array, "n k"], values: Float[Array, " n"]) -> Float[Array, " k"]:
    """The coefficients of least absolute errors, by weighted least squares again and again."""
    found = np.linalg.lstsq(design, values, rcond=None)[0]
    for _ in range(ABSOLUTE_ROUNDS):
        weights = 1.0 / (np.abs(values - design @ found) + MIN_EDGE_ERROR)
        found = np.linalg.solve((design.T * weights) @ design, (design.T * weights) @ values)
    return found


def _fit_shape(rest: Float[Array, " n"]) -> tuple[float, float, float, float]:
    """Spread, tail, skew and shift whose quantiles are those of the values."""
    quantiles, normal = np.quantile(rest, PROBABILITIES), ndtri(PROBABILITIES)
    start = np.array([0.0, np.log(np.std(quantiles) + 1e-6), 0.7, 0.0])
    weight = np.sqrt(np.exp(-0.5 * normal**2))  # of the density: what moves the distribution most

    def made(parameters: Float[Array, "4"]) -> EdgeNoise:
        _, spread, tail, skew = parameters.tolist()
        return EdgeNoise(float(np.exp(spread)), tail=abs(tail), skew=skew)

    def loss(parameters: Float[Array, "4"]) -> float:
        part = made(parameters)
        model = parameters[0] + part.spread * part.shape(normal)
        return float(np.square((model - quantiles) * weight).sum())

    best = minimize(loss, start, method="Nelder-Mead", options={"maxiter": 2000}).x
    part = made(best)
    return part.spread, part.tail, part.skew, float(best[0])


def value_autocorrelation(
    x: Float[Array, " n"], hits: Found, step: float, unsteady: float = 0.0
) -> Autocorrelation:
    """The autocorrelation of a normal value that was measured itself.

    unsteady: share of its variance that is no part of it, since it is drawn anew in every frame.
    """
    correlations = [
        min(lag_correlation(x, hits.ids, hits.frames, lag) / (1.0 - unsteady), 0.999)
        for lag in LAGS
    ]
    weights = [len(lagged(hits.ids, hits.frames, lag)[0]) for lag in LAGS]
    return nearest_autocorrelation([lag * step for lag in LAGS], correlations, weights)


def fit_scores(
    found: Found, misses: Misses, step: float, beside: ScoredSightings | None = None
) -> ScoreNoise:
    """An ordered probit of the scores by what is seen.

    beside: what was found of cars before and after their labels.
    """
    hits = found.select(found.hit)
    scored = ScoredSightings(hits.sightings, hits.log_odds)
    if beside is not None and len(beside):
        labelled = replace(hits.sightings, unlabelled=np.zeros(len(hits), np.int64))
        scored = ScoredSightings.concatenate([replace(scored, sightings=labelled), beside])
    design = _score_design(scored.sightings)
    beta = ordered_probit(design, scored.log_odds)
    mean = (design @ beta)[: len(hits)]
    half, partly, *rest = beta.tolist()
    by_height, rest = rest[: len(HEIGHT_KNOTS)], rest[len(HEIGHT_KNOTS) :]
    coupling, autocorrelation = fit_flicker(found, hits, mean, misses, step)
    latent = mean + _noise("fit/scores", len(mean), IMPUTATION_ROUNDS)
    probabilities, log_odds = quantiles_with_ties(hits.log_odds)
    return ScoreNoise(
        y_knots=tuple(np.quantile(latent, probabilities).tolist()),
        log_odds=tuple(log_odds.tolist()),
        by_visible=(half, half, partly, 0.0),
        by_height=tuple(by_height),
        by_truncation=(0.0, *rest[:2]),
        truncation_by_height=(0.0, *rest[2:4]),
        other_kinds=rest[4],
        unlabelled=tuple(rest[5:]),
        coupling=coupling,
        autocorrelation=autocorrelation,
    )


def _score_design(sightings: Sightings) -> Float[Array, "n k"]:
    """A column for each part of the scores' latent that is fitted."""
    log_heights = np.log(np.maximum(sightings.height, 1.0))
    truncation = hat_functions(sightings.truncation, TRUNCATION_KNOTS)[:, 1:]
    unlabelled = sightings.unlabelled
    sides = np.zeros(len(sightings), np.int64) if unlabelled is None else unlabelled
    columns = (
        hat_functions(sightings.visible, VISIBLE_KNOTS)[:, 1:3],
        hat_functions(log_heights, tuple(np.log(HEIGHT_KNOTS))),
        truncation,
        truncation * truncation_growth(sightings)[:, None],
        (sightings.kinds != "Car").astype(float)[:, None],
        np.eye(4)[sides][:, 1:],
    )
    return np.concatenate(columns, axis=1)


def quantiles_with_ties(
    values: Float[Array, " n"],
) -> tuple[Float[Array, " k"], Float[Array, " k"]]:
    """Probabilities and quantiles at them: a straight line between, level where many are tied."""
    single, counts = np.unique(values, return_counts=True)
    rank = np.cumsum(counts)
    below, above = (rank - counts) / len(values), rank / len(values)
    many = counts >= MIN_TIED_SHARE * len(values)
    single, below, above = single[many], below[many], above[many]
    p = KNOT_PROBABILITIES[:, None]
    free = KNOT_PROBABILITIES[~((below <= p) & (p <= above)).any(axis=1)]
    probabilities = np.concatenate((free, below, above))
    quantiles = np.concatenate((np.quantile(values, free), single, single))
    order = np.lexsort((quantiles, probabilities))
    return probabilities[order], quantiles[order]


def ordered_probit(design: Float[Array, "n k"], values: Float[Array, " n"]) -> Float[Array, " k"]:
    """Coefficients of a normal latent that orders the values; ties are drawn anew in each round."""
    low = (rankdata(values, "min") - 1.0) / len(values)
    high = rankdata(values, "max") / len(values)
    ranks = (np.arange(len(values)) + 0.5) / len(values)
    ridge = design.T @ design + np.eye(design.shape[1])
    mean = np.zeros(len(values))
    for number in range(IMPUTATION_ROUNDS):
        # The latent's quantiles under the model so far, and a draw inside each row's own interval.
        model = np.sort(mean + _noise("fit/scores", len(values), number))
        below, above = np.interp(np.stack((low, high)), ranks, model)
        below = np.where(low <= 0.0, -8.0, below) - mean
        above = np.where(high >= 1.0, 8.0, above) - mean
        y = mean + _between(below, above, number)
        beta = np.linalg.solve(ridge, design.T @ y)
        mean = design @ beta
    return beta


def _noise(effect: str, count: int, number: int) -> Float[Array, " n"]:
    """One standard normal number per row, in a round."""
    return random_numbers.normal(0, effect, np.arange(count), np.full(count, number))[:, 0]


def _between(
    below: Float[Array, " n"], above: Float[Array, " n"], number: int
) -> Float[Array, " n"]:
    """Normal numbers between two bounds."""
    rows = np.arange(len(below))
    u = random_numbers.uniform(0, "fit/ties", rows, np.full_like(rows, number))[:, 0]
    low, high = ndtr(below), ndtr(above)
    return ndtri((low + u * (high - low)).clip(1e-9, 1.0 - 1e-9))


def fit_flicker(
    found: Found, hits: Found, mean: Float[Array, " n"], misses: Misses, step: float
) -> tuple[float, Autocorrelation]:
    """The coupling of low scores to misses, and the autocorrelation of the rest.

    mean: of the scores' latent, a row per hit.
    """
    lowest, *others = (_low_scores(hits, mean, share) for share in LOW_SCORE_SHARES)
    coupling = fit_coupling(found, lowest, misses, step)
    correlations, weights = [], []
    for lag in LAGS:
        first, second = lagged(hits.ids, hits.frames, lag)
        whole = np.mean([each.latent_correlation(first, second) for each in (lowest, *others)])
        theirs = coupling**2 * misses.autocorrelation.correlation(lag * step)
        correlations.append(float(np.clip((whole - theirs) / (1.0 - coupling**2), -1.0, 1.0)))
        weights.append(len(first))
    autocorrelation = nearest_autocorrelation([lag * step for lag in LAGS], correlations, weights)
    return round(coupling, 4), autocorrelation


def _low_scores(hits: Found, mean: Float[Array, " n"], share: float) -> RatedEvents:
    """Which scores belong to the lowest ones, a share of all."""
    is_low = hits.log_odds < np.quantile(hits.log_odds, share)
    threshold = np.quantile(mean + _noise("fit/low", len(mean), 0), max(is_low.mean(), 1e-3))
    return RatedEvents(is_low, ndtr(threshold - mean), hits.ids, hits.frames)


def fit_coupling(found: Found, low_scores: RatedEvents, misses: Misses, step: float) -> float:
    """How much of the scores' latent is that of the misses: low scores beside misses tell it.

    low_scores: a row per hit, in the order of `found`.
    """
    is_car, miss_rates = found.sightings.kinds == "Car", misses.rates(found.sightings)
    is_low, low_rates = np.zeros(len(found), bool), np.full(len(found), np.nan)
    is_low[found.hit], low_rates[found.hit] = low_scores.happens, low_scores.rates
    first, second = lagged(found.ids, found.frames, 1)
    a, b = np.concatenate((first, second)), np.concatenate((second, first))
    usable = found.hit[a] & is_car[b]
    a, b = a[usable], b[usable]
    one = misses.autocorrelation.correlation(step) * (1.0 - misses.shared)
    # How often b is missed when a was found: a itself tells of its latent.
    x, y = ndtri(np.stack((miss_rates[a], miss_rates[b])).clip(1e-9, 1.0 - 1e-9))
    after_hit = (miss_rates[b] - both_below(x, y, one)) / (1.0 - miss_rates[a])
    together = correlation_of(low_rates[a], after_hit, is_low[a], ~found.hit[b])
    if not np.isfinite(together):
        return 0.0
    return float(np.clip(together / max(one, 0.1), 0.0, MAX_COUPLING))
