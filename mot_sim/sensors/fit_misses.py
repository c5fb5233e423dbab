"""Fits who is missed, in what bursts, and which vans and trucks are taken for cars."""

from dataclasses import replace

import numpy as np
from jaxtyping import Bool, Float, Int
from numpy import ndarray as Array
from scipy.special import expit

from mot_sim.metrics.overlaps import same_frame_pairs
from mot_sim.sensors.confusion import Confusion
from mot_sim.sensors.measure import APART, FalseBoxes, Found
from mot_sim.sensors.memory import Memory
from mot_sim.sensors.misses import CUTS, HEIGHTS, VISIBLE, Misses, hat
from mot_sim.sensors.statistics import lagged
from mot_sim.sensors.tetrachoric import correlation_of, memory_of

LAGS = (1, 2, 3, 5, 8, 12, 20, 40)
FRAME_LAGS = (0, 1, 10)  # frames between two objects, to tell a frame's glare from the drive
RIDGE = 0.2  # the strength with which a table is held near 0
HIDDEN_DROP = 2.0  # log-odds from .35 visible to .05, of which labels tell nothing


def fit_misses(found: Found, step: float) -> Misses:
    """Of cars: a logistic curve over the tables of `Misses`, then the memory of its latent."""
    cars = found.select(found.sightings.kinds == "Car")
    sightings = cars.sightings
    logs = np.log(np.maximum(sightings.height, 1.0))
    visible, heights = hat(sightings.visible, VISIBLE), hat(logs, tuple(np.log(HEIGHTS)))
    both = (visible[:, 1:, None] * heights[:, None, :]).reshape(len(cars), -1)
    tables = visible[:, 1:3], heights, hat(sightings.cut, CUTS)[:, 1:], both  # against .95, uncut
    design = np.concatenate((np.ones((len(cars), 1)), *tables), axis=1)
    base, half, partly, *rest = logistic(design, cars.hit).tolist()
    count = len(HEIGHTS)
    together = rest[count + len(CUTS) - 1 :]
    misses = Misses(
        base=base,
        by_visible=(half - HIDDEN_DROP, half, partly, 0.0),
        by_height=tuple(rest[:count]),
        by_cut=(0.0, *rest[count : count + len(CUTS) - 1]),
        by_both=(*together[:count], *together),  # what is nearly hidden as what is half hidden
    )
    # How far a car is cut is known by three levels only: what changes there is the rate.
    whole = cars.select(sightings.cut == 0.0)
    rates = misses.rates(whole.sightings)
    shared, seconds = frame_memory(~whole.hit, rates, whole, step)
    memory = event_memory(~whole.hit, rates, whole.ids, whole.frames, step)
    if shared > 0.0:  # what remains for the object's own latent
        memory = memory_of_rest(memory, shared, seconds, step)
    return replace(misses, memory=memory, shared=shared, shared_seconds=seconds)


def logistic(design: Float[Array, "n k"], event: Bool[Array, " n"]) -> Float[Array, " k"]:
    """Coefficients by penalised maximum likelihood (Newton's steps); the first is free."""
    beta = np.zeros(design.shape[1])
    penalty = np.full(len(beta), RIDGE)
    penalty[0] = 1e-3
    for _ in range(30):
        p = expit(design @ beta)
        slope = design.T @ (event - p) - penalty * beta
        curve = (design * (p * (1.0 - p))[:, None]).T @ design + np.diag(penalty)
        move = np.linalg.solve(curve, slope)
        beta = beta + move.clip(-2.0, 2.0)
        if np.abs(move).max() < 1e-6:
            break
    return beta


def event_memory(
    event: Bool[Array, " n"],
    rates: Float[Array, " n"],
    ids: Int[Array, " n"],
    frames: Int[Array, " n"],
    step: float,
) -> Memory:
    """The memory of the latent behind an event with known rates.

    Neighbouring frames weigh most: they decide how many bursts there are. (Real detectors are
    smoother there than any AR(1): nearly .95 after one frame, .6 after five.)
    """
    correlations, weights = [], []
    for lag in LAGS:
        first, second = lagged(ids, frames, lag)
        correlations.append(
            correlation_of(rates[first], rates[second], event[first], event[second])
        )
        weights.append(len(first) / lag**3)
    return memory_of([lag * step for lag in LAGS], correlations, weights)


def frame_memory(
    event: Bool[Array, " n"], rates: Float[Array, " n"], found: Found, step: float
) -> tuple[float, float]:
    """The share of the latent that all objects of a frame have in common, and its seconds.

    What two objects of a drive share a second apart is the drive (its light, its labels) and
    not the frame; only what they share beyond that counts.
    """
    moments = (found.ids // APART) * APART + found.frames
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


def memory_of_rest(memory: Memory, shared: float, seconds: float, step: float) -> Memory:
    """The memory of what the objects do not share."""
    times = [lag * step for lag in LAGS]
    glare = Memory((1.0,), (seconds,))
    rest = [
        min((memory.correlation(t) - shared * glare.correlation(t)) / (1.0 - shared), 1.0)
        for t in times
    ]
    return memory_of(times, rest, [1.0] * len(LAGS))


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
    memory = Memory((1.0,), (5.0,))
    if vans.sum() > 200 and 0.02 < van < 0.98:
        memory = event_memory(
            found.hit[vans], van * would[vans], found.ids[vans], found.frames[vans], step
        )
    return Confusion(round(van, 4), round(truck, 4), memory)
