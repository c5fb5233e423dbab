"""What sightings, links, gaps and births cost: minus their log odds, in nats."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy import ndarray as Array

from tracker.errors import BadConfig

# A sighting says no more than this, however sure the detector is of it: a probability of 0.98.
MOST = 3.9


@dataclass(frozen=True)
class FlowCosts:
    """The costs of a flow: minus the log odds of cars against clutter. All four in nats.

    birth: what a track must gain before it is believed; 10 are three sure sightings in a row.
    fit: what a link of cost 0 gains, since clutter seldom lies where a car is expected. The
    gain falls with the square of the cost, as for a Gaussian deviation, and a link at the
    largest cost is as dear as a birth. gap: for every time a car is not seen in between, lest
    two tracks take turns on one car. missed: for every second of it. Chosen on KITTI's ten given
    sequences for four detectors at once; `benchmarks.association` shows the neighbours.
    """

    birth: float = 10.0
    fit: float = 2.0
    gap: float = 2.0
    missed: float = 2.0

    def __post_init__(self) -> None:
        numbers = (self.birth, self.fit, self.gap, self.missed)
        if not (np.isfinite(numbers).all() and min(numbers) >= 0.0 and self.birth > 0.0):
            raise BadConfig(f"{self}: give finite numbers, none below 0, and a birth above 0")

    def of_scores(self, scores: Float[Array, " n"]) -> Float[Array, " n"]:
        """The cost of sightings: minus the log odds of their scores, which are probabilities."""
        p = np.clip(scores, 1e-9, 1.0 - 1e-9)
        return np.clip(np.log((1.0 - p) / p), -MOST, MOST)

    def of_links(
        self, costs: Float[Array, " k"], max_cost: float, missed: Float[Array, " k"]
    ) -> Float[Array, " k"]:
        """The cost of links. costs: pairwise, up to max_cost. missed: seconds unseen between."""
        deviation = np.square(costs / max_cost)
        hidden = np.where(missed > 0.0, self.gap + self.missed * missed, 0.0)
        return (self.birth + self.fit) * deviation - self.fit + hidden
