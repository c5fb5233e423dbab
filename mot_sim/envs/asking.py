"""A tracker that is asked what pairs cost, and told which to match."""

from dataclasses import dataclass, field, replace

import numpy as np
from jaxtyping import Float
from numpy import ndarray as Array

from mot_sim.files.named_objects import make_tracker
from tracker import Camera, Tracker
from tracker.association import Match


@dataclass(eq=False)
class ForcedAssociation:
    """An association that makes the match it was told, and remembers the costs it was asked."""

    costs: Float[Array, "n m"] = field(default_factory=lambda: np.zeros((0, 0)))
    match: Match | None = None

    def __call__(self, costs: Float[Array, "n m"]) -> Match:
        """The match; without one, nobody is matched and nobody is new."""
        self.costs = costs
        return self.match or Match(
            np.zeros((0, 2), np.int64), np.arange(len(costs)), np.zeros(0, np.int64)
        )


def forced_tracker(name: str, camera: Camera, told: ForcedAssociation) -> Tracker:
    """The tracker of a name, which matches and begins tracks as it is told."""
    tracker: Tracker = make_tracker(name, camera, Tracker)
    lifecycle = replace(tracker.lifecycle, birth_score=-np.inf)
    return replace(tracker, associate=told, lifecycle=lifecycle, strong_score=-np.inf)
