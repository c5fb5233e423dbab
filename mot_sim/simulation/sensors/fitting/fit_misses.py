"""Fits who is missed, in what bursts, and which vans and trucks are taken for cars."""

from dataclasses import replace

import numpy as np
from jaxtyping import Bool, Float
from numpy import ndarray as Array
from scipy.special import expit, logit

from mot_sim.metrics.matching import same_frame_pairs
from mot_sim.simulation.sensors.correlated_noise import Autocorrelation
from mot_sim.simulation.sensors.fitting.measure import DRIVE_ID_STRIDE, FalseBoxes, Found
from mot_sim.simulation.sensors.fitting.statistics import lagged
from mot_sim.simulation.sensors.fitting.tetrachoric import RatedEvents, nearest_autocorrelation
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
MIN_SHARED_PAIRS = 1000  # of objects in a frame, to tell what they share
MIN_VANS = 200  # sightings, to tell how long a confusion lasts
HIDDEN_LOG_ODDS = 2.0  # log-odds from .35 visible to .05, of which labels tell nothing


def fit_misses(found: Found, step: float) -> Misses:
    """Of cars: a logistic curve over the tables of `Misses`, then its latent's autocorrelation."""
    cars = found.select(found.sightings.kinds == "Car")
    # How far a car is truncated is known by three levels only: what changes there is the rate.
    whole = cars.select(cars.sightings.truncation == 0.0)
    truncated = cars.select(cars.sightings.truncation > 0.0)
    misses = fit_truncation(fit_tables(whole), truncated)
    events = RatedEvents(~whole.hit, misses.rates(whole.sightings), whole.ids, whole.frames)
    shared, seconds = fit_shared(events, step)
    is_open = whole.sightings.visible >= MIN_OPEN_VISIBLE
    autocorrelation = latent_autocorrelation(events.select(is_open), step)
    half, flutter = fit_flutter(events.select(~is_open), autocorrelation, step)
    if shared > 0.0:
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
    """The tables by size and by what is visible, from cars that the image does not truncate."""
    log_heights = np.log(np.maximum(whole.sightings.height, 1.0))
    visible = hat_functions(whole.sightings.visible, VISIBLE_KNOTS)
    heights = hat_functions(log_heights, tuple(np.log(HEIGHT_KNOTS)))
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


def fit_truncation(misses: Misses, truncated: Found) -> Misses:
    """What the image's border takes away beyond the tables of whole cars."""
    sightings = truncated.sightings
    given = -logit(misses.rates(sightings).clip(1e-6, 1.0 - 1e-6))
    levels = hat_functions(sightings.truncation, TRUNCATION_KNOTS)[:, 1:]
    design = np.concatenate((levels, levels * truncation_growth(sightings)[:, None]), axis=1)
    drop = logistic(design, truncated.hit, given).tolist()
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
        gradient = design.T @ (event - p) - penalty * beta
        hessian = (design * (p * (1.0 - p))[:, None]).T @ design + np.diag(penalty)
        move = np.linalg.solve(hessian, gradient)
        beta = beta + move.clip(-2.0, 2.0)
        if np.abs(move).max() < 1e-6:
            break
    return beta


def latent_autocorrelation(events: RatedEvents, step: float) -> Autocorrelation:
    """The autocorrelation of the latent behind an event with known rates.

    Neighbouring frames weigh most: they decide how many bursts there are. Real detectors are
    smoother there than any AR(1): a car that is found stays found for some frames.
    """
    correlations, weights = latent_correlations(events)
    return nearest_autocorrelation([lag * step for lag in LAGS], correlations, weights, smooth=True)


def latent_correlations(events: RatedEvents) -> tuple[list[float], list[float]]:
    """The latent's autocorrelation at LAGS, and the weight of each figure."""
    correlations, weights = [], []
    for lag in LAGS:
        first, second = lagged(events.ids, events.frames, lag)
        correlations.append(events.latent_correlation(first, second))
        weights.append(len(first) / lag**3)
    return correlations, weights


