"""From a detector's own scores to probabilities, so that one threshold means one thing."""

from dataclasses import dataclass

from jaxtyping import Float
from numpy import ndarray as Array
from scipy.special import expit

from tracker.errors import BadConfig


@dataclass(frozen=True)
class ScoreMap:
    """Logistic: at `midpoint` every second box is right; `scale` is the distance to 73 %.

    Fitted by maximum likelihood on KITTI's ten given sequences, a box being right when it meets
    a counted car with IoU >= 0.5: `python benchmarks/calibrate_scores.py` prints the numbers.
    """

    midpoint: float
    scale: float

    def __post_init__(self) -> None:
        if not self.scale > 0.0:
            raise BadConfig(f"score map with scale {self.scale:g}: the scale must be positive")

    def __call__(self, scores: Float[Array, " n"]) -> Float[Array, " n"]:
        """The probability that a box of that score is right."""
        return expit((scores - self.midpoint) / self.scale)
