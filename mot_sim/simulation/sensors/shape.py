"""Measured shape coefficients: worse with distance, and nearer to the mean car when hidden."""

from dataclasses import dataclass, field

import numpy as np
from jaxtyping import Float
from numpy import ndarray as Array

from mot_sim.simulation.sensors.checks import require_rates, require_sigmas
from mot_sim.simulation.sensors.correlated_noise import Autocorrelation, correlated_normals
from mot_sim.simulation.sensors.sightings import Sightings

NEAR = 10.0  # metres: where `spread` is given


@dataclass(frozen=True)
class Shape:
    """spread: std of a coefficient at 10 m; growth: its power of depth / 10 m.

    pull: the part of the way to the mean shape (coefficients 0) that every car goes, since a fit
    trusts its prior; shrink: that a wholly hidden car goes of what is left. stated: the std that
    the detector claims; 0: the true one of the noise.
    """

    spread: float = 0.0
    growth: float = 1.0
    shrink: float = 0.0
    pull: float = 0.0
    stated: float = 0.0
    memory: Autocorrelation = field(default_factory=Autocorrelation)

    def __post_init__(self) -> None:
        require_sigmas("shape spread, growth, stated", self.spread, self.growth, self.stated)
        require_rates("shape shrink, pull", self.shrink, self.pull)

    def __call__(
        self, sightings: Sightings, seed: int, step: float, level: float = 1.0
    ) -> Float[Array, "n b"] | None:
        """The coefficients; None where truth has none."""
        if sightings.shape is None or level == 0.0:
            return sightings.shape
        columns = sightings.shape.shape[1]
        x = correlated_normals(
            seed, "shape", sightings.ids, sightings.frames, self.memory, step, columns
        )
        kept = 1.0 - np.minimum(level * self.shrink * (1.0 - sightings.visible), 1.0)
        kept *= 1.0 - min(level * self.pull, 1.0)
        return kept[:, None] * sightings.shape + self.std(sightings, level)[:, None] * x

    def std(self, sightings: Sightings, level: float = 1.0) -> Float[Array, " n"]:
        """Of every measured coefficient."""
        depth = np.nan_to_num(sightings.depth, nan=NEAR)
        return level * self.spread * np.maximum(depth / NEAR, 0.1) ** self.growth

    def stated_std(self, sightings: Sightings, level: float = 1.0) -> Float[Array, " n"]:
        """The std that the detector states of every coefficient."""
        if not self.stated:
            return self.std(sightings, level)
        return np.full(len(sightings), level * self.stated)
