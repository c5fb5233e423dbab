"""Whether the road is flat and its boxes exact: then contacts tell depth, however far away."""

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from jaxtyping import Float
from numpy import ndarray as Array

from tracker.car_filter.road_memory import MIN_SLOPE_DISTANCE, RoadMemory, SeenBases
from tracker.errors import BadConfig
from tracker.kernels import Kernel

SUM_FLATNESS = Kernel("tracker.kernels.car_scene", "sum_flatness")

# A base farther off than this many standard deviations counts as this far.
MAX_OFF_ROAD = 4.0


@dataclass(frozen=True)
class RoughnessModel:
    """How far cars stand off the road's plane, told by all boxes together.

    By the mean car's height, bases seem off the road as far as cars' heights differ: at any
    distance alike where boxes are exact and the road is flat; the more the farther away on real
    roads, and by noisy boxes.
    """

    flat_share: float = 0.05
    """Probability of a flat road before any box, 0 to 1; more: contacts with the road are trusted
    sooner."""
    flat_factor: float = 0.0025
    """How much smaller the variance of heights off the road is on a flat one."""
    flat_std: float = 0.17
    """How far bases seem off a flat road, since heights differ and boxes are rounded, m; more:
    rougher roads count as flat."""
    rough_std: float = 0.0065
    """How much farther off they seem on other roads, per metre of distance (KITTI: 0.0065)."""
    memory_time: float = 20.0
    """Seconds in which it is forgotten what the road was like."""
    repetition: float = 6.0
    """How many boxes tell as much as one, since the errors of one car's boxes are alike, and those
    of a frame; more: a flat road is found later."""

    def __post_init__(self) -> None:
        if not 0.0 <= self.flat_share <= 1.0:
            raise BadConfig(f"flat_share {self.flat_share:g}: give a probability, 0 to 1")

    def predict(self, memory: RoadMemory, dt: float) -> RoadMemory:
        """The memory `dt` seconds later."""
        return RoadMemory(*memory[:4], math.exp(-dt / self.memory_time) * memory.flatness)

    def update(self, memory: RoadMemory, bases: SeenBases, height: float) -> RoadMemory:
        """The memory after boxes of a frame. height: the mean car's, m."""
        seen = bases.fall, bases.reach, bases.is_usable, bases.camera_height
        return self.after(memory, SUM_FLATNESS(*seen, height, *self._noise.tolist()))

    @cached_property
    def _noise(self) -> Float[Array, "4"]:
        """Of what bases tell, as the kernels take it."""
        return np.array([MIN_SLOPE_DISTANCE, self.flat_std, self.rough_std, MAX_OFF_ROAD])

    def after(self, memory: RoadMemory, told: float) -> RoadMemory:
        """The memory after what bases told, twice the nats of a flat road."""
        return RoadMemory(*memory[:4], memory.flatness + 0.5 * told / self.repetition)

    def __call__(self, memory: RoadMemory) -> float:
        """The factor on the variance of how far cars stand off the road."""
        if self.flat_share in (0.0, 1.0):
            return self.flat_factor**self.flat_share
        odds = (1.0 / self.flat_share - 1.0) * math.exp(-min(memory.flatness, 700.0))
        flat = 1.0 / (1.0 + odds)
        return flat * self.flat_factor + 1.0 - flat
