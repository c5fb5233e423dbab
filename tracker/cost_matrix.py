"""What the detections of a frame cost against the tracks that are expected in it."""

from dataclasses import dataclass

from jaxtyping import Float
from numpy import ndarray as Array

from tracker.car_filter import RoadMemory
from tracker.costs import GatedPairs
from tracker.lifecycle import ActiveTracks
from tracker.score_scale import ScoreMemory
from tracker.types import Detections


@dataclass(frozen=True, eq=False)
class CostMatrix:
    """What the detections of a frame cost against the tracks that are expected in it."""

    costs: Float[Array, "n m"]
    """Rows: `tracks`. Columns: `detections`. The weighted mean of the costs, 0 (the same object)
    to 1, plus the tie break; inf outside the gate and where no cost could be measured."""
    tracks: ActiveTracks
    """The tracks as predicted for the frame."""
    pairs: GatedPairs
    """The pairs inside the gate, with all that was compared."""
    unmeasured: int
    """How many single costs were NaN: a detection or a track lacked the cue."""
    scores: ScoreMemory
    """What is known of the detector's scores, the frame's among them."""
    road: RoadMemory
    """What is known of the road before the frame's detections."""

    @property
    def detections(self) -> Detections:
        """Those of the frame that were not suppressed."""
        return self.pairs.detections
