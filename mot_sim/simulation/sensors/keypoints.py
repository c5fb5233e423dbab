"""Measured keypoints: jitter by what hides them, misses, and left taken for right."""

from dataclasses import dataclass, field

import numpy as np
from jaxtyping import Float
from numpy import ndarray as Array

from mot_sim.simulation import random_numbers
from mot_sim.simulation.sensors.bursts import bursts
from mot_sim.simulation.sensors.checks import require_rates, require_sigmas
from mot_sim.simulation.sensors.correlated_noise import Autocorrelation, correlated_normals
from mot_sim.simulation.sensors.sightings import Sightings
from tracker.errors import BadConfig

STATES = 4  # visible, hidden by the car itself, hidden by another, outside the image


@dataclass(frozen=True)
class Keypoints:
    """spread, misses: by state (visible, self-occluded, occluded by another, truncated).

    spread: parts of the box's larger side. flips: the rate of left taken for right, which swaps
    the first half of the points with the second. memory: of the errors and the flips.
    """

    spread: tuple[float, ...] = (0.0,) * STATES
    misses: tuple[float, ...] = (0.0,) * STATES
    flips: float = 0.0
    memory: Autocorrelation = field(default_factory=Autocorrelation)

    def __post_init__(self) -> None:
        if len(self.spread) != STATES or len(self.misses) != STATES:
            raise BadConfig("keypoints: give four numbers, one a state")
        require_sigmas("keypoints spread", *self.spread)
        require_rates("keypoints", *self.misses, self.flips)

    def __call__(
        self, sightings: Sightings, seed: int, step: float, level: float = 1.0
    ) -> Float[Array, "n k 3"] | None:
        """u, v, confidence; NaN for a missed point, None where truth has no keypoints."""
        if sightings.keypoints is None or sightings.keypoint_states is None:
            return None
        true, ids, frames = sightings.keypoints, sightings.ids, sightings.frames
        count, points = true.shape[:2]
        state = sightings.keypoint_states.astype(np.int64)
        sides = sightings.boxes[:, 2:] - sightings.boxes[:, :2]
        x = correlated_normals(seed, "keypoints", ids, frames, self.memory, step, 2 * points)
        spread = level * np.array(self.spread)[state] * sides.max(axis=1, initial=0.0)[:, None]
        uv = true + spread[..., None] * x.reshape(count, points, 2) if level else true
        rates = np.full(count, min(level * self.flips, 1.0))
        turned = bursts(rates, seed, "keypoints/flip", ids, frames, self.memory, step)
        half = points // 2
        mirrored = np.concatenate((uv[:, half : 2 * half], uv[:, :half], uv[:, 2 * half :]), axis=1)
        uv = np.where(turned[:, None, None], mirrored, uv)
        chance = random_numbers.uniform(seed, "keypoints/miss", ids, frames, points)
        lost = (chance < level * np.array(self.misses)[state]) | np.isnan(uv).any(axis=2)
        confidence = np.exp(-10.0 * level * np.array(self.spread)[state])
        measured = np.concatenate((uv, confidence[..., None]), axis=2)
        return np.where(lost[..., None], np.nan, measured)
