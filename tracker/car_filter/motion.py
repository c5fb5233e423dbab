"""How cars move between two frames: parked ones not at all, others as far as they face."""

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float
from numpy import ndarray as Array

from tracker.car_filter.states import LOG_SIZE, SPEED, STATE_SIZE, YAW, YAW_RATE
from tracker.types import Camera

# Below this speed (m/s) a car turns less; one that stands still turns this share as much.
TURNING_SPEED, STANDING_TURN = 3.0, 0.05
# Std of what a parked car seems to turn in a second, rad.
PARKED_TURN_STD = 0.003
DIAGONAL = slice(0, STATE_SIZE**2, STATE_SIZE + 1)  # of covariances as rows
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
        dt, (before, now) = step.dt, step.slopes
        way = states[:, YAW] + 0.5 * dt * states[:, YAW_RATE]  # halfway
        distance = dt * states[:, SPEED]
        later = states.copy()
        later[:, 0] += distance * np.cos(way)
        later[:, 2] -= distance * np.sin(way)
        later[:, :3] = later[:, :3].dot(step.T_road[:3, :3].T) + step.T_road[:3, 3]
        later[:, YAW] += step.turn + dt * states[:, YAW_RATE]
        later[:, YAW_RATE] *= math.exp(-dt / self.turn_time)
        reach = np.sqrt(later[:, 0] ** 2 + later[:, 2] ** 2)
        later[:, 1] -= before * reach
        later[:, 1] *= math.exp(-dt / self.off_road_time)
        later[:, 1] += now * reach
        later[:, LOG_SIZE] -= step.log_size
        later[:, LOG_SIZE] *= math.exp(-dt / self.size_time)
        later[:, LOG_SIZE] += step.log_size
        return later

    def __call__(
        self,
        states: Float[Array, "h 9"],
        covs: Float[Array, "h 9 9"],
        moving: Bool[Array, " h"],
        step: RoadStep,
    ) -> tuple[Float[Array, "h 9"], Float[Array, "h 9 9"]]:
        """States and covariances after a step, in the road frame of then."""
        dt, later = step.dt, self.moved(states, step)
        # F P F' in two parts: what differs from car to car, then what is the same for all
        driven, shared = _by_motion(states, dt), self._shared(step).T
        covs = covs.copy()
        for _ in range(2):
            turning, pace = covs[:, YAW] + 0.5 * dt * covs[:, YAW_RATE], covs[:, SPEED]
            for row, ground in enumerate(GROUND):
                by_turn, by_pace = driven[:, row, 0, None], driven[:, row, 1, None]
                covs[:, ground] += by_turn * turning + by_pace * pace
            covs = covs.transpose(0, 2, 1)
        for _ in range(2):
            covs = covs.transpose(0, 2, 1).reshape(-1, STATE_SIZE).dot(shared).reshape(covs.shape)
        distance = np.sqrt(later[:, 0] ** 2 + later[:, 2] ** 2)
        noise = np.zeros(states.shape)
        noise[:, 0] = noise[:, 2] = self.drift_std**2 * dt
        kept = math.exp(-2.0 * dt / self.off_road_time)
        noise[:, 1] = (1.0 - kept) * step.roughness * self.off_road_var(distance)
        pace = np.minimum(1.0, states[:, SPEED] / TURNING_SPEED + STANDING_TURN)
        noise[:, YAW] = np.where(moving, self.turn_std**2 * dt * pace, PARKED_TURN_STD**2 * dt)
        kept = math.exp(-2.0 * dt / self.turn_time)
        noise[:, YAW_RATE] = moving * ((1.0 - kept) * self.yaw_rate_std**2 * pace)
        noise[:, SPEED] = moving * (self.acceleration_std**2 * 0.1 * dt)
        covs.reshape(len(covs), -1)[:, DIAGONAL] += noise
        kept = math.exp(-2.0 * dt / self.size_time)
        covs[:, LOG_SIZE, LOG_SIZE] += (1.0 - kept) * step.log_size_cov
        return later, covs

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


def ego_motion_cov(
    places: Float[Array, "h 3"], motion_cov: Float[Array, "6 6"], camera: Camera
) -> Float[Array, "h 3 3"]:
    """What an uncertain motion of the camera adds to the covariance of places in the road frame.

    motion_cov: as in `Frame`. A point X of the camera's frame shifts by rho + phi x X.
    """
    shift = places.dot(camera.place_shift[:3]) + camera.place_shift[3]
    from_motion = shift.reshape(-1, 6).dot(motion_cov).reshape(-1, 3, 6)
    cov: Float[Array, "h 3 3"] = from_motion @ shift.reshape(-1, 3, 6).transpose(0, 2, 1)
    return cov
