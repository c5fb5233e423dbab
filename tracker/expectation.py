"""What is expected of tracks in a frame, with what lies in their search areas, at once."""

from typing import Any, NamedTuple

import numpy as np
from jaxtyping import Float
from numpy import ndarray as Array

from tracker.beliefs import Beliefs
from tracker.costs.gating import view_of_regions
from tracker.dynamics import Dynamics
from tracker.ego_motion import LIMITS, RoadMotion
from tracker.kernels import Kernel
from tracker.lifecycle import ActiveTracks
from tracker.types import Camera, Cuboids
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
        dynamics: Dynamics,
        motion: tuple[Float[Array, "4 4"], Float[Array, "6 6"]],
        seconds: tuple[float, float],
        camera: Camera,
        sigmas: float,
    ) -> "Expectation":
        """That of tracks after a motion of the camera, with its covariance, as in `Frame`.

        observed: the detections of now, lifted. seconds: that passed, and the probability that a
        car is still there after them. It is what `compensate_ego_motion` and `GatedPairs` give.
        """
        (T_now_before, motion_cov), n = motion, len(tracks)
        before, moved = dynamics.predict(tracks.beliefs, seconds[0])
        T_road, turn, *pixels = RoadMotion.of(T_now_before, camera)
        cuboids, seen, most = before.cuboids, observed.boxes, n * len(observed)
        moved = np.zeros((n, 2)) if moved is None else moved
        (base, stretched), (boxes, areas) = np.empty((2, n, 3)), np.empty((2, n, 4))
        yaw, since, existence, scores = np.empty((4, n))
        velocity, covs, (rows, columns) = (
            np.empty((n, 2)),
            np.empty((n, 4, 4)),
            np.empty((2, most), np.int64),
        )
        *lens, corner_depth, depth = view_of_regions(camera)
        depths = corner_depth, depth
        count = EXPECT_TRACKS(
            cuboids.base, cuboids.yaw, cuboids.size, before.velocity, before.cov, before.boxes,
            moved, tracks.time_since_update, tracks.existence, *seconds, T_road, turn, *pixels,
            camera.road_shift, motion_cov, camera.T_cam_road[2], *lens, LIMITS, sigmas, *depths,
            seen, base, yaw, velocity, covs, boxes, since, existence, scores, stretched, areas,
            rows, columns,
        )  # fmt: skip
        pose = before.shape_pose
        if pose is not None:
            pose = ShapePose(pose.shape, pose.yaw + turn, pose.cov)
        places = Cuboids(base, yaw, cuboids.size)
        beliefs = Beliefs(places, velocity, covs, boxes, pose, before.embedding)
        now = tracks.replaced(
            beliefs=beliefs, time_since_update=since, existence=existence, scores=scores
        )
        gated = {
            "expected_regions": Cuboids(base, yaw, stretched),
            "search_areas": areas,
            "pairs": (rows[:count], columns[:count]),
        }
        return cls(now, gated)
