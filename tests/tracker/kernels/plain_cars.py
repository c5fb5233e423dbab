"""The car filter's steps in plain NumPy: what the kernels must equal."""

import math

import numpy as np
from jaxtyping import Bool, Float
from numpy import ndarray as Array

from tests.tracker.kernels.plain_boxes import plain_project_boxes
from tests.tracker.kernels.plain_hypotheses import plain_censored
from tracker.car_filter import CarFilter, CarMotion, project_boxes
from tracker.car_filter.carried_boxes import MAX_GROWTH
from tracker.car_filter.filter import MAX_DEVIATION
from tracker.car_filter.motion import (
    GROUND,
    PARKED_TURN_STD,
    STANDING_TURN,
    TURNING_SPEED,
    RoadStep,
    _by_motion,
)
from tracker.car_filter.states import LOG_SIZE, SPEED, STATE_SIZE, YAW, YAW_RATE
from tracker.types import Camera

DIAGONAL = slice(0, STATE_SIZE**2, STATE_SIZE + 1)  # of covariances as rows
# Of each edge of a box those that are taken into account after it.
LATER_EDGES = [slice(edge + 1, 4) for edge in range(4)]


def plain_moved(
    self: CarMotion, states: Float[Array, "h 9"], step: RoadStep
) -> Float[Array, "h 9"]:
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


def plain_motion(
    self: CarMotion,
    states: Float[Array, "h 9"],
    covs: Float[Array, "h 9 9"],
    moving: Bool[Array, " h"],
    step: RoadStep,
) -> tuple[Float[Array, "h 9"], Float[Array, "h 9 9"]]:
    """States and covariances after a step, in the road frame of then."""
    dt, later = step.dt, plain_moved(self, states, step)
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
    covs.reshape(len(covs), STATE_SIZE**2)[:, DIAGONAL] += noise
    kept = math.exp(-2.0 * dt / self.size_time)
    covs[:, LOG_SIZE, LOG_SIZE] += (1.0 - kept) * step.log_size_cov
    return later, covs


def plain_ego_motion_cov(
    places: Float[Array, "h 3"], motion_cov: Float[Array, "6 6"], camera: Camera
) -> Float[Array, "h 3 3"]:
    """What an uncertain motion of the camera adds to the covariance of places in the road frame.

    motion_cov: as in `Frame`. A point X of the camera's frame shifts by rho + phi x X.
    """
    shift = places.dot(camera.place_shift[:3]) + camera.place_shift[3]
    from_motion = shift.reshape(-1, 6).dot(motion_cov).reshape(-1, 3, 6)
    cov: Float[Array, "h 3 3"] = from_motion @ shift.reshape(-1, 3, 6).transpose(0, 2, 1)
    return cov


def plain_update(
    self: CarFilter,
    means: Float[Array, "h 9"],
    covs: Float[Array, "h 9 9"],
    boxes: Float[Array, "h 4"],
    variances: Float[Array, "h 4"],
    camera: Camera,
    linear: Float[Array, "h 9"] | None = None,
) -> tuple[Float[Array, "h 9"], Float[Array, "h 9 9"], Float[Array, " h"], Float[Array, " h"]]:
    """States, covariances, log-likelihoods and squared deviations after boxes, edge by edge.

    That is the joint update, since the noise is diagonal. Projected by the kernel, which has a test
    of its own: beside the camera the update magnifies what the two round differently.

    linear: the states at which the projection is linearised; None: at the means.
    """
    expected, H = project_boxes(means if linear is None else linear, camera)
    off = boxes - expected
    if linear is not None:
        off -= (H @ (means - linear)[:, :, None])[:, :, 0]
    told = ~plain_censored(self.edges, boxes, expected, camera)
    # covariances of each edge with the states, and with the edges: both without the noise
    by_state = H @ covs
    by_edge = by_state @ H.transpose(0, 2, 1)
    var, bounded = np.empty_like(off), np.empty_like(off)
    for edge, later in enumerate(LATER_EDGES):
        var[:, edge] = by_edge[:, edge, edge] + variances[:, edge]
        limit = MAX_DEVIATION * np.sqrt(var[:, edge])
        bounded[:, edge] = np.minimum(np.maximum(off[:, edge], -limit), limit)
        others = by_edge[:, edge, later]
        gain = others * (told[:, edge] / var[:, edge])[:, None]
        off[:, later] -= gain * bounded[:, edge, None]
        by_state[:, later] -= gain[:, :, None] * by_state[:, edge, None]
        by_edge[:, later, later] -= gain[:, :, None] * others[:, None]
    weights = told / var
    squares = weights * bounded**2
    fit = -0.5 * (self.tightness * np.log(var) + squares).sum(axis=1)
    step = ((weights * bounded)[:, None] @ by_state)[:, 0]
    covs = covs - by_state.transpose(0, 2, 1) @ (weights[:, :, None] * by_state)
    return means + step, covs, fit, squares.sum(axis=1)


def plain_carried(
    boxes: Float[Array, "n 4"],
    before: Float[Array, "n 9"],
    after: Float[Array, "n 9"],
    camera: Camera,
) -> Float[Array, "n 4"]:
    """Boxes of cars in state `before`, moved and scaled as their cuboids are until `after`."""
    old, new = (plain_project_boxes(states, camera)[0] for states in (before, after))
    growth = (new[:, 2:] - new[:, :2]) / np.maximum(old[:, 2:] - old[:, :2], 1.0)
    growth = np.minimum(np.maximum(growth, 1.0 / MAX_GROWTH), MAX_GROWTH)
    off = boxes[:, :2] + boxes[:, 2:] - old[:, :2] - old[:, 2:]
    middle = 0.5 * (new[:, :2] + new[:, 2:] + off * growth)
    half = 0.5 * (boxes[:, 2:] - boxes[:, :2]) * growth
    return np.concatenate((middle - half, middle + half), axis=1)
