"""Fits who is missed, in what bursts, and which vans and trucks are taken for cars."""

from dataclasses import replace

import numpy as np
from jaxtyping import Bool, Float, Int
from numpy import ndarray as Array
from scipy.special import expit, logit

from mot_sim.metrics.matching import same_frame_pairs
from mot_sim.simulation.sensors.correlated_noise import Autocorrelation
from mot_sim.simulation.sensors.fitting.measure import DRIVE_ID_STRIDE, FalseBoxes, Found
from mot_sim.simulation.sensors.fitting.statistics import lagged
from mot_sim.simulation.sensors.fitting.tetrachoric import correlation_of, nearest_autocorrelation
from mot_sim.simulation.sensors.misses import (
    HEIGHT_KNOTS,
    TRUNCATION_KNOTS,
    VISIBLE_KNOTS,
    Confusion,
    Misses,
    hat_functions,
    truncation_growth,
)

LAGS = (1, 2, 3, 5, 8, 12, 20, 40)
FRAME_LAGS = (0, 1, 10)  # frames between two objects, to tell a frame's glare from the drive
MIN_OPEN_VISIBLE = 0.5  # visible fraction from which a car is open: KITTI's levels 0, 1 and 3
RIDGE_PENALTY = 0.2  # the strength with which a table is held near 0
HIDDEN_LOG_ODDS = 2.0  # log-odds from .35 visible to .05, of which labels tell nothing


def fit_misses(found: Found, step: float) -> Misses:
    """Of cars: a logistic curve over the tables of `Misses`, then its latent's autocorrelation."""
    cars = found.select(found.sightings.kinds == "Car")
    # How far a car is cut is known by three levels only: what changes there is the rate.
    whole = cars.select(cars.sightings.truncation == 0.0)
    misses = fit_cuts(fit_tables(whole), cars.select(cars.sightings.truncation > 0.0))
    rates = misses.rates(whole.sightings)
    shared, seconds = fit_shared(~whole.hit, rates, whole, step)
    is_open = whole.sightings.visible >= MIN_OPEN_VISIBLE
    autocorrelation = fit_autocorrelation(is_open, whole, rates, step)
    half, flutter = fit_flutter(~is_open, whole, rates, autocorrelation, step)
    if shared > 0.0:  # what remains for the object's own latent
        autocorrelation = without_shared(autocorrelation, shared, seconds, step)
    return replace(
        misses,
        autocorrelation=autocorrelation,
        flutter=(half, half, 0.0, 0.0),
        flutter_autocorrelation=flutter,
        shared=shared,
        shared_seconds=seconds,
    )


def fit_tables(whole: Found) -> Misses:
    """The tables by size and by what is visible, from cars that the image does not cut."""
    logs = np.log(np.maximum(whole.sightings.height, 1.0))
    visible, heights = (
        hat_functions(whole.sightings.visible, VISIBLE_KNOTS),
        hat_functions(logs, tuple(np.log(HEIGHT_KNOTS))),
    )
    both = (visible[:, 1:, None] * heights[:, None, :]).reshape(len(whole), -1)
    tables = visible[:, 1:3], heights, both  # against .95
    design = np.concatenate((np.ones((len(whole), 1)), *tables), axis=1)
    count = len(HEIGHT_KNOTS)
    base, half, partly, *rest = logistic(design, whole.hit, np.zeros(len(whole))).tolist()
    return Misses(
        base=base,
        by_visible=(half - HIDDEN_LOG_ODDS, half, partly, 0.0),
        by_height=tuple(rest[:count]),
        by_both=(*rest[count : 2 * count], *rest[count:]),  # nearly hidden as half hidden
    )


def fit_cuts(misses: Misses, cut: Found) -> Misses:
    """What the image's border takes away beyond the tables of whole cars."""
    given = -logit(misses.rates(cut.sightings).clip(1e-6, 1.0 - 1e-6))
    levels = hat_functions(cut.sightings.truncation, TRUNCATION_KNOTS)[:, 1:]
    design = np.concatenate((levels, levels * truncation_growth(cut.sightings)[:, None]), axis=1)
    drop = logistic(design, cut.hit, given).tolist()
    return replace(
        misses, by_truncation=(0.0, drop[0], drop[1]), truncation_by_height=(0.0, drop[2], drop[3])
    )


def logistic(
    design: Float[Array, "n k"], event: Bool[Array, " n"], given: Float[Array, " n"]
) -> Float[Array, " k"]:
    """Coefficients by penalised maximum likelihood (Newton's steps); the first is free.

    given: log-odds to which the design only adds.
    """
    beta = np.zeros(design.shape[1])
    penalty = np.full(len(beta), RIDGE_PENALTY)
    penalty[0] = 1e-3
    for _ in range(30):
        p = expit(given + design @ beta)
        slope = design.T @ (event - p) - penalty * beta
        curve = (design * (p * (1.0 - p))[:, None]).T @ design + np.diag(penalty)
        move = np.linalg.solve(curve, slope)
        beta = beta + move.clip(-2.0, 2.0)
        if np.abs(move).max() < 1e-6:
            break
    return beta


