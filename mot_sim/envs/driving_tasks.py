"""What the ego car of live traffic may be told, and what that earns.

Actions, their order and ranges are those of highway-env (E. Leurent, 2018), at 10 Hz.
"""

from collections.abc import Callable
from typing import Any

import numpy as np
from gymnasium import spaces
from numpy import ndarray as Array

from mot_sim.simulation.traffic.driving import (
    COMMANDS,
    Driven,
    Driving,
    Steerable,
    driving_reward,
)
from tracker.errors import BadConfig

# highway-env's DiscreteMetaAction in its order; the one that lets the ego car drive itself is last.
META_ACTIONS = ("lane_left", "idle", "lane_right", "faster", "slower", "autopilot")
assert sorted(META_ACTIONS) == sorted(COMMANDS)
WATCH_ACTIONS = ("watch",)  # recorded traffic cannot answer
# highway-env's ContinuousAction.
MAX_ACCELERATION = 5.0  # m/s2 at throttle 1
MAX_STEERING = np.pi / 4.0  # radians of the front wheels at steering 1


def progress_reward(driving: Driving) -> float:
    """The share of the speed limit that it drives along its lane, 0 to 1; -1 for a crash.

    0 for who stands, drives against the lane or is off the road.
    """
    if driving.crashed:
        return -1.0
    if not driving.on_road:
        return 0.0
    return min(max(driving.speed / driving.limit, 0.0), 1.0)


REWARDS: dict[str, Callable[[Driving], float]] = {
    "progress": progress_reward,
    "highway_env": driving_reward,
}


def meta_space() -> spaces.Space[Any]:
    """One of META_ACTIONS."""
    return spaces.Discrete(len(META_ACTIONS))


def continuous_space() -> spaces.Space[Any]:
    """Throttle and steering, -1 to 1; to the right is positive."""
    return spaces.Box(-1.0, 1.0, (2,), np.float32)


ACTION_SPACES: dict[str, Callable[[], spaces.Space[Any]]] = {
    "meta": meta_space,
    "continuous": continuous_space,
}


def require_steerable(scene: str, traffic: Driven) -> Steerable:
    """The same traffic. Raises BadConfig where it cannot be steered."""
    if not isinstance(traffic, Steerable):
        raise BadConfig(f"scene {scene} cannot be steered: take actions='meta'")
    return traffic


def apply_action(driver: Driven, action: Any) -> None:
    """Tell the driver a meta action (a number), or throttle and steering, each -1 to 1."""
    if np.ndim(action) == 0:
        driver.command(META_ACTIONS[int(action)])
        return
    assert isinstance(driver, Steerable)  # the space of two numbers is its alone
    throttle, steering = np.clip(np.asarray(action, float), -1.0, 1.0).tolist()
    driver.steer(throttle * MAX_ACCELERATION, steering * MAX_STEERING)


def copied(action: Any) -> Any:
    """An action that the caller cannot change any more."""
    return action.copy() if isinstance(action, Array) else action
