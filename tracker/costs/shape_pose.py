"""How alike two cars look: shape and pose of single-view fits (eq. 6)."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy import ndarray as Array

from tracker.costs.gating import GatedPairs
from tracker.errors import MissingCue
from tracker.geometry import wrap_angle
from tracker.types.shape_pose import ShapePose


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
        before = _required(pairing.expected.shape_pose, "tracks").select(rows)
        now = _required(pairing.observed.shape_pose, "detections").select(columns)
        shape, pose = self.squares(before, now)
        return -np.expm1(-0.5 * (self.eta_shape * shape + self.eta_pose * pose))

    def squares(
        self, before: ShapePose, now: ShapePose
    ) -> tuple[Float[Array, " k"], Float[Array, " k"]]:
        """Squared differences of shape and of pose in units of their variances, row by row."""
        off = now.shape - before.shape
        cov = before.cov + now.cov
        b = off.shape[1]
        shape_cov = cov[:, 1:, 1:] + self.shape_floor**2 * np.eye(b)
        known = np.isfinite(off).all(axis=1) & np.isfinite(cov).all(axis=(1, 2))
        shape = np.full(len(off), np.nan)
        solved = np.linalg.solve(shape_cov[known], off[known][:, :, None])[:, :, 0]
        shape[known] = (off[known] * solved).sum(axis=1)
        # On the road both rotations are about the same axis: the angle between them is this.
        angle = wrap_angle(now.yaw - before.yaw)
        return shape, angle**2 / (cov[:, 0, 0] + self.yaw_floor**2)


def _required(looks: ShapePose | None, whose: str) -> ShapePose:
    """The column, or what to do about its absence."""
    if looks is None:
        raise MissingCue(
            f"the cost 'shape_pose' needs shape and yaw, which these {whose} do not have: give "
            "Detections the columns `yaw`, `shape` and `pose_cov` (see tracker.shape.ShapeFit), "
            "or leave this cost out"
        )
    return looks
