"""How cars move between two frames: parked ones not at all, others as far as they face."""

import math
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from jaxtyping import Float
from numpy import ndarray as Array

from tracker.car_filter.states import (
    LOG_SIZE,
    MIN_LOG_WEIGHT,
    SPEED,
    STATE_SIZE,
    YAW,
    YAW_RATE,
    CarStates,
)
from tracker.kernels import Kernel
from tracker.types import Camera

MOVED = Kernel("tracker.kernels.car_motion", "moved")
PREDICT_CARS = Kernel("tracker.kernels.car_motion", "predict_cars")

# Below this speed (m/s) a car turns less; one that stands still turns this share as much.
TURNING_SPEED, STANDING_TURN = 3.0, 0.05
# Std of what a parked car seems to turn in a second, rad.
PARKED_TURN_STD = 0.003
GROUND = (0, 2)  # columns of a state that driving changes


class RoadStep(NamedTuple):
    """What all cars of a scene share between two frames."""

    T_road: Float[Array, "4 4"]
    """Moves points of the road frame of before into that of now."""
    turn: float
    """Its yaw, rad."""
    dt: float
    """Its duration, s."""
    slopes: tuple[float, float]
    """Of the road in the frame of now: as before the step, and as it is then."""
    roughness: float
    """Factor on the variance of how far bases lie off the road."""
    log_size: Float[Array, "3"]
    """Mean logarithms of all cars' lengths, heights and widths."""
    log_size_cov: Float[Array, "3 3"]
    """Their covariance."""

    @property
    def numbers(self) -> Float[Array, "4"]:
        """Turn, duration and slopes, as the kernels take them."""
        return np.array([self.turn, self.dt, *self.slopes])


@dataclass(frozen=True)
class CarMotion:
    """Goes where it faces, with a speed and heading that change at random."""

    acceleration_std: float = 5.0
    """Std of the acceleration, drawn anew every 0.1 s, m/s^2; more: the speed follows faster."""
    turn_std: float = 0.03
    """Std of the heading after a second of driving, rad, besides the yaw rate."""
    yaw_rate_std: float = 0.07
    """Std of the yaw rate of driving cars, rad/s; more: turns are followed faster."""
    turn_time: float = 2.0
    """Seconds that a turn lasts."""
    drift_std: float = 0.15
    """Std of what the place changes besides in a second, m: the camera's motion is never exact, nor
    is the shape of a car a cuboid's. More: places follow boxes faster, sizes are learned less."""
    size_time: float = 100.0
    """Seconds in which what was learned of a size falls back to what is known of all cars. Sizes do
    not change, but small errors that last (of the road, of boxes) would otherwise add up in them.
    More: sizes are learned better, and drift further."""
    off_road_std: tuple[float, float] = (0.1, 0.008)
    """Std of how far a car's base lies off the road's plane: m, and m per metre of distance."""
    off_road_time: float = 0.67
    """Seconds in which that changes."""

    def moved(self, states: Float[Array, "h 9"], step: RoadStep) -> Float[Array, "h 9"]:
        """States after a step, in the road frame of then."""
        later = np.empty(states.shape)
        MOVED(states, step.T_road, step.numbers, self._times, step.log_size, later)
        return later

    def __call__(
        self, states: CarStates, step: RoadStep, motion_cov: Float[Array, "6 6"], camera: Camera
    ) -> CarStates:
        """What is believed after a step, in the road frame of then; the same weights.

        motion_cov: of the camera, as in `Frame`; a point X of its frame shifts by rho + phi x X.
        Hypotheses that are not followed stay as they are.
        """
        means, covs = np.empty(states.means.shape), np.empty(states.covs.shape)
        off_road = np.array([*self.off_road_std, step.roughness])
        shared = step.T_road, step.numbers, self._times, self._noise, off_road
        sizes, ego = (step.log_size, step.log_size_cov), (camera.place_shift, motion_cov)
        before = states.means, states.covs, states.log_weights, MIN_LOG_WEIGHT
        PREDICT_CARS(*before, *shared, *sizes, *ego, means, covs)
        return CarStates(means, covs, states.log_weights)

    @cached_property
    def _times(self) -> Float[Array, "3"]:
        """Of turns, of what bases lie off the road, of sizes, s."""
        return np.array([self.turn_time, self.off_road_time, self.size_time])

    @cached_property
    def _noise(self) -> Float[Array, "7"]:
        """Variances in a second: see `tracker.kernels.car_motion`."""
        stds = self.drift_std, self.turn_std, self.yaw_rate_std
        acceleration = 0.1 * self.acceleration_std**2
        variances = *np.square(stds), acceleration, PARKED_TURN_STD**2
        return np.array([*variances, TURNING_SPEED, STANDING_TURN])

    def transitions(self, states: Float[Array, "h 9"], step: RoadStep) -> Float[Array, "h 9 9"]:
        """How the states after a step change with these before it: the Jacobians."""
        driven = np.tile(np.eye(STATE_SIZE), (len(states), 1, 1))
        by_motion = _by_motion(states, step.dt)
        driven[:, GROUND, YAW], driven[:, GROUND, SPEED] = by_motion[:, :, 0], by_motion[:, :, 1]
        driven[:, GROUND, YAW_RATE] = 0.5 * step.dt * by_motion[:, :, 0]
        transitions: Float[Array, "h 9 9"] = self._shared(step) @ driven
        return transitions

    def _shared(self, step: RoadStep) -> Float[Array, "9 9"]:
        """The part of the transitions that is the same for all cars."""
        F = np.eye(STATE_SIZE)
        F[:3, :3] = step.T_road[:3, :3]
        F[1] *= math.exp(-step.dt / self.off_road_time)
        F[YAW, YAW_RATE] = step.dt
        F[YAW_RATE, YAW_RATE] = math.exp(-step.dt / self.turn_time)
        F[LOG_SIZE] *= math.exp(-step.dt / self.size_time)
        return F

    def off_road_var(self, distance: Float[Array, "*n"]) -> Float[Array, "*n"]:
        """Variance of how far bases lie off the road at these distances, m^2."""
        at_camera, per_metre = self.off_road_std
        variance: Float[Array, "*n"] = (at_camera + per_metre * distance) ** 2
        return variance


def _by_motion(states: Float[Array, "h 9"], dt: float) -> Float[Array, "h 2 2"]:
    """Derivatives of where cars drive to, on the ground, by yaw and by speed.

    Those by the yaw rate are half of `dt` times those by yaw.
    """
    way = states[:, YAW] + 0.5 * dt * states[:, YAW_RATE]
    c, s, distance = np.cos(way), np.sin(way), dt * states[:, SPEED]
    driven = np.empty((len(states), 2, 2))
    driven[:, 0, 0], driven[:, 1, 0] = -s * distance, -c * distance
    driven[:, 0, 1], driven[:, 1, 1] = dt * c, -dt * s
    return driven
