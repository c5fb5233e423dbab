"""Appearance descriptors: one a car, that turn with the view; look-alikes share theirs."""

from dataclasses import dataclass, field

import numpy as np
from jaxtyping import Float
from numpy import ndarray as Array

from mot_sim.simulation import random_numbers
from mot_sim.simulation.sensors.checks import require_sigmas
from mot_sim.simulation.sensors.correlated_noise import Autocorrelation, correlated_normals
from mot_sim.simulation.sensors.sightings import Sightings
from tracker.errors import BadConfig


@dataclass(frozen=True)
class AppearanceNoise:
    """size: numbers of a descriptor. noise: std over a descriptor's length. view: length of the
    part that turns with the viewpoint. alike: how many cars in a row of ids share one look.
    unit: the distance of vectors of length 1 at which two cars are as likely one as two; what is
    reported is in that unit, as the tracker's own descriptors are.
    """

    size: int = 32
    noise: float = 0.0
    view: float = 0.0
    alike: int = 1
    memory: Autocorrelation = field(default_factory=Autocorrelation)
    unit: float = 1.0

    def __post_init__(self) -> None:
        require_sigmas("appearance noise, view", self.noise, self.view)
        if self.size < 1 or self.alike < 1:
            raise BadConfig(f"appearance size {self.size}, alike {self.alike}: 1 or more")
        if not 0.0 < self.unit < np.inf:
            raise BadConfig(f"appearance unit {self.unit:g}: give a finite number above 0")

    def __call__(
        self, sightings: Sightings, seed: int, step: float, level: float = 1.0
    ) -> Float[Array, "n d"]:
        """Vectors of length 1 / unit; at level 0 those of the cars themselves."""
        ids, frames = sightings.ids, sightings.frames
        look, never = ids // self.alike, np.zeros_like(frames)
        vectors = _unit(random_numbers.normal(seed, "appearance", look, never, self.size))
        turns = level > 0.0 and self.view > 0.0 and sightings.cuboids is not None
        if turns and sightings.cuboids is not None:
            sides = random_numbers.normal(seed, "appearance/view", look, never, 2 * self.size)
            base = sightings.cuboids.base
            angle = np.nan_to_num(sightings.cuboids.yaw - np.arctan2(base[:, 0], base[:, 2]))
            turning = (
                np.cos(angle)[:, None] * sides[:, : self.size]
                + np.sin(angle)[:, None] * sides[:, self.size :]
            )
            vectors = vectors + level * self.view * turning / np.sqrt(self.size)
        if level and self.noise:
            x = correlated_normals(
                seed, "appearance/noise", ids, frames, self.memory, step, self.size
            )
            vectors = vectors + level * self.noise * x / np.sqrt(self.size)
        return (_unit(vectors) if turns or (level and self.noise) else vectors) / self.unit


def _unit(vectors: Float[Array, "n d"]) -> Float[Array, "n d"]:
    return vectors / np.maximum(np.linalg.norm(vectors, axis=1, keepdims=True), 1e-12)
