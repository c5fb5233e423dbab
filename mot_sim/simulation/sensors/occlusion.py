"""The box of a half-hidden car, drawn around what is visible of it: its lower edge is lifted."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy import ndarray as Array

from mot_sim.simulation.sensors.checks import require_rates
from mot_sim.simulation.sensors.sightings import Sightings


@dataclass(frozen=True)
class VisiblePart:
    """weight: 0 draws the whole car (amodal, as KITTI's labels), 1 only its visible part."""

    weight: float = 0.0

    def __post_init__(self) -> None:
        require_rates("visible_part weight", self.weight)

    def __call__(self, sightings: Sightings) -> Float[Array, "n 4"]:
        """The boxes; whole where nobody knows what was visible."""
        part = np.where(np.isnan(sightings.visible_boxes), sightings.boxes, sightings.visible_boxes)
        if self.weight == 0.0:
            return sightings.boxes
        return (1.0 - self.weight) * sightings.boxes + self.weight * part
