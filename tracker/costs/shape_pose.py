"""How alike two cars look: shape and pose of single-view fits (eq. 6)."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int
from numpy import ndarray as Array

from tracker.costs.gating import GatedPairs
from tracker.errors import MissingCue
from tracker.kernels import Kernel
from tracker.types.shape_pose import ShapePose

SQUARE_LOOKS = Kernel("tracker.kernels.comparing", "square_looks")


@dataclass(frozen=True)
class ShapeAndPose:
    """1 - exp(-(eta_s |lambda - lambda'|^2 + eta_p |omega - omega'|^2) / 2), eq. 6.

    Unlike the paper: both squares are weighted by the covariances of the two fits, the pose
    difference is the angle of the rotation between the two (so that +-pi are close), and the sum
    is mapped to [0, 1). Each eta is 1 over the mean of the weighted squares between two detections
    of one car, of the fleet under a drawn keypoint noise (`benchmarks.shape_fit`).
    """

    eta_shape: float = 0.4
    """Weight of the squared difference of shapes; more: other shapes cost more."""
    eta_pose: float = 1.6
    """Weight of the squared difference of yaws; more: other yaws cost more."""
    shape_floor: float = 0.02
    """Std of the coefficients of eq. 1 that no fit undercuts; more: small differences of shape cost
    less."""
    yaw_floor: float = 0.03
    """Std of the yaw that no fit undercuts, rad; more: small turns cost less."""

    def __call__(self, pairing: GatedPairs) -> Float[Array, " k"]:
        """The cost of every pair; NaN where a fit is missing or not trusted.

        Raises MissingCue when the detections, or the tracks, have no shapes and poses at all.
        """
        rows, columns = pairing.pairs
        if not len(rows):
            return np.zeros(0)
        before = _required(pairing.expected.shape_pose, "tracks")
        now = _required(pairing.observed.shape_pose, "detections")
        shape, pose = self.squares(before, now, rows, columns)
        return -np.expm1(-0.5 * (self.eta_shape * shape + self.eta_pose * pose))

    def squares(
        self,
        before: ShapePose,
        now: ShapePose,
        rows: Int[Array, " k"] | None = None,
        columns: Int[Array, " k"] | None = None,
    ) -> tuple[Float[Array, " k"], Float[Array, " k"]]:
        """Squared differences of shape and of pose in units of their variances, pair by pair.

        rows, columns: the pairs, of both tables; None: row by row. On the road both rotations are
        about the same axis: the angle between them is that of the yaws.
        """
        rows = np.arange(len(before)) if rows is None else rows
        columns = np.arange(len(now)) if columns is None else columns
        out = np.empty(len(rows)), np.empty(len(rows))
        looks = before.shape, before.yaw, before.cov, now.shape, now.yaw, now.cov
        floors = self.shape_floor**2, self.yaw_floor**2
        SQUARE_LOOKS(*looks, rows, columns, *floors, *out)
        return out


def _required(looks: ShapePose | None, whose: str) -> ShapePose:
    """The column, or what to do about its absence."""
    if looks is None:
        raise MissingCue(
            f"the cost 'shape_pose' needs shape and yaw, which these {whose} do not have: give "
            "Detections the columns `yaw`, `shape` and `pose_cov` (see tracker.shape.ShapeFit), "
            "or leave this cost out"
        )
    return looks
