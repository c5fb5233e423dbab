"""What is believed of cars: several hypotheses each, every one a Gaussian of the whole state."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int
from numpy import ndarray as Array

from tracker.types.rows import Rows

# Columns of a state: x, y, z of the base's centre, yaw, speed, logarithms of length, height, width,
# yaw rate.
YAW, SPEED, LOG_HEIGHT, YAW_RATE = 3, 4, 6, 8
LOG_SIZE = slice(5, 8)
STATE_SIZE = 9
# Headings of a new car, equally spaced; each is followed parked (first half) and moving.
HEADING_COUNT = 8
HYPOTHESIS_COUNT = 2 * HEADING_COUNT
PARKED, MOVING = slice(0, HEADING_COUNT), slice(HEADING_COUNT, HYPOTHESIS_COUNT)
# A hypothesis of which no more than exp of this is left is not followed.
MIN_LOG_WEIGHT = -9.0


@dataclass(frozen=True, eq=False)
class CarStates(Rows):
    """Hypotheses of cars in the road frame of one moment; one car per row, 16 hypotheses each.

    A state: x, y, z of the base's centre (m), yaw (rad), speed along the car's own axis (m/s, not
    below 0), logarithms of length, height and width (m), yaw rate (rad/s). The first half of the
    hypotheses are parked.
    """

    means: Float[Array, "n k 9"]
    """The state by each hypothesis."""
    covs: Float[Array, "n k 9 9"]
    """Its covariance."""
    log_weights: Float[Array, "n k"]
    """Logarithms of their probabilities, which sum up to 1 over a row."""

    @classmethod
    def empty(cls) -> "CarStates":
        """No car."""
        shape = (0, HYPOTHESIS_COUNT, STATE_SIZE)
        return cls(np.zeros(shape), np.zeros((*shape, STATE_SIZE)), np.zeros(shape[:2]))

    def followed(self) -> tuple[Int[Array, " h"], Int[Array, " h"]]:
        """Rows and columns of the hypotheses that are followed."""
        rows, columns = (self.log_weights > MIN_LOG_WEIGHT).nonzero()
        return rows, columns


def normalised(log_weights: Float[Array, "n k"]) -> Float[Array, "n k"]:
    """The same ratios, with probabilities that sum up to 1 over each row."""
    log_weights = log_weights - log_weights.max(axis=1, keepdims=True)
    return log_weights - np.log(np.exp(log_weights).sum(axis=1, keepdims=True))
