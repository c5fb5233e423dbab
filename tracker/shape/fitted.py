"""The result of a fit of cars: shape, pose, size, place, covariance, and whether to trust it."""

from dataclasses import dataclass, fields, replace

import numpy as np
from jaxtyping import Bool, Float, Int
from numpy import ndarray as Array

from tracker.errors import BadDetections
from tracker.types import Cuboids, Detections
from tracker.types.rows import Rows


@dataclass(frozen=True, eq=False)
class FittedCars(Rows):
    """Cars in the road frame; NaN in every column of a row without a fit.

    shape: coefficients of eq. 1. yaw: about road +y, in [-pi, pi). size: length, height, width.
    base: centre of the bottom face. cov: of (x, z, yaw, coefficients). residual: about 1 for a
    car whose keypoints are as good as stated; the larger the worse. seen: points that were used.
    trusted: whether a car fits, and fits well enough to tell yaw and depth.
    """

    shape: Float[Array, "n b"]
    yaw: Float[Array, " n"]
    size: Float[Array, "n 3"]
    base: Float[Array, "n 3"]
    cov: Float[Array, "n s s"]
    residual: Float[Array, " n"]
    seen: Int[Array, " n"]
    trusted: Bool[Array, " n"]

    @classmethod
    def unknown(cls, n: int, coefficients: int) -> "FittedCars":
        """Rows of which nothing is known."""
        s = 3 + coefficients
        return cls(
            shape=np.full((n, coefficients), np.nan),
            yaw=np.full(n, np.nan),
            size=np.full((n, 3), np.nan),
            base=np.full((n, 3), np.nan),
            cov=np.full((n, s, s), np.nan),
            residual=np.full(n, np.nan),
            seen=np.zeros(n, np.int64),
            trusted=np.zeros(n, bool),
        )

    def put(self, rows: Int[Array, " m"], found: "FittedCars") -> None:
        """Write fits into rows (while the table is being made)."""
        for column in fields(self):
            getattr(self, column.name)[rows] = getattr(found, column.name)

    @property
    def pose(self) -> Float[Array, "n 3"]:
        """The axis-angle vectors of eq. 6, in the road frame."""
        return self.yaw[:, None] * np.array([0.0, 1.0, 0.0])

    @property
    def pose_cov(self) -> Float[Array, "n c c"]:
        """The covariance of (yaw, coefficients)."""
        return self.cov[:, 2:, 2:]

    @property
    def cuboids(self) -> Cuboids:
        """The cars as boxes on the road."""
        return Cuboids(self.base, self.yaw, self.size)

    def onto(self, detections: Detections) -> Detections:
        """The detections with yaw, size, shape and covariance; NaN where the fit is not trusted."""
        if len(detections) != len(self):
            raise BadDetections(f"{len(self)} fits for {len(detections)} boxes: give one a box")
        wrong = ~self.trusted
        columns = {
            "yaw": self.yaw,
            "size": self.size,
            "shape": self.shape,
            "pose_cov": self.pose_cov,
        }
        masked = {
            name: np.where(wrong.reshape(-1, *[1] * (column.ndim - 1)), np.nan, column)
            for name, column in columns.items()
        }
        return replace(detections, **masked)


def no_car_fits(
    fitted: FittedCars, max_residual: float = 2.5, min_seen: int = 4
) -> Bool[Array, " n"]:
    """Which boxes hold no car, as the paper discards false detections: no car fits their points.

    Only boxes with at least `min_seen` points are judged: of the others nothing is known.
    max_residual: looser than what is asked of a trusted fit, so that a true car of which a
    detector put some points wrong is not thrown away (`benchmarks.shape_fit` prints both losses).
    """
    return (fitted.seen >= min_seen) & ~(fitted.residual <= max_residual)
