"""Two cars in one box, when one stands before the other."""

from dataclasses import dataclass, field

import numpy as np
from jaxtyping import Float, Int
from numpy import ndarray as Array

from mot_sim.metrics.matching import same_frame_pairs
from mot_sim.simulation.sensors.bursts import bursts
from mot_sim.simulation.sensors.checks import require_rates
from mot_sim.simulation.sensors.correlated_noise import Autocorrelation
from mot_sim.simulation.sensors.sightings import Sightings
from tracker.geometry import box_iou


@dataclass(frozen=True)
class Merges:
    """rate: of a car whose box overlaps another's by min_iou or more being swallowed by it."""

    rate: float = 0.0
    min_iou: float = 0.3
    memory: Autocorrelation = field(default_factory=Autocorrelation)

    def __post_init__(self) -> None:
        require_rates("merges", self.rate, self.min_iou)

    def __call__(
        self, sightings: Sightings, boxes: Float[Array, "n 4"], seed: int, step: float
    ) -> tuple[Int[Array, " k"], Int[Array, " k"], Float[Array, "k 4"]]:
        """Rows that keep a merged box, rows that vanish in it, and the boxes around both.

        A row takes part in one merge at most: the one that overlaps it most.
        """
        none = np.zeros(0, np.int64)
        if self.rate == 0.0 or not len(sightings):
            return none, none, np.zeros((0, 4))
        frames = sightings.frames
        first, second = same_frame_pairs(frames, frames)
        pairs = first < second
        first, second = first[pairs], second[pairs]
        iou = box_iou(boxes[first], boxes[second])
        near = np.flatnonzero(iou >= self.min_iou)
        near = near[np.argsort(-iou[near], kind="stable")]
        first, second = first[near], second[near]
        keys = sightings.ids[first] * 1_000_003 + sightings.ids[second]  # one number a pair
        rates = np.full(len(near), self.rate)
        joined = np.flatnonzero(
            bursts(rates, seed, "merge", keys, frames[first], self.memory, step)
        )
        taken: set[int] = set()
        kept, gone = [], []
        for a, b in zip(first[joined].tolist(), second[joined].tolist(), strict=True):
            if a not in taken and b not in taken:
                taken |= {a, b}
                kept.append(a)
                gone.append(b)
        a_rows, b_rows = np.array(kept, np.int64), np.array(gone, np.int64)
        low = np.minimum(boxes[a_rows, :2], boxes[b_rows, :2])
        high = np.maximum(boxes[a_rows, 2:], boxes[b_rows, 2:])
        return a_rows, b_rows, np.concatenate((low, high), axis=1)
