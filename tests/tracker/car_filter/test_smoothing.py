"""Cars of known identity: the way back is filterpy's smoother, and better than the way there."""

from dataclasses import replace

import numpy as np
from filterpy.kalman import KalmanFilter

from tests.tracker.samples import LEVEL, outlines
from tracker.car_filter import (
    CarFilter,
    FilteredFrame,
    FollowedCars,
    RoadModel,
    SeenCars,
    follow_cars,
    smooth_cars,
)
from tracker.car_filter.states import HYPOTHESIS_COUNT
from tracker.geometry import homogeneous
from tracker.types import Cuboids, Detections

COUNT, STEP, SIZE = 30, 0.7, (4.1, 1.55, 1.65)
FLAT = CarFilter(road=RoadModel(slope_std=0.0))


def passed_car(noise: float) -> tuple[list[SeenCars], np.ndarray]:
    """A parked car at (4, 40) that the camera drives by; missed in frames 11 to 14."""
    rng, frames = np.random.default_rng(3), []
    motion = homogeneous(t=np.array([0.0, 0.0, -STEP]))
    places = np.array([[4.0, 0.0, 40.0 - STEP * index] for index in range(COUNT)])
    for index, place in enumerate(places):
        car = Cuboids(place[None], np.array([-np.pi / 2]), np.array([SIZE]))
        box = outlines(car, LEVEL)
        box += noise * (box[:, 3:] - box[:, 1:2]) * rng.normal(size=(1, 4))
        seen = np.array([7] if not 11 <= index < 15 else [], np.int64)
        k = len(seen)
        frames.append(
            SeenCars(
                0.1 if index else 0.0,
                motion if index else np.eye(4),
                np.zeros((6, 6)),
                seen,
                Detections.of(box[:k]),
                place[None][:k],
                box[:k],
            )
        )
    return frames, places


def test_the_way_back_places_the_car_better_than_the_way_there() -> None:
    seen, places = passed_car(noise=0.03)
    cars, filtered = FollowedCars.none(), []
    for frame in seen:
        filtered.append(follow_cars(FLAT, cars, frame, np.ones(len(cars.ids), bool), LEVEL))
        cars = filtered[-1].cars
    assert all(frame.cars.ids.tolist() == [7] for frame in filtered)
    there = [FLAT.estimate(frame.cars.states, frame.cars.memory) for frame in filtered]
    back = list(smooth_cars(FLAT, filtered))[::-1]
    off = [
        np.array(
            [
                np.hypot(*(cars.means[0, :3:2] - place[::2]))
                for cars, place in zip(way, places, strict=True)
            ]
        )
        for way in (there, back)
    ]
    assert np.mean(off[1][:20]) < 0.9 * np.mean(off[0][:20])
    assert np.max(off[1][:20]) < 0.5 * np.max(off[0][:20])
    assert off[1][11:15].max() < 1.0  # in the gap
    variances = [np.array([cars.covs[0, 2, 2] for cars in way]) for way in (there, back)]
    assert (variances[1][1:20] < variances[0][1:20] * 1.5).all()


def test_the_way_back_is_filterpys_smoother() -> None:
    seen, _ = passed_car(noise=0.01)
    cars, filtered = FollowedCars.none(), []
    for frame in seen[:10]:
        filtered.append(follow_cars(FLAT, cars, frame, np.ones(len(cars.ids), bool), LEVEL))
        cars = filtered[-1].cars
    slot = int(FLAT.weights(cars.states, cars.memory)[0].argmax())
    certain = np.full((1, HYPOTHESIS_COUNT), -np.inf)
    certain[0, slot] = 0.0
    states = cars.states.replaced(log_weights=certain)
    filtered[-1] = replace(filtered[-1], cars=replace(cars, states=states))
    back = list(smooth_cars(FLAT, filtered))[::-1]
    means = np.array([frame.cars.states.means[0, slot] for frame in filtered])
    covs = np.array([frame.cars.states.covs[0, slot] for frame in filtered])
    kalman = KalmanFilter(dim_x=9, dim_z=1)
    for k in range(8, -1, -1):  # a step at a time: the motion is no linear one
        predicted = filtered[k + 1].predicted
        F = FLAT.motion.transitions(means[k][None], predicted.step)[0]
        x = predicted.states.means[0, slot]
        Q = predicted.states.covs[0, slot] - F @ covs[k] @ F.T + 1e-9 * np.eye(9)
        shifted = np.array([means[k], means[k + 1] - x + F @ means[k]])
        kalman.F = F
        xs, Ps, *_ = kalman.rts_smoother(shifted, covs[k : k + 2], Fs=[F, F], Qs=[Q, Q])
        means[k], covs[k] = xs[0], Ps[0]
        np.testing.assert_allclose(back[k].means[0], means[k], rtol=1e-5, atol=1e-6)


def turned_car(car_filter: CarFilter) -> tuple[list[FilteredFrame], np.ndarray]:
    """The parked car without noise, which stands across the road from frame 20 on."""
    seen, places = passed_car(noise=0.0)
    cars, filtered = FollowedCars.none(), []
    for index in range(20, 26):
        box = outlines(Cuboids(places[index][None], np.zeros(1), np.array([SIZE])), LEVEL)
        seen[index] = seen[index]._replace(found=Detections(box, np.ones(1)), others=box)
    for frame in seen[:26]:
        kept = np.ones(len(cars.ids), bool)
        filtered.append(follow_cars(car_filter, cars, frame, kept, LEVEL))
        cars = filtered[-1].cars
    return filtered, places


def test_a_car_that_no_hypothesis_explains_begins_anew_and_leaves_its_past_alone() -> None:
    across, off = [], []
    for car_filter in (FLAT, replace(FLAT, max_misfit=np.inf)):
        filtered, places = turned_car(car_filter)
        now = car_filter.estimate(filtered[-1].cars.states, filtered[-1].cars.memory)
        across.append(abs(float(np.cos(now.means[0, 3]))))
        at_15 = list(smooth_cars(car_filter, filtered))[25 - 15]  # the last frame comes first
        off.append(float(np.hypot(*(at_15.means[0, :3:2] - places[15, ::2]))))
    assert across[0] > 0.95
    assert across[1] < 0.5
    assert off[0] < 0.6
    assert off[1] > 2.0
