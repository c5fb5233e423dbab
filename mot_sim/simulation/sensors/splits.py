"""A long vehicle in two boxes, left and right."""

from dataclasses import dataclass, field

import numpy as np
from jaxtyping import Float, Int
from numpy import ndarray as Array

from mot_sim.simulation import random_numbers
from mot_sim.simulation.sensors.bursts import bursts
from mot_sim.simulation.sensors.checks import require_rates, require_sigmas
from mot_sim.simulation.sensors.correlated_noise import Autocorrelation
from mot_sim.simulation.sensors.sightings import Sightings


@dataclass(frozen=True)
class Splits:
    """rate: of vehicles at least min_width pixels wide."""

    rate: float = 0.0
    min_width: float = 200.0
    memory: Autocorrelation = field(default_factory=Autocorrelation)

    def __post_init__(self) -> None:
        require_rates("splits", self.rate)
        require_sigmas("splits min_width", self.min_width)

    def __call__(
        self, sightings: Sightings, boxes: Float[Array, "n 4"], seed: int, step: float
    ) -> tuple[Int[Array, " k"], Float[Array, "k 4"], Float[Array, "k 4"]]:
        """The rows that are split, and the boxes of both parts."""
        wide = boxes[:, 2] - boxes[:, 0] >= self.min_width
        ids, frames = sightings.ids, sightings.frames
        rates = np.where(wide, self.rate, 0.0)
        rows = np.flatnonzero(bursts(rates, seed, "split", ids, frames, self.memory, step))
        share = (
            0.35 + 0.3 * random_numbers.uniform(seed, "split/where", ids[rows], frames[rows])[:, 0]
        )
        left, right = boxes[rows].copy(), boxes[rows].copy()
        cut = left[:, 0] + share * (left[:, 2] - left[:, 0])
        left[:, 2], right[:, 0] = cut, cut
        return rows, left, right
