"""What the cars of a scene share: the slope of the road, and which way traffic goes where."""

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from jaxtyping import Bool, Float
from numpy import ndarray as Array

from tracker.car_filter.states import HEADING_COUNT, CarStates
from tracker.kernels import Kernel
from tracker.types import Camera

PLACE_BASES = Kernel("tracker.kernels.car_scene", "place_bases")
SUM_SLOPES = Kernel("tracker.kernels.car_scene", "sum_slopes")
WEIGH_DIRECTIONS = Kernel("tracker.kernels.car_hypotheses", "weigh_directions")
WATCH_TRAFFIC = Kernel("tracker.kernels.car_hypotheses", "watch_traffic")
BELIEVE_HEIGHTS = Kernel("tracker.kernels.car_hypotheses", "believe_heights")
# Borders between the strips of the road of which traffic is remembered, road x, m.
STRIP_BORDERS = np.array([-6.0, -1.5, 1.5, 6.0])
# As far as the first aside (road x, m) the shares of `DirectionPrior` before the camera hold, from
# the second on those left or right of it.
MIDDLE = np.array([1.0, 4.0])
# The road's slope is told by whole boxes, farther than this from the image's border, px ...
MIN_BORDER_GAP = 5.0
# ... of cars farther away than this, m, ...
MIN_SLOPE_DISTANCE = 8.0
# ... with at least this score.
MIN_SLOPE_SCORE = 0.5
# How far a car's base may seem off the road by its unknown height and the noise of its box, m.
BASE_STD = 0.153
# Directions of moving cars are learned from those that move for certain, faster than this, m/s.
MIN_TRAFFIC_SPEED = 1.5
MIN_MOVING_PROBABILITY = 0.8
# A camera that turned by this, rad, sees another road.
FORGETTING_TURN = 0.3


class RoadMemory(NamedTuple):
    """What is known of the road at one moment."""

    slope: float = 0.0
    """How much lower the road lies per metre of distance than the plane under the camera."""
    slope_var: float = math.inf
    """Its variance; inf: nothing is known yet."""
    traffic: Float[Array, "5 2"] = np.zeros((5, 2))
    """Seconds of traffic seen in each strip of the road: the camera's way, and oncoming."""
    camera_velocity_cov: Float[Array, "2 2"] = np.zeros((2, 2))
    """Covariance of the camera's own velocity along road x and z, m^2/s^2: all cars' speeds over
    the ground share this error."""
    flatness: float = 0.0
    """How much likelier the boxes are on a flat road, nats: see `RoughnessModel`."""


class SeenBases(NamedTuple):
    """Where the bases of cars seem to be by their boxes, per metre of their height."""

    fall: Float[Array, " n"]
    """How far below the camera."""
    reach: Float[Array, " n"]
    """How far from the camera, seen from above."""
    camera_height: float
    """Of the camera above the plane under it, m."""
    is_usable: Bool[Array, " n"]
    """Which boxes tell something: sure ones, away from the image's border, of which neither the
    upper nor the lower edge is hidden."""

    @classmethod
    def of(
        cls,
        boxes: Float[Array, "n 4"],
        scores: Float[Array, " n"],
        hidden: Bool[Array, "n 4"],
        camera: Camera,
    ) -> "SeenBases":
        """Of cars with these boxes. hidden: their edges that another box hides."""
        n = len(boxes)
        fall, reach, is_usable = np.empty(n), np.empty(n), np.empty(n, bool)
        lens = *camera.pixel_rays_road, camera.K[1, 1], camera.far_corner
        limits = MIN_BORDER_GAP, MIN_SLOPE_SCORE
        PLACE_BASES(boxes, scores, hidden, *lens, *limits, fall, reach, is_usable)
        return cls(fall, reach, camera.height, is_usable)