def event_autocorrelation(
    event: Bool[Array, " n"],
    rates: Float[Array, " n"],
    ids: Int[Array, " n"],
    frames: Int[Array, " n"],
    step: float,
) -> Autocorrelation:
    """The autocorrelation of the latent behind an event with known rates.

    Neighbouring frames weigh most: they decide how many bursts there are. Real detectors are
    smoother there than any AR(1): a car that is found stays found for some frames.
    """
    correlations, weights = event_correlations(event, rates, ids, frames)
    return nearest_autocorrelation([lag * step for lag in LAGS], correlations, weights, smooth=True)


def event_correlations(
    event: Bool[Array, " n"],
    rates: Float[Array, " n"],
    ids: Int[Array, " n"],
    frames: Int[Array, " n"],
) -> tuple[list[float], list[float]]:
    """The latent's autocorrelation at LAGS, and what each figure weighs."""
    correlations, weights = [], []
    for lag in LAGS:
        first, second = lagged(ids, frames, lag)
        correlations.append(
            correlation_of(rates[first], rates[second], event[first], event[second])
        )
        weights.append(len(first) / lag**3)
    return correlations, weights


def fit_autocorrelation(
    rows: Bool[Array, " n"], whole: Found, rates: Float[Array, " n"], step: float
) -> Autocorrelation:
    """The autocorrelation of the misses of some rows."""
    some = whole.select(rows)
    return event_autocorrelation(~some.hit, rates[rows], some.ids, some.frames, step)


def fit_flutter(
    rows: Bool[Array, " n"],
    whole: Found,
    rates: Float[Array, " n"],
    autocorrelation: Autocorrelation,
    step: float,
) -> tuple[float, Autocorrelation]:
    """The share of a latent of its own that half hidden cars have, and its autocorrelation.

    What hides a car moves: their misses come and go faster than those of open cars.
    """
    some = whole.select(rows)
    rho, weights = event_correlations(~some.hit, rates[rows], some.ids, some.frames)
    times = [lag * step for lag in LAGS]
    open_rho = np.array([autocorrelation.correlation(t) for t in times])
    if not np.isfinite(rho[0]):
        return 0.0, Autocorrelation()
    best, answer = np.inf, (0.0, Autocorrelation())
    for share in np.linspace(0.0, 1.0, 11).tolist():
        rest = (np.array(rho) - (1.0 - share) * open_rho) / max(share, 1e-9)
        own = nearest_autocorrelation(times, rest.clip(-1.0, 1.0).tolist(), weights, smooth=True)
        made = (1.0 - share) * open_rho + share * np.array([own.correlation(t) for t in times])
        off = float(np.nansum(np.array(weights) * np.square(made - rho)))
        if off < best - 1e-12:
            best, answer = off, (round(share, 4), own)
    return answer


def fit_shared(
    event: Bool[Array, " n"], rates: Float[Array, " n"], found: Found, step: float
) -> tuple[float, float]:
    """The share of the latent that all objects of a frame have in common, and its seconds.

    What two objects of a drive share a second apart is the drive (its light, its labels) and
    not the frame; only what they share beyond that counts.
    """
    moments = (found.ids // DRIVE_ID_STRIDE) * DRIVE_ID_STRIDE + found.frames
    order = np.argsort(moments, kind="stable")
    event, rates = event[order], rates[order]
    moments, ids = moments[order], found.ids[order]
    seen = []
    for lag in FRAME_LAGS:
        first, second = same_frame_pairs(moments + lag, moments)
        pairs = ids[first] != ids[second]
        first, second = first[pairs], second[pairs]
        if len(first) < 1000:
            return 0.0, 0.0
        seen.append(correlation_of(rates[first], rates[second], event[first], event[second]))
    at_once, soon, late = seen
    shared = max(at_once - late, 0.0)
    kept = (soon - late) / shared if shared > 0.0 else 0.0
    seconds = -step / np.log(np.clip(kept, 0.05, 0.9)) if kept > 0.05 else 0.0
    return round(shared, 4), round(float(seconds), 4)


def without_shared(
    autocorrelation: Autocorrelation, shared: float, seconds: float, step: float
) -> Autocorrelation:
    """The autocorrelation of what the objects do not share."""
    times = [lag * step for lag in LAGS]
    glare = Autocorrelation((1.0,), (seconds,))
    rest = [
        min((autocorrelation.correlation(t) - shared * glare.correlation(t)) / (1.0 - shared), 1.0)
        for t in times
    ]
    return nearest_autocorrelation(times, rest, [1.0] * len(LAGS))


def fit_confusion(found: Found, false: FalseBoxes, misses: Misses, step: float) -> Confusion:
    """The rates of vans and trucks, over what would be found if they were cars."""
    kinds = found.sightings.kinds
    would = 1.0 - misses.rates(found.sightings)
    vans, trucks = kinds == "Van", kinds == "Truck"
    van = float((found.hit[vans].sum() + 0.5) / (would[vans].sum() + 1.0)) if vans.any() else 1.0
    near = false.nearest[false.iou >= 0.5]
    on_trucks = float(np.isin(near, np.flatnonzero(trucks)).sum())
    truck = (on_trucks + 0.5) / (float(would[trucks].sum()) + 1.0) if trucks.any() else 0.0
    van, truck = min(van, 1.0), min(truck, 1.0)
    autocorrelation = Autocorrelation((1.0,), (5.0,))
    if vans.sum() > 200 and 0.02 < van < 0.98:
        autocorrelation = event_autocorrelation(
            found.hit[vans], van * would[vans], found.ids[vans], found.frames[vans], step
        )
    return Confusion(round(van, 4), round(truck, 4), autocorrelation)
