"""What a tracker believes of cars beyond their boxes, with its uncertainty."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy import ndarray as Array

from tracker.types.cuboids import Cuboids
from tracker.types.packed import NO_INTS, Packed
from tracker.types.rows import Rows


@dataclass(frozen=True, eq=False)
class CarEstimates(Rows):
    """The whole state of cars with its covariance, one car per row; NaN rows: not known."""

    means: Float[Array, "n 9"]
    """x, y, z of the base's centre (road frame, m), yaw (rad), speed along the car's own axis
    (m/s), logarithms of length, height and width (m), yaw rate (rad/s)."""
    covs: Float[Array, "n 9 9"]
    """Covariance of `means`, in its order and units."""
    heading_known: Float[Array, " n"]
    """Probability that the car faces where its yaw says, and not the other way round, 0.5 to 1."""

    @classmethod
    def unknown(cls, count: int) -> "CarEstimates":
        """`count` cars of which nothing is known."""
        means, covs = np.full((count, 9), np.nan), np.full((count, 9, 9), np.nan)
        return cls(means, covs, np.full(count, np.nan))

    @property
    def speed(self) -> Float[Array, " n"]:
        """Along the car's own axis, m/s, not below 0."""
        speeds: Float[Array, " n"] = self.means[:, 4]
        return speeds

    @property
    def yaw_rate(self) -> Float[Array, " n"]:
        """About road +y, rad/s."""
        rates: Float[Array, " n"] = self.means[:, 8]
        return rates

    def cuboids(self) -> Cuboids:
        """The likeliest cuboids."""
        n, means = len(self.means), self.means
        numbers = np.empty(7 * n)
        numbers[: 3 * n].reshape(n, 3)[:] = means[:, :3]
        numbers[3 * n : 4 * n] = means[:, 3]
        np.exp(means[:, 5:8], out=numbers[4 * n :].reshape(n, 3))
        return Cuboids.of_packed(Packed(n, numbers, NO_INTS))
