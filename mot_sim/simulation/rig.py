"""The camera on the ego car: from the world to the road and camera frames."""

from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float
from numpy import ndarray as Array

from mot_sim.simulation.traffic.recording import RecordedTraffic
from mot_sim.simulation.traffic.traffic_state import TrafficState
from tracker.errors import BadCalibration
from tracker.geometry import homogeneous, invert, rotation_x, rotation_z, transform, wrap_angle
from tracker.types import Camera, Cuboids

# KITTI's camera 2 on the tracking benchmark, and where it stands.
KITTI_K = ((721.5377, 0.0, 609.5593), (0.0, 721.5377, 172.854), (0.0, 0.0, 1.0))
KITTI_IMAGE_SIZE = (1242, 375)
KITTI_HEIGHT_METRES = 1.65
PIVOT_HEIGHT_METRES = 0.93  # above the road: what the ego car's body pitches and rolls about


@dataclass(frozen=True, eq=False)
class Rig:
    """A camera above the reference point (x, y) of the ego car, looking along its heading."""

    camera: Camera
    """Calibration and mounting; it must look ahead and stand upright, with focal lengths > 0."""

    def __post_init__(self) -> None:
        R_road_cam = self.camera.T_road_cam[:3, :3]
        if min(R_road_cam[1, 1], R_road_cam[2, 2]) <= 0.0:
            ahead, down = np.round(R_road_cam[:, 2], 3).tolist(), np.round(R_road_cam[:, 1], 3)
            raise BadCalibration(
                f"the camera looks along {ahead} of the road (right, down, forward), its lower "
                f"edge is towards {down.tolist()}: it must look ahead and stand upright; pitch "
                "and roll are radians, within +-1.57"
            )

    @classmethod
    def kitti(
        cls, height: float = KITTI_HEIGHT_METRES, pitch: float = 0.0, roll: float = 0.0
    ) -> "Rig":
        """KITTI's camera; pitch > 0 looks up, roll > 0 leans right, radians."""
        return cls(Camera.mounted(np.array(KITTI_K), KITTI_IMAGE_SIZE, height, pitch, roll))

    def T_world_road(self, ego: Float[Array, "3"]) -> Float[Array, "4 4"]:
        """From the road frame under the camera to the world, for an ego pose x, y, heading.

        The road's x is the ego's right, its y is down, its z is forward.
        """
        x, y, heading = ego
        c, s = np.cos(heading), np.sin(heading)
        R_world_road = np.array([[-s, 0.0, c], [c, 0.0, s], [0.0, 1.0, 0.0]])
        return homogeneous(R_world_road, np.array([x, y, 0.0]))

    def T_world_cam(
        self, ego: Float[Array, "3"], tilt: Float[Array, "2"] | None = None
    ) -> Float[Array, "4 4"]:
        """From the camera to the world, for an ego pose x, y, heading and a tilt of its body."""
        return self.T_world_road(ego) @ T_road_body(tilt) @ self.camera.T_road_cam

    def Ts_world_cam(self, traffic: RecordedTraffic) -> Float[Array, "t 4 4"]:
        """The same in every state of a run."""
        tilts = [None] * len(traffic) if traffic.tilt is None else traffic.tilt
        return np.array(
            [self.T_world_cam(ego, tilt) for ego, tilt in zip(traffic.ego, tilts, strict=True)]
        )

    def camera_in(self, state: TrafficState) -> Camera:
        """The camera as it stands above the level road in a state, tilted with the ego car."""
        if state.tilt is None:
            return self.camera
        T_cam_road = self.camera.T_cam_road @ invert(T_road_body(state.tilt))
        return replace(self.camera, T_cam_road=T_cam_road)

    def cuboids(self, state: TrafficState) -> Cuboids:
        """The cars of a state in the road frame: yaw = heading - ego heading - pi/2.

        Where the ego car's body tilts, the frame tilts with it, as KITTI's labels do; cuboids then
        stand as upright in it as without, which is wrong by the tilt.
        """
        x, y, heading = state.ego
        c, s = np.cos(heading), np.sin(heading)
        dx, dy = state.x - x, state.y - y
        down = np.zeros(len(state)) if state.z is None else state.z
        base = np.stack((c * dy - s * dx, down, c * dx + s * dy), axis=1)
        if state.tilt is not None:
            base = transform(invert(T_road_body(state.tilt)), base)
        yaw = np.asarray(wrap_angle(state.heading - heading - 0.5 * np.pi))
        return Cuboids(base, yaw, state.size)

    def ground_cam(
        self, ego: Float[Array, "3"], points: Float[Array, "n 2"]
    ) -> Float[Array, "n 3"]:
        """Points (x, y) on the world's ground, in camera coordinates."""
        x, y, heading = ego
        c, s = np.cos(heading), np.sin(heading)
        dx, dy = (points - (x, y)).T
        points_road = np.stack((c * dy - s * dx, np.zeros(len(points)), c * dx + s * dy), axis=1)
        return transform(self.camera.T_cam_road, points_road)


def T_road_body(tilt: Float[Array, "2"] | None) -> Float[Array, "4 4"]:
    """From the road as it seems from a car whose body tilts to the level road.

    tilt: pitch, > 0 looks up, and roll, > 0 leans right, radians, about PIVOT_HEIGHT_METRES above
    the road; None: none.
    """
    if tilt is None:
        return np.eye(4)
    R_road_body = rotation_x(float(tilt[0])) @ rotation_z(float(tilt[1]))
    pivot = np.array([0.0, -PIVOT_HEIGHT_METRES, 0.0])
    return homogeneous(R_road_body, pivot - R_road_body @ pivot)
