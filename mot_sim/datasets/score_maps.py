"""From a detector's own scores to probabilities, so that one threshold means one thing."""

from dataclasses import dataclass
from math import inf, isfinite

import numpy as np
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
        if not (0.0 < self.scale < inf and isfinite(self.midpoint)):
            raise BadConfig(
                f"score map {self.midpoint:g},{self.scale:g}: both finite, the scale positive"
            )

    @classmethod
    def parse(cls, text: str) -> "ScoreMap":
        """From `midpoint,scale`."""
        try:
            midpoint, scale = (float(number) for number in text.split(","))
        except ValueError:
            raise BadConfig(f"score map {text!r}: write two numbers, midpoint,scale") from None
        return cls(midpoint, scale)

    def __call__(self, scores: Float[Array, " n"]) -> Float[Array, " n"]:
        """The probability that a box of that score is right."""
        with np.errstate(over="ignore"):  # far from the midpoint it is 0 or 1
            return expit((scores - self.midpoint) / self.scale)
