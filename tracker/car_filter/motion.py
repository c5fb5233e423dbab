"""How cars move between two frames: parked ones not at all, others as far as they face."""

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
DIAGONAL = np.arange(STATE_SIZE)


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
        way = states[:, YAW] + 0.5 * step.dt * states[:, YAW_RATE]  # halfway
        distance = step.dt * states[:, SPEED]
        later = states.copy()
        later[:, 0] += distance * np.cos(way)
        later[:, 2] -= distance * np.sin(way)
        later[:, :3] = later[:, :3].dot(step.T_road[:3, :3].T) + step.T_road[:3, 3]
        later[:, YAW] += step.turn + step.dt * states[:, YAW_RATE]
        later[:, YAW_RATE] *= np.exp(-step.dt / self.turn_time)
        before, now = step.slopes
        distance = np.sqrt(later[:, 0] ** 2 + later[:, 2] ** 2)
        keep = np.exp(-step.dt / self.off_road_time)
        later[:, 1] = now * distance + keep * (later[:, 1] - before * distance)
        mean, keep_size = step.log_size, np.exp(-step.dt / self.size_time)
        later[:, LOG_SIZE] = mean + keep_size * (states[:, LOG_SIZE] - mean)
        return later

    def __call__(
        self,
        states: Float[Array, "h 9"],
        covs: Float[Array, "h 9 9"],
        moving: Bool[Array, " h"],
        step: RoadStep,
    ) -> tuple[Float[Array, "h 9"], Float[Array, "h 9 9"], Float[Array, "h 9 9"]]:
        """States, covariances and transitions after a step, in the road frame of then."""
        h, R, dt = len(states), step.T_road[:3, :3], step.dt
        later = self.moved(states, step)
        way = states[:, YAW] + 0.5 * dt * states[:, YAW_RATE]
        c, s = np.cos(way), np.sin(way)
        facing, turned = np.zeros((h, 3)), np.zeros((h, 3))
        facing[:, 0], facing[:, 2] = dt * c, -dt * s
        pace = dt * states[:, SPEED]
        turned[:, 0], turned[:, 2] = -s * pace, -c * pace
        keep_rate = np.exp(-dt / self.turn_time)
        keep = np.exp(-dt / self.off_road_time)
        keep_size = np.exp(-dt / self.size_time)
        F = np.zeros((h, STATE_SIZE, STATE_SIZE))
        F[:, DIAGONAL, DIAGONAL] = 1.0
        F[:, :3, :3] = R
        F[:, :3, YAW] = turned.dot(R.T)
        F[:, :3, SPEED] = facing.dot(R.T)
        F[:, :3, YAW_RATE] = 0.5 * dt * F[:, :3, YAW]
        F[:, YAW, YAW_RATE] = dt
        F[:, YAW_RATE, YAW_RATE] = keep_rate
        F[:, 1] *= keep
        F[:, LOG_SIZE] *= keep_size
        covs = F @ covs @ F.transpose(0, 2, 1)
        distance = np.sqrt(later[:, 0] ** 2 + later[:, 2] ** 2)
        noise = np.zeros((h, STATE_SIZE))
        noise[:, 0] = noise[:, 2] = self.drift_std**2 * dt
        noise[:, 1] = (1.0 - keep**2) * step.roughness * self.off_road_var(distance)
        pace = np.minimum(1.0, states[:, SPEED] / TURNING_SPEED + STANDING_TURN)
        noise[:, YAW] = np.where(moving, self.turn_std**2 * dt * pace, PARKED_TURN_STD**2 * dt)
        noise[:, YAW_RATE] = moving * ((1.0 - keep_rate**2) * pace * self.yaw_rate_std**2)
        noise[:, SPEED] = moving * (self.acceleration_std**2 * 0.1 * dt)
        covs[:, DIAGONAL, DIAGONAL] += noise
        covs[:, LOG_SIZE, LOG_SIZE] += (1.0 - keep_size**2) * step.log_size_cov
        return later, covs, F

    def off_road_var(self, distance: Float[Array, "*n"]) -> Float[Array, "*n"]:
        """Variance of how far bases lie off the road at these distances, m^2."""
        at_camera, per_metre = self.off_road_std
        variance: Float[Array, "*n"] = (at_camera + per_metre * distance) ** 2
        return variance


def ego_motion_cov(
    places: Float[Array, "h 3"], motion_cov: Float[Array, "6 6"], camera: Camera
) -> Float[Array, "h 3 3"]:
    """What an uncertain motion of the camera adds to the covariance of places in the road frame.

    motion_cov: as in `Frame`. A point X of the camera's frame shifts by rho + phi x X.
    """
    X = places.dot(camera.T_cam_road[:3, :3].T) + camera.T_cam_road[:3, 3]
    shift = np.zeros((len(X), 3, 6))
    shift[:, 0, 0] = shift[:, 1, 1] = shift[:, 2, 2] = 1.0
    shift[:, 0, 4], shift[:, 0, 5] = X[:, 2], -X[:, 1]
    shift[:, 1, 3], shift[:, 1, 5] = -X[:, 2], X[:, 0]
    shift[:, 2, 3], shift[:, 2, 4] = X[:, 1], -X[:, 0]
    J = (camera.T_road_cam[:3, :3].dot(shift)).transpose(1, 0, 2)
    return J @ motion_cov @ J.transpose(0, 2, 1)
