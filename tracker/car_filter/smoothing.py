"""Cars of known identity over many frames: filtered forwards, then smoothed backwards (RTS)."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float, Int
from numpy import ndarray as Array

from tracker.car_filter.estimates import estimate
from tracker.car_filter.filter import CarFilter, PredictedCars
from tracker.car_filter.motion import CarMotion
from tracker.car_filter.road_memory import RoadMemory
from tracker.car_filter.states import HYPOTHESIS_COUNT, STATE_SIZE, YAW, CarStates, normalised
from tracker.geometry import wrap_angle
from tracker.types import Camera, CarEstimates, Detections

# Keeps covariances of states that are known exactly (the speed of parked cars) invertible.
MIN_VARIANCE = 1e-9
# How much larger than theirs the stated covariances of smoothed states are, besides
# `CarFilter.stated_covariance`: what is off over a whole track does not average out.
SMOOTHED_COVARIANCE = 1.5
# Hypotheses that are less probable than this where a track ends are not traced back.
MIN_LINEAGE_WEIGHT = 0.01


class SeenCars(NamedTuple):
    """The detections of one frame that belong to tracks, and how the camera came there."""

    dt: float
    """Seconds since the last frame."""
    T_now_before: Float[Array, "4 4"]
    """The camera's motion meanwhile, as in `Frame`."""
    motion_cov: Float[Array, "6 6"]
    """Its covariance."""
    ids: Int[Array, " k"]
    """The track of each detection; no two alike."""
    found: Detections
    """What was detected of them."""
    places: Float[Array, "k 3"]
    """Where `Lift` puts them: needed where a track begins."""
    others: Float[Array, "m 4"]
    """All boxes of the frame, which may hide them."""


@dataclass(frozen=True, eq=False)
class FollowedCars:
    """What is believed of some tracks after a frame."""

    ids: Int[Array, " n"]
    """The tracks."""
    states: CarStates
    """Their hypotheses, one track per row."""
    memory: RoadMemory
    """What is known of the road."""

    @classmethod
    def none(cls) -> "FollowedCars":
        """No track, and nothing known."""
        return cls(np.zeros(0, np.int64), CarStates.empty(), RoadMemory())

    def select(self, kept: Bool[Array, " n"]) -> "FollowedCars":
        """Only these tracks."""
        return FollowedCars(self.ids[kept], self.states.select(kept), self.memory)


@dataclass(frozen=True, eq=False)
class FilteredFrame:
    """One frame of the forward pass, with what the way back needs."""

    before: Int[Array, " n"]
    """Row of each track in the frame before; -1: it begins here."""
    predicted: PredictedCars
    """Of the tracks of the frame before that go on, in the order of rows here."""
    parents: Int[Array, "n k"]
    """The predicted hypothesis that each hypothesis was made of; -1: it begins here."""
    gains: Float[Array, "h 9 9"]
    """How each of the followed hypotheses follows on the way back what comes out of it here."""
    cars: FollowedCars
    """After the detections."""


def follow_cars(
    car_filter: CarFilter,
    cars: FollowedCars,
    seen: SeenCars,
    kept: Bool[Array, " n"],
    camera: Camera,
) -> FilteredFrame:
    """The next frame of the forward pass. kept: the tracks that go on, seen in it or not."""
    going = cars if kept.all() else cars.select(kept)
    motion = seen.T_now_before, seen.motion_cov, seen.dt, camera
    predicted = car_filter.predict(going.states, going.memory, *motion)
    order = np.argsort(going.ids)
    at = np.searchsorted(going.ids, seen.ids, sorter=order)
    at[at == len(order)] = 0
    is_known = (
        np.zeros(len(seen.ids), bool) if len(order) == 0 else going.ids[order[at]] == seen.ids
    )
    rows = order[at[is_known]] if len(order) else np.zeros(0, np.int64)
    known, born = seen.found.select(is_known), seen.found.select(~is_known)
    updated = car_filter.update(
        predicted.states.select(rows), predicted.memory, known, seen.others, seen.dt, camera
    )
    parents = np.tile(np.arange(HYPOTHESIS_COUNT), (len(going.ids) + len(born), 1))
    parents[rows] = updated.parents
    states = predicted.states.updated(rows, updated.states) if len(rows) else predicted.states
    if len(born):
        new = car_filter.start(updated.memory, seen.places[~is_known], born, seen.others, camera)
        states = CarStates.concatenate((states, new))
    before = np.concatenate((np.flatnonzero(kept), np.full(len(born), -1)))
    ids = np.concatenate((going.ids, seen.ids[~is_known]))
    after = FollowedCars(ids, states, updated.memory)
    gains = _gains(car_filter.motion, going.states, predicted)
    return FilteredFrame(before, predicted, parents, gains, after)


