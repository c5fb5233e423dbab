"""Vans and trucks that a detector of cars takes for cars; for most, always or never."""

from dataclasses import dataclass, field

import numpy as np
from jaxtyping import Bool
from numpy import ndarray as Array

from mot_sim.simulation.sensors.bursts import bursts
from mot_sim.simulation.sensors.checks import require_rates
from mot_sim.simulation.sensors.correlated_noise import Autocorrelation
from mot_sim.simulation.sensors.sightings import Sightings


@dataclass(frozen=True)
class Confusion:
    """The rates at which other vehicles are reported as cars, and how long a verdict lasts."""

    van: float = 0.0
    truck: float = 0.0
    memory: Autocorrelation = field(default_factory=Autocorrelation)

    def __post_init__(self) -> None:
        require_rates("confusion", self.van, self.truck)

    def __call__(self, sightings: Sightings, seed: int, step: float) -> Bool[Array, " n"]:
        """Whose kind the detector reports; cars always."""
        are_cars = sightings.kinds == "Car"
        if are_cars.all():
            return np.asarray(are_cars)
        rates = np.select(
            [sightings.kinds == "Van", sightings.kinds == "Truck"], [self.van, self.truck], 0.0
        )
        frames, ids = sightings.frames, sightings.ids
        taken = bursts(rates, seed, "confusion", ids, frames, self.memory, step)
        return taken | are_cars
