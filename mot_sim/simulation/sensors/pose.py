"""Measured yaw and size: errors with memory, and cars seen the wrong way round."""

from dataclasses import dataclass, field

import numpy as np
from jaxtyping import Float
from numpy import ndarray as Array

from mot_sim.simulation.sensors.bursts import bursts
from mot_sim.simulation.sensors.checks import require_rates, require_sigmas
from mot_sim.simulation.sensors.correlated_noise import Autocorrelation, correlated_normals
from mot_sim.simulation.sensors.sightings import Sightings
from tracker.geometry import wrap_angle


@dataclass(frozen=True)
class Pose:
    """yaw: std in radians; hidden: its growth e^(hidden * (1 - visible)). flips: rate of yaw + pi.

    size: relative error of length, height and width. memory: of the errors; flip_memory: of how
    long a car stays turned round.
    """

    yaw: float = 0.0
    hidden: float = 0.0
    flips: float = 0.0
    size: float = 0.0
    memory: Autocorrelation = field(default_factory=Autocorrelation)
    flip_memory: Autocorrelation = field(default_factory=Autocorrelation)

    def __post_init__(self) -> None:
        require_sigmas("pose yaw, hidden, size", self.yaw, self.hidden, self.size)
        require_rates("pose flips", self.flips)

    def __call__(
        self, sightings: Sightings, seed: int, step: float, level: float = 1.0
    ) -> tuple[Float[Array, " n"], Float[Array, "n 3"]]:
        """Yaw about road +y and size; NaN rows without cuboids. Level 0 gives the exact ones."""
        if sightings.cuboids is None:
            return np.full(len(sightings), np.nan), np.full((len(sightings), 3), np.nan)
        yaw, size = sightings.cuboids.yaw, sightings.cuboids.size
        if level == 0.0:
            return yaw, size
        ids, frames = sightings.ids, sightings.frames
        x = correlated_normals(seed, "pose", ids, frames, self.memory, step, 4)
        spread = self.std(sightings, level)
        rates = np.full(len(ids), min(level * self.flips, 1.0))
        turned = bursts(rates, seed, "flip", ids, frames, self.flip_memory, step)
        measured = yaw + spread * x[:, 0] + np.pi * turned
        if self.yaw or turned.any():
            yaw = np.asarray(wrap_angle(measured))
        return yaw, size * np.exp(level * self.size * x[:, 1:])

    def std(self, sightings: Sightings, level: float = 1.0) -> Float[Array, " n"]:
        """Of the measured yaw, radians, cars turned round apart."""
        return level * self.yaw * np.exp(self.hidden * (1.0 - sightings.visible))
