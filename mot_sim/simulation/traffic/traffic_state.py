"""One moment of traffic, who touches whom in it, and the protocol of what makes traffic."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol, runtime_checkable

import numpy as np
from jaxtyping import Bool, Float, Int, Shaped
from numpy import ndarray as Array

SPARE_METRES = 1e-6  # for rounding
STEP_SECONDS = 0.1  # seconds from one state to the next: KITTI's 10 Hz


@dataclass(frozen=True, eq=False)
class TrafficState:
    """All cars at one time apart from ours, in the `world` frame (x forward, y right, z down)."""

    time: float
    """Seconds since the beginning of the run."""
    ids: Int[Array, " n"]
    """Id of each car, increasing; a car keeps its id for the whole run."""
    x: Float[Array, " n"]
    """Centre of each car in world, metres."""
    y: Float[Array, " n"]
    """Centre of each car in world, metres; > 0 is right of the x axis."""
    heading: Float[Array, " n"]
    """Direction of each car, radians from world +x towards +y; not wrapped."""
    speed: Float[Array, " n"]
    """Of each car along its heading, m/s."""
    size: Float[Array, "n 3"]
    """Length, height, width of each car, metres."""
    ego: Float[Array, "3"]
    """x, y (metres) and heading (radians) in world of the car that carries the camera."""
    ego_size: Float[Array, "3"]
    """Length, height, width of the car that carries the camera, metres."""
    z: Float[Array, " n"] | None = None
    """Bottom face of each car, metres down from the ground; None: all cars stand on it."""
    crashed: Bool[Array, " n"] | None = None
    """Whether each car has hit another; None: crashes are not followed."""
    kinds: Shaped[Array, " n"] | None = None
    """KITTI's class of each car, 'Car' or 'Van'; None or '': by the car's shape."""
    tilt: Float[Array, "2"] | None = None
    """Pitch (> 0 looks up) and roll (> 0 leans right) of the ego car's body, radians; None: it
    stays level."""

    def __len__(self) -> int:
        return len(self.ids)

    def footprint(self) -> Float[Array, "n 4 2"]:
        """The four corners (x, y) of every car: front right, front left, rear left, rear right."""
        return outline(np.stack((self.x, self.y, self.heading), axis=1), self.size)

    def ego_footprint(self) -> Float[Array, "4 2"]:
        """The four corners of the car that carries the camera."""
        return outline(self.ego[None], self.ego_size[None])[0]


def outline(poses: Float[Array, "n 3"], size: Float[Array, "n 3"]) -> Float[Array, "n 4 2"]:
    """The rectangles of cars at poses x, y, heading: front right, front left, and round."""
    c, s = np.cos(poses[:, 2]), np.sin(poses[:, 2])
    along = 0.5 * size[:, :1] * np.stack((c, s), axis=1)
    right = 0.5 * size[:, 2:] * np.stack((-s, c), axis=1)
    corners = np.stack((along + right, along - right, -along - right, right - along), axis=1)
    return poses[:, None, :2] + corners


@runtime_checkable
class Traffic(Protocol):
    """What moves cars. Every `step` is 0.1 s; ids are stable from first to last sight.

    The rows of a state are in the order of ids.
    """

    def reset(self, rng: np.random.Generator) -> TrafficState:
        """Back to the beginning; the first state."""
        ...

    def step(self) -> TrafficState:
        """The state 0.1 s later."""
        ...


@runtime_checkable
class Finite(Traffic, Protocol):
    """Traffic whose ego car comes to the end of its road."""

    @property
    def has_ended(self) -> bool:
        """Whether the ego car was behind the end of its road in the last state that was given."""
        ...


@runtime_checkable
class DrivenAhead(Traffic, Protocol):
    """Traffic that `reset` drives ahead, which may take long."""

    driven: Callable[[int], None] | None
    """Called with the number of steps that were driven so far; None: nobody asks."""


def colliding_pairs(poses: Float[Array, "n 3"], size: Float[Array, "n 3"]) -> Int[Array, "p 2"]:
    """Rows i < j of cars at poses x, y, heading whose footprints share some area."""
    reach, count = 0.5 * np.hypot(size[:, 0], size[:, 2]), len(poses)
    # From left to right, those who may touch follow soon.
    order = np.argsort(poses[:, 0], kind="stable")
    x = poses[order, 0]
    farthest = x + reach[order] + (reach.max(initial=0.0) + SPARE_METRES)
    follow = np.searchsorted(x, farthest, side="right") - np.arange(1, count + 1)
    first = np.repeat(np.arange(count), follow)
    second = first + 1 + np.arange(len(first)) - np.repeat(np.cumsum(follow) - follow, follow)
    one, other = order[first], order[second]
    codes = np.sort(np.minimum(one, other) * count + np.maximum(one, other))
    i, j = codes // max(count, 1), codes % max(count, 1)
    apart = np.hypot(*(poses[i, :2] - poses[j, :2]).T)
    near = np.stack((i, j), axis=1)[apart < reach[i] + reach[j]]
    if not len(near):
        return near
    corners = outline(poses, size)
    first, second = corners[near[:, 0]], corners[near[:, 1]]
    touch = ~(_is_apart(first, second) | _is_apart(second, first))
    return near[touch]


def collisions(state: TrafficState) -> Int[Array, "p 2"]:
    """Ids of the cars of a state that overlap, the smaller id first; -1 is the ego car."""
    poses = np.column_stack((state.x, state.y, state.heading))
    pairs = colliding_pairs(np.vstack((state.ego, poses)), np.vstack((state.ego_size, state.size)))
    return np.concatenate(([-1], state.ids))[pairs]


def _is_apart(first: Float[Array, "p 4 2"], second: Float[Array, "p 4 2"]) -> Bool[Array, " p"]:
    """Whether a side of the first rectangle separates it from the second."""
    sides = np.stack((first[:, 1] - first[:, 0], first[:, 2] - first[:, 1]), axis=1)
    own = np.einsum("psk,pck->psc", sides, first)
    other = np.einsum("psk,pck->psc", sides, second)
    gap = (other.min(axis=2) >= own.max(axis=2)) | (own.min(axis=2) >= other.max(axis=2))
    return gap.any(axis=1)
