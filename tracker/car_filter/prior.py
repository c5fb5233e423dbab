"""What is believed of a car before its first box: anywhere near its place, facing any way."""

from functools import lru_cache

import numpy as np
from jaxtyping import Float
from numpy import ndarray as Array

from tracker.car_filter.motion import CarMotion
from tracker.car_filter.states import (
    HEADING_COUNT,
    HYPOTHESIS_COUNT,
    LOG_SIZE,
    MOVING,
    SPEED,
    STATE_SIZE,
    YAW,
    YAW_RATE,
)

HEADINGS = -0.5 * np.pi + np.arange(HEADING_COUNT) * (2.0 * np.pi / HEADING_COUNT)
# Std of each start heading: a quarter of the step between them, rad.
HEADING_STD = 0.5 * np.pi / HEADING_COUNT
# Of a new car's place: along the ray a share of the distance and metres; across it.
START_RADIAL_STD, START_LATERAL_STD = (0.18, 1.0), (0.03, 0.5)


def prior_states(
    places: Float[Array, "n 3"],
    size: tuple[float, float, float],
    log_size: tuple[Float[Array, "3"], Float[Array, "3 3"]],
    speed: tuple[float, float],
    road: tuple[float | Float[Array, " n"], float | Float[Array, " n"], CarMotion],
) -> tuple[Float[Array, "n k 9"], Float[Array, "n k 9 9"]]:
    """States and covariances of new cars before their first boxes.

    places: centres of mean cars' bases that look down the road. size: of those; log_size: of all
    cars, with its covariance. speed: mean and std of moving ones. road: roughness, slope, motion.
    """
    roughness, slope, motion = road
    n, distance = len(places), np.hypot(places[:, 0], places[:, 2])
    ray = places[:, ::2] / np.maximum(distance, 1e-3)[:, None]
    means = np.zeros((n, HYPOTHESIS_COUNT, STATE_SIZE))
    nearer = _nearer(size)
    means[:, :, :3:2] = places[:, None, ::2] + ray[:, None] * nearer[None, :, None]
    means[:, :, 1] = (roughness * slope * distance)[:, None]
    means[:, :, YAW] = _HEADINGS_TWICE
    means[:, MOVING, SPEED] = speed[0]
    means[:, :, LOG_SIZE] = log_size[0]
    covs = np.zeros((n, HYPOTHESIS_COUNT, STATE_SIZE, STATE_SIZE))
    radial, lateral = (
        np.square(share * distance + metres)
        for share, metres in (START_RADIAL_STD, START_LATERAL_STD)
    )
    along = ray[:, :, None] * ray[:, None, :]
    ground = along * (radial - lateral)[:, None, None] + _EYE * lateral[:, None, None]
    covs[:, :, :3:2, :3:2] = ground[:, None]
    covs[:, :, 1, 1] = (roughness * motion.off_road_var(distance))[:, None]
    covs[:, :, YAW, YAW] = HEADING_STD**2
    covs[:, MOVING, SPEED, SPEED] = speed[1] ** 2
    covs[:, MOVING, YAW_RATE, YAW_RATE] = motion.yaw_rate_std**2
    covs[:, :, LOG_SIZE, LOG_SIZE] = log_size[1]
    return means, covs


_EYE, _HEADINGS_TWICE = np.eye(2), np.tile(HEADINGS, 2)


@lru_cache(maxsize=16)
def _nearer(size: tuple[float, float, float]) -> Float[Array, " k"]:
    """How much nearer the centres are by each heading than of the car that looks down the road."""
    extent = 0.5 * (size[0] * np.abs(np.sin(HEADINGS)) + size[2] * np.abs(np.cos(HEADINGS)))
    nearer: Float[Array, " k"] = np.tile(extent - 0.5 * size[0], 2)
    return nearer
