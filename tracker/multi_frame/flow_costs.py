"""What nodes (detections), links, gaps and births cost: minus their log odds, in nats."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy import ndarray as Array

from tracker.errors import BadConfig

# A detection gains no more than this, however high its score: a probability of 0.98.
MAX_SCORE_NATS = 3.9


@dataclass(frozen=True)
class FlowCosts:
    """The costs of a flow: minus the log odds of cars against clutter. All four in nats.

    Chosen on KITTI's ten given sequences for four detectors at once; `benchmarks.association`
    shows the neighbours.
    """

    birth: float = 10.0
    """What a track must gain to begin; 10 are three detections in a row with high scores."""
    fit: float = 2.0
    """What a link of cost 0 gains, since clutter seldom lies where a car is expected. The gain
    falls with the square of the cost, as for a Gaussian deviation; a link at the largest cost
    costs as much as a birth."""
    gap: float = 2.0
    """For every gap of a track, so that two tracks do not take turns on one car."""
    missed: float = 2.0
    """For every second of a gap."""

    def __post_init__(self) -> None:
        numbers = (self.birth, self.fit, self.gap, self.missed)
        if not (np.isfinite(numbers).all() and min(numbers) >= 0.0 and self.birth > 0.0):
            raise BadConfig(f"{self}: give finite numbers, none below 0, and a birth above 0")

    def of_scores(
        self, scores: Float[Array, " n"], say_nothing: bool = False
    ) -> Float[Array, " n"]:
        """The cost of nodes: minus the log odds of their scores, which are probabilities.

        say_nothing: scores do not tell cars from clutter, so links alone do, and every node gains
        as much as it may.
        """
        if say_nothing:
            return np.full(len(scores), -MAX_SCORE_NATS)
        p = np.clip(scores, 1e-9, 1.0 - 1e-9)
        return np.clip(np.log((1.0 - p) / p), -MAX_SCORE_NATS, MAX_SCORE_NATS)

    def of_links(
        self, costs: Float[Array, " k"], max_cost: float, missed: Float[Array, " k"]
    ) -> Float[Array, " k"]:
        """The cost of links. costs: pairwise, up to max_cost. missed: seconds of the gap."""
        deviation = np.square(costs / max_cost)
        hidden = np.where(missed > 0.0, self.gap + self.missed * missed, 0.0)
        return (self.birth + self.fit) * deviation - self.fit + hidden
