"""Measured shape coefficients: worse with distance, and nearer to the mean car when hidden."""

from dataclasses import dataclass, field

import numpy as np
from jaxtyping import Float
from numpy import ndarray as Array

from mot_sim.sensors.checks import require_rates, require_sigmas
from mot_sim.sensors.memory import Memory, latent
from mot_sim.sensors.sightings import Sightings

NEAR = 10.0  # metres: where `spread` is given


@dataclass(frozen=True)
class Shape:
    """spread: std of a coefficient at 10 m; growth: its power of depth / 10 m.

    shrink: the part of the way to the mean shape (coefficients 0) that a wholly hidden car goes.
    """

    spread: float = 0.0
    growth: float = 1.0
    shrink: float = 0.0
    memory: Memory = field(default_factory=Memory)

    def __post_init__(self) -> None:
        require_sigmas("shape spread, growth", self.spread, self.growth)
        require_rates("shape shrink", self.shrink)

    def __call__(
        self, sightings: Sightings, seed: int, step: float, level: float = 1.0
    ) -> Float[Array, "n b"] | None:
        """The coefficients; None where truth has none."""
        if sightings.shape is None or level == 0.0:
            return sightings.shape
        columns = sightings.shape.shape[1]
        x = latent(seed, "shape", sightings.ids, sightings.frames, self.memory, step, columns)
        kept = 1.0 - np.minimum(level * self.shrink * (1.0 - sightings.visible), 1.0)
        return kept[:, None] * sightings.shape + self.std(sightings, level)[:, None] * x

    def std(self, sightings: Sightings, level: float = 1.0) -> Float[Array, " n"]:
        """Of every measured coefficient."""
        depth = np.nan_to_num(sightings.depth, nan=NEAR)
        return level * self.spread * np.maximum(depth / NEAR, 0.1) ** self.growth
