"""Shape and pose as last measured: what eq. 6 compares."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy import ndarray as Array

from tracker.types.detections import Detections
from tracker.types.rows import Rows

# How fast cars turn: root mean square yaw rate of KITTI's labelled cars, ten sequences, rad/s.
TURN_RATE_STD = 0.08


@dataclass(frozen=True, eq=False)
class ShapePose(Rows):
    """The shape and pose that were last measured of objects; NaN rows where none ever was."""

    shape: Float[Array, "n b"]
    """Coefficients of eq. 1."""
    yaw: Float[Array, " n"]
    """About road +y in the road frame of now, rad."""
    cov: Float[Array, "n c c"]
    """Covariance of (yaw, shape); c = b + 1."""

    def unknown(self, count: int) -> "ShapePose":
        """`count` rows whose shape and pose were not measured."""
        b = self.shape.shape[1]
        c = b + 1
        blank = np.full((count, b), np.nan), np.full(count, np.nan), np.full((count, c, c), np.nan)
        return ShapePose(*blank)

    @classmethod
    def of(cls, detections: Detections) -> "ShapePose | None":
        """Those of detections; None without a column of shapes or of yaws.

        Where a detector states no covariance, that of what it measured is 0.
        """
        shape, yaw, cov = detections.shape, detections.yaw, detections.pose_cov
        if shape is None or yaw is None:
            return None
        if cov is None:
            c = shape.shape[1] + 1
            cov = np.zeros((len(yaw), c, c))
        return cls(shape, yaw, cov)

    @property
    def is_complete(self) -> bool:
        """Whether shape and yaw were measured in all rows."""
        return bool(np.isfinite(self.shape).all() and np.isfinite(self.yaw).all())

    def after(self, dt: float) -> "ShapePose":
        """The same, `dt` seconds later: cars may have turned."""
        cov = self.cov.copy()
        cov[:, 0, 0] += (TURN_RATE_STD * dt) ** 2
        return ShapePose(self.shape, self.yaw, cov)

    def filled_from(self, before: "ShapePose | None") -> "ShapePose":
        """The same, with the rows of `before` where nothing is known."""
        known = np.isfinite(self.shape).all(axis=1) & np.isfinite(self.yaw)
        if before is None or known.all():
            return self
        return ShapePose(
            np.where(known[:, None], self.shape, before.shape),
            np.where(known, self.yaw, before.yaw),
            np.where(known[:, None, None], self.cov, before.cov),
        )
