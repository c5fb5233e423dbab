"""A distribution by its quantiles at even steps from the smallest to the largest value."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from jaxtyping import Float
from numpy import ndarray as Array
from scipy.special import ndtr

from mot_sim.simulation.sensors.checks import require_rising


@dataclass(frozen=True)
class Quantiles:
    """A distribution by its quantiles."""

    values: tuple[float, ...]
    """At the probabilities 0, 1/(n-1), ..., 1, straight lines between; two or more that never
    fall."""

    def __post_init__(self) -> None:
        require_rising("quantiles", self.values)

    def of_normal(self, x: Float[Array, " n"]) -> Float[Array, " n"]:
        """Standard normal numbers carried to this distribution; order is kept."""
        return np.interp(ndtr(x), *self._curve)

    @cached_property
    def _curve(self) -> tuple[Float[Array, " k"], Float[Array, " k"]]:
        return np.linspace(0.0, 1.0, len(self.values)), np.array(self.values)

    @classmethod
    def of(cls, sample: Float[Array, " n"], count: int = 11) -> "Quantiles":
        """The quantiles of a sample; its most extreme hundredths are cut off."""
        probabilities = np.linspace(0.0, 1.0, count).clip(0.01, 0.99)
        return cls(tuple(np.round(np.quantile(sample, probabilities), 4).tolist()))