def _gains(motion: CarMotion, states: CarStates, predicted: PredictedCars) -> Float[Array, "h 9 9"]:
    """The smoother's gains: of the states before a prediction, hypothesis by hypothesis."""
    expected = predicted.states.covs[predicted.at] + MIN_VARIANCE * np.eye(STATE_SIZE)
    transitions = motion.transitions(states.means[predicted.at], predicted.step)
    moved = transitions @ states.covs[predicted.at]
    # contiguous, or products with what was kept and given back are rounded otherwise
    gains: Float[Array, "h 9 9"] = np.linalg.solve(expected, moved).transpose(0, 2, 1).copy()
    return gains


class _Lineages(NamedTuple):
    """The way back, at one frame: the hypotheses of each track's end, traced back to here."""

    states: CarStates
    """Smoothed; a column for each hypothesis of the track's end, with its weight there."""
    hypotheses: Int[Array, "n k"]
    """The hypothesis of this frame that each of those was made of."""


def smooth_cars(car_filter: CarFilter, frames: Sequence[FilteredFrame]) -> Iterable[CarEstimates]:
    """The cars of each frame by all frames, LAST frame first; one row per track of the frame.

    Rauch, Tung & Striebel, AIAA Journal 1965, along every hypothesis that is likely where the
    track ends; means and covariances are over those.
    """
    for lineages, frame in zip(_back(car_filter, frames), reversed(frames), strict=True):
        yield _stated(car_filter, lineages, frame)


def smooth_first(car_filter: CarFilter, frames: Sequence[FilteredFrame]) -> CarEstimates:
    """The cars of the first of these frames by all of them."""
    *_, first = _back(car_filter, frames)
    return _stated(car_filter, first, frames[0])


def _stated(car_filter: CarFilter, lineages: _Lineages, frame: FilteredFrame) -> CarEstimates:
    """One state per car, with the covariance that rows state."""
    estimates = estimate(lineages.states, np.exp(lineages.states.log_weights))
    return car_filter.stated(estimates, frame.cars.memory, SMOOTHED_COVARIANCE)


def _back(car_filter: CarFilter, frames: Sequence[FilteredFrame]) -> Iterable[_Lineages]:
    """The way back, last frame first."""
    later: _Lineages | None = None
    for number in range(len(frames) - 1, -1, -1):
        now = _ends(car_filter, frames[number].cars)
        if later is not None:
            _step_back(now, frames[number].cars, frames[number + 1], later)
        yield now
        later = now


def _ends(car_filter: CarFilter, cars: FollowedCars) -> _Lineages:
    """Every track as if it ended here: its likely hypotheses as filtered."""
    weights = car_filter.weights(cars.states, cars.memory)
    weights[weights < MIN_LINEAGE_WEIGHT] = 0.0
    weights /= weights.sum(axis=1, keepdims=True)
    with np.errstate(divide="ignore"):
        log_weights = np.log(weights)
    states = CarStates(cars.states.means.copy(), cars.states.covs.copy(), log_weights)
    return _Lineages(states, np.tile(np.arange(HYPOTHESIS_COUNT), (len(cars.ids), 1)))


def _step_back(
    now: _Lineages, cars: FollowedCars, following: FilteredFrame, later: _Lineages
) -> None:
    """Overwrite, in `now`, the tracks that go on in the following frame."""
    going = np.flatnonzero(following.before >= 0)
    if len(going) == 0:
        return
    parents = np.take_along_axis(following.parents[going], later.hypotheses[going], axis=1)
    log_weights = np.where(parents >= 0, later.states.log_weights[going], -np.inf)
    known = log_weights.max(axis=1) > -np.inf  # else the car begins anew there
    now.states.log_weights[following.before[going[known]]] = normalised(log_weights[known])
    rows, columns = np.isfinite(log_weights).nonzero()
    parents = parents[rows, columns]
    at, source, end = (following.before[rows], columns), (rows, parents), (rows, columns)
    earlier = following.before[rows], parents
    predicted = following.predicted.states
    gain = following.gains[following.predicted.places_of(rows, parents)]
    off = later.states.means[end] - predicted.means[source]
    off[:, YAW] = wrap_angle(off[:, YAW])
    now.states.means[at] = cars.states.means[earlier] + (gain @ off[:, :, None])[:, :, 0]
    change = later.states.covs[end] - predicted.covs[source]
    now.states.covs[at] = cars.states.covs[earlier] + gain @ change @ gain.transpose(0, 2, 1)
    now.hypotheses[at] = parents
