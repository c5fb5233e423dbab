"""Cars of known identity over many frames: filtered forwards, then smoothed backwards (RTS)."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float, Int
from numpy import ndarray as Array

from tracker.car_filter.estimates import likeliest
from tracker.car_filter.filter import CarFilter, PredictedCars
from tracker.car_filter.road_memory import RoadMemory
from tracker.car_filter.states import HYPOTHESIS_COUNT, STATE_SIZE, YAW, CarStates
from tracker.geometry import wrap_angle
from tracker.types import Camera, CarEstimates, Detections

# Keeps covariances of states that are known exactly (the speed of parked cars) invertible.
MIN_VARIANCE = 1e-9
# How much larger than theirs the stated covariances of smoothed states are, besides
# `CarFilter.stated_covariance`: what is off over a whole track does not average out.
SMOOTHED_COVARIANCE = 1.5


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
    """The predicted hypothesis that each hypothesis was made of."""
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
    return FilteredFrame(before, predicted, parents, after)


@dataclass(frozen=True, eq=False)
class _Smoothed:
    """The way back, at one frame: one hypothesis per track."""

    hypotheses: Int[Array, " n"]
    means: Float[Array, "n 9"]
    covs: Float[Array, "n 9 9"]
    heading_known: Float[Array, " n"]


def smooth_cars(car_filter: CarFilter, frames: Sequence[FilteredFrame]) -> Iterable[CarEstimates]:
    """The cars of each frame by all frames, LAST frame first; one row per track of the frame.

    Rauch, Tung & Striebel, AIAA Journal 1965, along the hypothesis that is likeliest where the
    track ends.
    """
    later: _Smoothed | None = None
    for number in range(len(frames) - 1, -1, -1):
        now = _ends(car_filter, frames[number].cars)
        if later is not None:
            _step_back(now, frames[number].cars, frames[number + 1], later)
        covs = car_filter.stated_covariance * SMOOTHED_COVARIANCE * now.covs
        yield CarEstimates(now.means.copy(), covs, now.heading_known.copy())
        later = now


def _ends(car_filter: CarFilter, cars: FollowedCars) -> _Smoothed:
    """Every track as if it ended here: its likeliest hypothesis as filtered."""
    rows = np.arange(len(cars.ids))
    weights = car_filter.weights(cars.states, cars.memory)
    best, _, heading_known = likeliest(cars.states, weights)
    means, covs = cars.states.means[rows, best], cars.states.covs[rows, best]
    return _Smoothed(best, means, covs, heading_known)


def _step_back(
    now: _Smoothed, cars: FollowedCars, following: FilteredFrame, later: _Smoothed
) -> None:
    """Overwrite, in `now`, the tracks that go on in the following frame."""
    going = np.flatnonzero(following.before >= 0)
    if len(going) == 0:
        return
    rows = following.before[going]
    parents = following.parents[going, later.hypotheses[going]]
    predicted = following.predicted
    mean, cov = cars.states.means[rows, parents], cars.states.covs[rows, parents]
    expected, expected_cov = (
        table[going, parents] for table in (predicted.states.means, predicted.states.covs)
    )
    F = predicted.transitions_of(going, parents)
    regular = expected_cov + MIN_VARIANCE * np.eye(STATE_SIZE)
    gain = np.linalg.solve(regular, F @ cov).transpose(0, 2, 1)
    off = later.means[going] - expected
    off[:, YAW] = wrap_angle(off[:, YAW])
    now.means[rows] = mean + (gain @ off[:, :, None])[:, :, 0]
    change = later.covs[going] - expected_cov
    now.covs[rows] = cov + gain @ change @ gain.transpose(0, 2, 1)
    now.hypotheses[rows] = parents
    now.heading_known[rows] = later.heading_known[going]