@dataclass(frozen=True)
class RoadModel:
    """The slope that all cars of a frame share: the camera nods, and roads rise and fall."""

    slope_std: float = 0.022
    """Std of the slope, rad; 0: the road is the plane under the camera."""
    slope_time: float = 15.0
    """Seconds in which the slope changes; more: it is averaged over a longer time."""
    residual_std: float = 0.006
    """Std of the slope that a single car has for itself, rad."""
    repetition: float = 6.0
    """How many boxes of one car tell as much as one: their errors are alike. More: the slope
    follows the cars more slowly."""

    def predict(
        self, memory: RoadMemory, T_road: Float[Array, "4 4"], dt: float
    ) -> tuple[RoadMemory, float]:
        """The memory `dt` seconds later, and the slope before it fell back to 0 in that time.

        T_road: moves points of the road frame of before into that of now.
        """
        others = memory[2:]
        if self.slope_std == 0.0:
            return RoadMemory(0.0, 0.0, *others), 0.0
        moved = memory.slope + math.atan2(T_road[1, 2], T_road[2, 2])
        keep = math.exp(-dt / self.slope_time)
        var = keep**2 * min(memory.slope_var, self.slope_std**2)
        var += (1.0 - keep**2) * self.slope_std**2
        return RoadMemory(keep * moved, var, *others), moved

    def update(
        self, memory: RoadMemory, bases: SeenBases, heights: Float[Array, " n"]
    ) -> RoadMemory:
        """The memory after boxes of cars of these heights, m."""
        if len(heights) == 0:
            return memory
        seen = bases.fall, bases.reach, bases.is_usable, bases.camera_height
        return self.after(memory, *SUM_SLOPES(*seen, heights, *self._noise.tolist()))

    @cached_property
    def _noise(self) -> Float[Array, "4"]:
        """Of what boxes tell, as the kernels take it."""
        return np.array([MIN_SLOPE_DISTANCE, BASE_STD, self.residual_std, self.repetition])

    def after(self, memory: RoadMemory, information: float, weighted: float) -> RoadMemory:
        """The memory after so much information on the slope, and its product with the slope."""
        if self.slope_std == 0.0:
            return memory
        before = 1.0 / min(memory.slope_var, self.slope_std**2)
        total = before + information
        slope = (before * memory.slope + weighted) / total
        return RoadMemory(float(slope), float(1.0 / total), *memory[2:])


@dataclass(frozen=True)
class DirectionPrior:
    """Which way cars face, before their motion tells it: by their side, and by the traffic there.

    Boxes alone cannot tell the front of a parked car from its rear. Shares are those left of the
    camera, before it, and right of it; what is left of them faces any way.
    """

    parked_same: tuple[float, float, float] = (0.25, 0.8, 0.5)
    """Share of parked cars that face the camera's way."""
    parked_oncoming: tuple[float, float, float] = (0.65, 0.1, 0.1)
    """Share of parked cars that face the camera; where cars drive on the left, the mirror image
    of the default is right."""
    moving_same: tuple[float, float, float] = (0.5, 0.85, 0.75)
    """Share of moving cars that go the camera's way."""
    moving_oncoming: tuple[float, float, float] = (0.4, 0.1, 0.05)
    """Share of moving cars that come towards the camera."""
    concentration: float = 12.0
    """How well cars follow the road's direction (von Mises); 12: within 17 degrees."""
    traffic_seconds: float = 3.0
    """How many seconds of traffic in a strip count as much as the shares of both directions; more:
    the traffic is followed more slowly."""
    memory_time: float = 20.0
    """Seconds in which traffic is forgotten."""

    def predict(self, memory: RoadMemory, turn: float, dt: float) -> RoadMemory:
        """The memory `dt` seconds later, after the camera turned so far (rad)."""
        kept = math.exp(-dt / self.memory_time - abs(turn) / FORGETTING_TURN)
        return _with_traffic(memory, memory.traffic * kept)

    def update(self, memory: RoadMemory, states: CarStates, dt: float) -> RoadMemory:
        """The memory after `dt` seconds of these cars."""
        traffic = memory.traffic.copy()
        limits = MIN_TRAFFIC_SPEED, MIN_MOVING_PROBABILITY, dt
        WATCH_TRAFFIC(states.means, states.log_weights, STRIP_BORDERS, *limits, traffic)
        return _with_traffic(memory, traffic)

    def __call__(self, memory: RoadMemory, states: CarStates) -> Float[Array, "n k"]:
        """Probabilities of the hypotheses by their headings as well."""
        weights = np.empty(states.log_weights.shape)
        WEIGH_DIRECTIONS(states.means, states.log_weights, *self.known(memory), weights)
        return weights

    def known(self, memory: RoadMemory) -> tuple[Any, ...]:
        """What is known of directions, as the kernels take it."""
        prior = STRIP_BORDERS, MIDDLE, self.concentration, self.traffic_seconds
        return self._shares, memory.traffic, *prior

    @cached_property
    def _shares(self) -> Float[Array, "3 k 2"]:
        """Of each hypothesis the shares before the camera, left and right of it: both ways."""
        parked = self.parked_same, self.parked_oncoming
        moving = self.moving_same, self.moving_oncoming
        by_mode = np.array([parked, moving]).repeat(HEADING_COUNT, axis=0)  # k, 2, 3
        return by_mode[:, :, [1, 0, 2]].transpose(2, 0, 1).copy()


def _with_traffic(memory: RoadMemory, traffic: Float[Array, "5 2"]) -> RoadMemory:
    """The same with other traffic."""
    return RoadMemory(*memory[:2], traffic, *memory[3:])


def believed_heights(states: CarStates) -> Float[Array, " n"]:
    """Each car's height by the expected logarithm, m."""
    heights = np.empty(len(states.means))
    BELIEVE_HEIGHTS(states.means, states.log_weights, heights)
    return heights
