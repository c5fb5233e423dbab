"""Ego-motion compensation: g(xi, .) of eqs. 3-4 of Sharma et al., ICRA 2018."""

import math
from typing import NamedTuple

import numpy as np
from jaxtyping import Float
from numpy import ndarray as Array

from tracker.beliefs import MIN_DEPTH, Beliefs
from tracker.errors import BadMotion
from tracker.geometry import adjoint_of
from tracker.kernels import Kernel
from tracker.types import Camera, Frame, max_step
from tracker.types.shape_pose import ShapePose

# How far an unknown camera motion may be from standing still in UNKNOWN_MOTION_SECONDS: 1 m along
# and 10 cm across the view, 1 degree of yaw; in a town.
UNKNOWN_MOTION_COV = np.diag(np.square([0.1, 0.03, 1.0, 0.005, 0.02, 0.003]))
UNKNOWN_MOTION_SECONDS = 0.1
NO_COV = np.zeros((6, 6))
# A box grows at most five times as the camera passes the car.
MIN_SCALE = 0.2
LIMITS = np.array([MIN_DEPTH, MIN_SCALE])
MOVE_ROAD = Kernel("tracker.kernels.expecting", "move_road")
CARRY_BELIEFS = Kernel("tracker.kernels.lifting", "carry_beliefs")


class CameraMotion(NamedTuple):
    """The camera's motion over one frame or several."""

    T_now_before: Float[Array, "4 4"]
    """As in `Frame`; standing still for as long as nothing is known."""
    known_cov: Float[Array, "6 6"]
    """Covariance of what is known, as in `Frame`."""
    seconds_unknown: float = 0.0
    """For how long nothing is known, s; `covariance` says how far standing still may be wrong."""

    @classmethod
    def of(cls, frame: Frame, seconds: float) -> "CameraMotion":
        """Of a frame that comes so many seconds after the one before it.

        BadMotion for a motion that is faster than any car.
        """
        T_now_before = frame.T_now_before
        if T_now_before is None:
            return cls(np.eye(4), NO_COV, seconds)
        metres = math.hypot(*T_now_before[:3, 3].tolist())
        if metres > max_step(seconds):
            raise BadMotion(
                f"frame {frame.index}: T_now_before moves the camera by {metres:.4g} m in "
                f"{seconds:.3g} s, faster than any car: is it in metres, from the last frame to "
                "this one (no pose in the world), and without a jump of the map? Give None where "
                "the motion is unknown"
            )
        return cls(T_now_before, NO_COV if frame.motion_cov is None else frame.motion_cov)

    @property
    def is_known(self) -> bool:
        """Whether the motion was given, over all frames."""
        return self.seconds_unknown == 0.0

    @property
    def covariance(self) -> Float[Array, "6 6"]:
        """What is unknown included: a camera goes on as it goes, so its std grows with time."""
        if self.is_known:
            return self.known_cov
        times = round(self.seconds_unknown, 6) / UNKNOWN_MOTION_SECONDS
        return self.known_cov + times**2 * UNKNOWN_MOTION_COV

    def after(self, before: "CameraMotion | None") -> "CameraMotion":
        """This motion after an earlier one, as one motion."""
        if before is None:
            return self
        adjoint = adjoint_of(self.T_now_before)
        return CameraMotion(
            self.T_now_before @ before.T_now_before,
            adjoint @ before.known_cov @ adjoint.T + self.known_cov,
            self.seconds_unknown + before.seconds_unknown,
        )


NO_MOTION = CameraMotion(np.eye(4), NO_COV)


class RoadMotion(NamedTuple):
    """What a motion of the camera does to the road frame and to pixels."""

    T_road: Float[Array, "4 4"]
    """Moves points of the road frame of before into that of now."""
    turn: float
    """Its yaw, rad."""
    H: Float[Array, "3 3"]
    """Moves pixels of what is infinitely far."""
    shift: Float[Array, "3"]
    """How homogeneous pixels move at depth 1 m besides."""
    by_moved: Float[Array, "3 2"]
    """How they do where the object itself goes a metre along road x, along road z."""

    @classmethod
    def of(cls, T_now_before: Float[Array, "4 4"], camera: Camera) -> "RoadMotion":
        """That of a motion of this camera, as in `Frame`."""
        lens, out = (camera.K, camera.K_inverse, camera.T_cam_road, camera.T_road_cam), np.empty(35)
        MOVE_ROAD(T_now_before, *lens, out)
        matrices = out[:16].reshape(4, 4), float(out[34]), out[16:25].reshape(3, 3)
        return cls(*matrices, out[25:28], out[28:34].reshape(3, 2))


def compensate_ego_motion(
    beliefs: Beliefs,
    camera: Camera,
    T_now_before: Float[Array, "4 4"],
    motion_cov: Float[Array, "6 6"],
    moved: Float[Array, "n 2"] | None = None,
) -> Beliefs:
    """The beliefs in the road frame of now, g(xi, .) of eqs. 3-4, the motion's covariance added.

    `moved` is how far each object itself went meanwhile, in the road frame of before, metres.
    The boxes move by the parallax of the car's near half: exact
    for a turning camera, to first order for a moving one.
    """
    n = len(beliefs)
    if n == 0:
        return beliefs
    T_road, turn, *pixels = RoadMotion.of(T_now_before, camera)
    out = np.empty((n, 3)), np.empty((n, 2)), np.empty((n, 4, 4)), np.empty((n, 4))
    shift = np.zeros((n, 2)) if moved is None else moved
    before = beliefs.cuboids.base, beliefs.cuboids.size, beliefs.velocity, beliefs.cov
    motion = T_road, camera.road_shift, motion_cov, camera.T_cam_road[2]
    CARRY_BELIEFS(*before, beliefs.boxes, shift, *motion, *pixels, LIMITS, *out)
    base, velocity, cov, boxes = out
    cuboids = beliefs.cuboids.replaced(base=base, yaw=beliefs.cuboids.yaw + turn)
    pose = beliefs.shape_pose
    if pose is not None:
        pose = ShapePose(pose.shape, pose.yaw + turn, pose.cov)
    return beliefs.replaced(
        cuboids=cuboids, velocity=velocity, cov=cov, boxes=boxes, shape_pose=pose
    )
