"""The deformable car: a mean shape and the ways in which cars differ from it.

S = mean + sum_b lambda_b V_b is eq. 1 of Sharma et al., ICRA 2018.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from jaxtyping import Float
from numpy import ndarray as Array

from tracker.errors import BadConfig, UnknownName


@dataclass(frozen=True, eq=False)
class ShapeBasis:
    """Named points on a car in the axes of the `object` frame: x forward, y down, z left.

    Units and origin are those of the source: metres, origin on the road under the car's middle
    for our own; centred, in the authors' scale, for theirs.
    """

    points: tuple[str, ...]
    """Names of the points."""
    mean: Float[Array, "k 3"]
    """Where they are on the mean car."""
    vectors: Float[Array, "b k 3"]
    """V_b of eq. 1: how they move with each coefficient; they need not be orthonormal."""
    std: Float[Array, " b"] | None = None
    """Std of each coefficient over the cars that the basis was made from (square roots of
    eigenvalues); None: not known."""

    @property
    def size(self) -> int:
        """The number of coefficients, B."""
        return len(self.vectors)

    def shape(self, lambdas: Float[Array, "*n b"]) -> Float[Array, "*n k 3"]:
        """The points of cars with these coefficients (eq. 1)."""
        return self.mean + np.tensordot(lambdas, self.vectors, axes=1)

    def project(self, points: Float[Array, "*n k 3"]) -> Float[Array, "*n b"]:
        """The coefficients whose shapes come nearest to the points, by least squares.

        The points stand in the basis' own frame and scale.
        """
        offsets = points - self.mean
        return offsets.reshape(*points.shape[:-2], self.mean.size) @ self._inverse

    def first(self, size: int) -> "ShapeBasis":
        """The same basis with only its first coefficients."""
        if not 0 <= size <= self.size:
            raise BadConfig(f"{size} shape coefficients: this basis has 0 to {self.size}")
        std = None if self.std is None else self.std[:size]
        return ShapeBasis(self.points, self.mean, self.vectors[:size], std)

    def select(self, points: Sequence[str]) -> "ShapeBasis":
        """The same basis for some of its points, in the given order."""
        for name in points:
            if name not in self.points:
                raise UnknownName.of("point", name, self.points)
        rows = [self.points.index(name) for name in points]
        return ShapeBasis(tuple(points), self.mean[rows], self.vectors[:, rows], self.std)

    def scaled(self, factor: float) -> "ShapeBasis":
        """The same cars in another unit of length; the coefficients keep their values."""
        return ShapeBasis(self.points, self.mean * factor, self.vectors * factor, self.std)

    @cached_property
    def _inverse(self) -> Float[Array, "d b"]:
        """From offsets to coefficients: the pseudo-inverse of the vectors."""
        return np.linalg.pinv(self.vectors.reshape(self.size, self.mean.size))
