"""Traffic whose ego car obeys: its commands, how it drives, and highway-env's reward for that."""

from dataclasses import dataclass
from typing import Protocol, runtime_checkable

import numpy as np

from mot_sim.simulation.traffic.traffic_state import TrafficState

# The first lets the ego car drive itself; the others are highway-env's discrete meta actions.
COMMANDS = ("autopilot", "lane_left", "idle", "lane_right", "faster", "slower")
# The weights of highway-env's HighwayEnv, and the speeds it rewards as parts of the limit: its
# 20 to 30 m/s on a road of 30 m/s.
COLLISION_REWARD = -1.0
RIGHT_LANE_REWARD = 0.1
HIGH_SPEED_REWARD = 0.4
REWARDED_SPEED_SHARES = (2.0 / 3.0, 1.0)


@dataclass(frozen=True)
class Driving:
    """How the ego car drives now."""

    speed: float
    """Along its lane, m/s; negative when it drives against the lane."""
    limit: float
    """Speed limit of its lane, m/s."""
    lane: int
    """Number of its lane, 0 for the leftmost."""
    lanes: int
    """How many lanes lie side by side there, its own included."""
    on_road: bool
    """Whether its centre is on its lane, and its road has not ended."""
    crashed: bool
    """Whether its footprint overlaps another car's."""
    road_ended: bool = False
    """Whether it is past the end of its road."""


@runtime_checkable
class Driven(Protocol):
    """Live traffic whose ego car can be told what to do; see `Traffic`."""

    continuous: bool
    """Whether the ego car begins a new way where its road ends."""

    def reset_live(self, rng: np.random.Generator) -> TrafficState:
        """A new run of which nothing is driven ahead; the first state."""
        ...

    def command(self, name: str) -> None:
        """What the ego car does from now on, one of COMMANDS."""
        ...

    def step(self) -> TrafficState:
        """The state 0.1 s later."""
        ...

    @property
    def has_ended(self) -> bool:
        """Whether the ego car is behind the end of its road."""
        ...

    def driving(self) -> Driving:
        """How the ego car drives now."""
        ...


@runtime_checkable
class Steerable(Driven, Protocol):
    """Live traffic whose ego car takes acceleration and steering."""

    def steer(self, acceleration: float, angle: float) -> None:
        """Hold this acceleration, m/s2, and angle of the front wheels, rad."""
        ...


def driving_reward(driving: Driving) -> float:
    """highway-env's reward of driving, 0 to 1.

    (0.4 fast + 0.1 right - crashed + 1) / 1.5, and 0 off the road. fast: 0 at two thirds of the
    limit, 1 at the limit, linear between, clipped. right: 0 on the leftmost lane, 1 on the
    rightmost of several.
    """
    if not driving.on_road:
        return 0.0
    low, high = (share * driving.limit for share in REWARDED_SPEED_SHARES)
    fast = min(max((driving.speed - low) / (high - low), 0.0), 1.0)
    right = driving.lane / max(driving.lanes - 1, 1)
    reward = (
        HIGH_SPEED_REWARD * fast + RIGHT_LANE_REWARD * right + COLLISION_REWARD * driving.crashed
    )
    return (reward - COLLISION_REWARD) / (HIGH_SPEED_REWARD + RIGHT_LANE_REWARD - COLLISION_REWARD)
