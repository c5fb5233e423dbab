"""highway-env's Kinematics observation: the ego car and its nearest neighbours, as they are."""

from typing import Any

import numpy as np
from gymnasium import spaces
from jaxtyping import Float
from numpy import ndarray as Array

from mot_sim.simulation.traffic.traffic_state import TrafficState

FEATURES = ("presence", "x", "y", "vx", "vy")
RANGE_METRES = 200.0  # of x and y, and how far it sees
RANGE_SPEED = 80.0  # m/s
BEHIND_METRES = 10.0  # cars farther behind are not seen


def kinematic_space(count: int) -> spaces.Space[Any]:
    """FEATURES of so many cars, the ego car first."""
    return spaces.Box(-1.0, 1.0, (count, len(FEATURES)), np.float32)


def observe_kinematics(state: TrafficState, speed: float, count: int) -> Float[Array, "c f"]:
    """FEATURES of the ego car in world, and of the nearest cars ahead less the ego car's.

    speed: of the ego car, m/s. Places are divided by 200 m, speeds by 80 m/s, and clipped to
    [-1, 1]; rows that are not needed are 0. Unlike highway-env: y has the range of x, because
    roads bend.
    """
    x, y, heading = state.ego.tolist()
    velocity = speed * np.array([np.cos(heading), np.sin(heading)])
    places = np.stack((state.x, state.y), axis=1) - (x, y)
    along = places @ (np.cos(heading), np.sin(heading))
    distance = np.hypot(*places.T)
    near = np.flatnonzero((distance < RANGE_METRES) & (along > -BEHIND_METRES))
    near = near[np.argsort(distance[near], kind="stable")][: count - 1]
    directions = np.stack((np.cos(state.heading[near]), np.sin(state.heading[near])), axis=1)
    rows = np.zeros((count, len(FEATURES)))
    rows[0] = 1.0, x / RANGE_METRES, y / RANGE_METRES, *(velocity / RANGE_SPEED)
    seen = slice(1, 1 + len(near))
    rows[seen, 0] = 1.0
    rows[seen, 1:3] = places[near] / RANGE_METRES
    rows[seen, 3:] = (state.speed[near, None] * directions - velocity) / RANGE_SPEED
    return rows.clip(-1.0, 1.0).astype(np.float32)
