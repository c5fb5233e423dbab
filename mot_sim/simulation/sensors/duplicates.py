"""A second box about a car: shifted, half of it, or around it and what hides it."""

from dataclasses import dataclass, field

import numpy as np
from jaxtyping import Bool, Float, Int
from numpy import ndarray as Array
from scipy.special import expit

from mot_sim.simulation.sensors.bursts import bursts
from mot_sim.simulation.sensors.checks import require_rates, require_table
from mot_sim.simulation.sensors.correlated_noise import Autocorrelation, correlated_normals
from mot_sim.simulation.sensors.jitter import move_boxes
from mot_sim.simulation.sensors.misses import VISIBLE
from mot_sim.simulation.sensors.quantiles import Quantiles
from mot_sim.simulation.sensors.sightings import Sightings

STILL = Quantiles((0.0, 0.0))


@dataclass(frozen=True)
class Duplicates:
    """seen, missed: the rate of a second box by visible fraction, of cars that are seen or not.

    dx, dy, dw, dh: how it lies to the true box, as in `move_boxes`. log_odds: of its score.
    """

    seen: tuple[float, ...] = (0.0,) * len(VISIBLE)
    missed: tuple[float, ...] = (0.0,) * len(VISIBLE)
    dx: Quantiles = STILL
    dy: Quantiles = STILL
    dw: Quantiles = STILL
    dh: Quantiles = STILL
    log_odds: Quantiles = STILL
    memory: Autocorrelation = field(default_factory=Autocorrelation)

    def __post_init__(self) -> None:
        for rates in (self.seen, self.missed):
            require_table("duplicates", VISIBLE, rates)
            require_rates("duplicates", *rates)

    def __call__(
        self,
        sightings: Sightings,
        missed: Bool[Array, " n"],
        seed: int,
        step: float,
        level: float = 1.0,
    ) -> tuple[Int[Array, " k"], Float[Array, "k 4"], Float[Array, " k"]]:
        """The rows that have a second box, the boxes, and their scores."""
        rates = np.where(
            missed,
            np.interp(sightings.visible, VISIBLE, self.missed),
            np.interp(sightings.visible, VISIBLE, self.seen),
        )
        rates = np.where(sightings.visible > 0.0, np.minimum(level * rates, 1.0), 0.0)
        ids, frames = sightings.ids, sightings.frames
        rows = np.flatnonzero(bursts(rates, seed, "duplicate", ids, frames, self.memory, step))
        if not len(rows):
            return rows, np.zeros((0, 4)), np.zeros(0)
        ids, frames = ids[rows], frames[rows]
        x = correlated_normals(seed, "duplicate/box", ids, frames, self.memory, step, 5)
        parts = (self.dx, self.dy, self.dw, self.dh)
        moves = [part.of_normal(x[:, column]) for column, part in enumerate(parts)]
        boxes = move_boxes(sightings.boxes[rows], *moves)
        return rows, boxes, expit(self.log_odds.of_normal(x[:, 4]))
