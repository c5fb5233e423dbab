"""What is expected of tracks in a frame, with what lies in their search areas, at once."""

from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
from jaxtyping import Float
from numpy import ndarray as Array

from tracker.beliefs import Beliefs
from tracker.costs.gating import view_of_regions
from tracker.dynamics import ConstantPosition, ConstantVelocity
from tracker.ego_motion import LIMITS
from tracker.kernels import Kernel
from tracker.lifecycle import ActiveTracks
from tracker.types import Camera, Cuboids
from tracker.types.packed import NO_INTS, Packed, read_only
from tracker.types.shape_pose import ShapePose

EXPECT_TRACKS = Kernel("tracker.kernels.expecting", "expect_tracks")


class Expectation(NamedTuple):
    """The tracks as they should be, and what lies in their search areas."""

    tracks: ActiveTracks
    """In the road frame of now, without scores."""
    gated: dict[str, Any]
    """The columns of `GatedPairs` that its constructor would make of them."""

    @classmethod
    def of(
        cls,
        tracks: ActiveTracks,
        observed: Beliefs,
        dynamics: ConstantPosition | ConstantVelocity,
        motion: tuple[Float[Array, "4 4"], Float[Array, "6 6"]],
        seconds: tuple[float, float],
        camera: Camera,
        sigmas: float,
    ) -> "Expectation":
        """That of tracks after a motion of the camera, with its covariance, as in `Frame`.

        observed: the detections of now, lifted. seconds: that passed, and the probability that a
        car is still there after them. It is what `predict`, `compensate_ego_motion` and
        `GatedPairs` give.
        """
        (n, floats, ints), (m, seen, _), dt = tracks.packed, observed.packed, seconds[0]
        most = n * m
        now, pairs = np.empty(47 * n + 35), np.empty(2 * most, np.int64)
        count = EXPECT_TRACKS(
            floats, n, seen, m, *seconds, *dynamics.motion_model(dt), *motion, _lens(camera),
            sigmas, now, pairs,
        )  # fmt: skip
        packed, before = Packed(n, read_only(now), ints), tracks.beliefs
        pose = before.shape_pose
        if pose is not None:
            pose = pose.after(dt)
            pose = ShapePose(pose.shape, pose.yaw + now[-1], pose.cov)
        beliefs = Beliefs.of_packed(packed, shape_pose=pose, embedding=before.embedding)
        gated = {
            "expected_regions": Cuboids.of_packed(Packed(n, now[36 * n :], NO_INTS)),
            "search_areas": now[43 * n : 47 * n].reshape(n, 4),
            "pairs": (pairs[:count], pairs[most : most + count]),
            "shape": (n, m),
        }
        return cls(ActiveTracks.of_packed(packed, beliefs=beliefs, cars=tracks.cars), gated)


@lru_cache(maxsize=16)
def _lens(camera: Camera) -> Float[Array, "144"]:
    """What the kernel takes of a camera, one after the other: an array costs a call as ten rows."""
    P, centre, far, signs, *depths = view_of_regions(camera)
    moves = camera.K, camera.K_inverse, camera.T_cam_road, camera.T_road_cam, camera.road_shift
    return np.concatenate(
        [np.ravel(each) for each in (*moves, P, signs, far, centre, LIMITS, depths)]
    )