def fit_flutter(
    events: RatedEvents, autocorrelation: Autocorrelation, step: float
) -> tuple[float, Autocorrelation]:
    """The share of a latent of its own that half hidden cars have, and its autocorrelation.

    events: misses of half hidden cars. autocorrelation: of the misses of open ones. What hides a
    car moves: misses come and go faster than those of open cars.
    """
    correlations, weights = latent_correlations(events)
    rho, times = np.array(correlations), [lag * step for lag in LAGS]
    open_rho = np.array([autocorrelation.correlation(t) for t in times])
    if not np.isfinite(rho[0]):
        return 0.0, Autocorrelation()
    least, best = np.inf, (0.0, Autocorrelation())
    for share in np.linspace(0.0, 1.0, 11).tolist():
        rest = (rho - (1.0 - share) * open_rho) / max(share, 1e-9)
        own = nearest_autocorrelation(times, rest.clip(-1.0, 1.0).tolist(), weights, smooth=True)
        made = (1.0 - share) * open_rho + share * np.array([own.correlation(t) for t in times])
        error = float(np.nansum(np.array(weights) * np.square(made - rho)))
        if error < least - 1e-12:
            least, best = error, (round(share, 4), own)
    return best


def fit_shared(events: RatedEvents, step: float) -> tuple[float, float]:
    """The share of the latent that all objects of a frame have in common, and its seconds.

    What two objects of a drive share a second apart is the drive (its light, its labels) and
    not the frame; only what they share beyond that counts.
    """
    moments = (events.ids // DRIVE_ID_STRIDE) * DRIVE_ID_STRIDE + events.frames
    order = np.argsort(moments, kind="stable")
    events, moments = events.select(order), moments[order]
    correlations = []
    for lag in FRAME_LAGS:
        first, second = same_frame_pairs(moments + lag, moments)
        pairs = events.ids[first] != events.ids[second]
        first, second = first[pairs], second[pairs]
        if len(first) < MIN_SHARED_PAIRS:
            return 0.0, 0.0
        correlations.append(events.latent_correlation(first, second))
    at_once, soon, late = correlations
    shared = max(at_once - late, 0.0)
    kept = (soon - late) / shared if shared > 0.0 else 0.0
    seconds = -step / np.log(np.clip(kept, 0.05, 0.9)) if kept > 0.05 else 0.0
    return round(shared, 4), round(float(seconds), 4)


def without_shared(
    autocorrelation: Autocorrelation, shared: float, seconds: float, step: float
) -> Autocorrelation:
    """The autocorrelation of what the objects do not share."""
    times = [lag * step for lag in LAGS]
    of_frame = Autocorrelation((1.0,), (seconds,))
    rest = [
        (autocorrelation.correlation(t) - shared * of_frame.correlation(t)) / (1.0 - shared)
        for t in times
    ]
    return nearest_autocorrelation(times, [min(rho, 1.0) for rho in rest], [1.0] * len(LAGS))


def fit_confusion(found: Found, false: FalseBoxes, misses: Misses, step: float) -> Confusion:
    """The rates of vans and trucks, over what would be found if they were cars."""
    kinds = found.sightings.kinds
    as_cars = 1.0 - misses.rates(found.sightings)
    vans, trucks = kinds == "Van", kinds == "Truck"
    van, truck = 1.0, 0.0
    if vans.any():
        van = min(float((found.hit[vans].sum() + 0.5) / (as_cars[vans].sum() + 1.0)), 1.0)
    if trucks.any():
        near = false.nearest[false.iou >= 0.5]
        on_trucks = float(np.isin(near, np.flatnonzero(trucks)).sum())
        truck = min((on_trucks + 0.5) / (float(as_cars[trucks].sum()) + 1.0), 1.0)
    autocorrelation = Autocorrelation((1.0,), (5.0,))
    if vans.sum() > MIN_VANS and 0.02 < van < 0.98:
        events = RatedEvents(found.hit, van * as_cars, found.ids, found.frames)
        autocorrelation = latent_autocorrelation(events.select(vans), step)
    return Confusion(round(van, 4), round(truck, 4), autocorrelation)
