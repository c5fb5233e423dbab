"""A drive as a map: where we are in each frame, the roads, and the true outlines of the cars."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from jaxtyping import Float
from numpy import ndarray as Array

from mot_sim.datasets.camera_files import planar_poses
from mot_sim.datasets.recorded import RecordedSequence
from mot_sim.metrics.preprocessing import kind_is
from mot_sim.simulation.episode import Episode, SimulatedDrive
from mot_sim.simulation.episodes import StoredEpisode
from mot_sim.simulation.registry import find_scene
from mot_sim.simulation.traffic.roads import Roads
from mot_sim.simulation.traffic.traffic_state import TrafficState, outline
from tracker.errors import TrackingError
from tracker.geometry import homogeneous
from tracker.types import Camera, Cuboids, Tracks

OUR_SIZE = np.array([[4.4, 1.5, 1.8]])  # metres; our car, where nobody says
CAMERA_AHEAD = 0.3  # metres from the middle of KITTI's car to its camera


@dataclass(frozen=True, eq=False)
class GroundMap:
    """The map of a drive: x forward and y right at its first frame (a scene: its world), metres."""

    poses: Float[Array, "m 3"] | None
    """x, y in metres and heading in radians of the camera, a row per frame of the recording; None:
    unknown, and every frame has a map of its own."""
    truth: Tracks | None
    """Labels, whose cuboids are shown; None: no true cars are shown."""
    roads: Roads
    """Its roads; empty where they are unknown."""
    worlds: tuple[TrafficState, ...] | None = None
    """Where every car of a scene is, one per frame; None: not a scene, or its truth is not
    shown."""
    kind: str = "Car"
    """The class whose labels are shown; with cars vans are."""

    @classmethod
    def of(cls, drive: RecordedSequence, truth: Tracks | None, kind: str = "Car") -> "GroundMap":
        """The map of a drive. truth: what may be shown of it, of a class."""
        if isinstance(drive, SimulatedDrive):
            worlds = drive.traffic_states if truth is not None else None
            return cls(drive.traffic.ego, truth, road_outlines(drive), worlds)
        return cls(_poses_of(drive), truth, Roads(), kind=kind)

    def pose(self, frame: int) -> Float[Array, "3"]:
        """Where the camera is in a frame."""
        return np.zeros(3) if self.poses is None else self.poses[frame]

    def our_outline(self, frame: int) -> Float[Array, "4 2"]:
        """The corners of the car that carries the camera."""
        if self.worlds is not None:
            return self.worlds[frame].ego_footprint()
        x, y, heading = self.pose(frame)
        ahead = CAMERA_AHEAD * np.array([np.cos(heading), np.sin(heading)])
        return outline(np.array([[x - ahead[0], y - ahead[1], heading]]), OUR_SIZE)[0]

    def true_outlines(self, frame: int) -> Float[Array, "n 4 2"]:
        """The corners of the cars, the first two at the nose: in a scene all of them, else the
        labelled ones of the class."""
        if self.worlds is not None:
            return self.worlds[frame].footprint()
        if self._cuboid_rows is None:
            return np.zeros((0, 4, 2))
        cuboids = self._cuboid_rows.select(self._cuboid_rows.frames == frame).cuboids
        assert cuboids is not None
        return self.outlines(cuboids, frame)

    def outlines(self, cuboids: Cuboids, frame: int) -> Float[Array, "n 4 2"]:
        """The corners of cuboids of a frame, on the map; the first two are at the nose."""
        return self.on_map(cuboids.footprint()[:, [0, 3, 2, 1]], frame)

    @cached_property
    def _cuboid_rows(self) -> Tracks | None:
        if self.truth is None or self.truth.cuboids is None:
            return None
        known = np.isfinite(self.truth.cuboids.base).all(axis=1)
        of_kind = kind_is(self.truth, self.kind, True)
        if self.kind == "Car":
            of_kind |= kind_is(self.truth, "Van", False)
        return self.truth.select(known & of_kind)

    def on_map(self, points_road: Float[Array, "*n 2"], frame: int) -> Float[Array, "*n 2"]:
        """Points (x right, z forward) of the road frame of a frame, on the map."""
        x, y, _ = self.pose(frame)
        right, ahead = points_road[..., 0], points_road[..., 1]
        c, s = self._turn(frame)
        return np.stack((x + c * ahead - s * right, y + s * ahead + c * right), axis=-1)

    def T_map_cam(self, frame: int, camera: Camera) -> Float[Array, "4 4"]:
        """From the camera of a frame to the map, z down."""
        x, y, _ = self.pose(frame)
        c, s = self._turn(frame)
        R_map_road = np.array([[-s, 0.0, c], [c, 0.0, s], [0.0, 1.0, 0.0]])
        return homogeneous(R_map_road, np.array([x, y, 0.0])) @ camera.T_road_cam

    def cov_on_map(self, cov: Float[Array, "n 2 2"], frame: int) -> Float[Array, "n 2 2"]:
        """Covariances of (x, z) of the road frame, on the map."""
        c, s = self._turn(frame)
        R = np.array([[-s, c], [c, s]])
        return R @ cov @ R.T

    def _turn(self, frame: int) -> tuple[float, float]:
        heading = float(self.pose(frame)[2])
        return float(np.cos(heading)), float(np.sin(heading))


def _poses_of(drive: RecordedSequence) -> Float[Array, "m 3"] | None:
    """x, y and heading of the camera on the road plane of the first frame; None where unknown."""
    if drive.Ts_world_cam is None or not len(drive.Ts_world_cam):
        return None
    return planar_poses(drive.Ts_world_cam @ drive.camera.T_cam_road)


def road_outlines(drive: SimulatedDrive) -> Roads:
    """The roads of the scene; of a recorded one, where it is still known by name.

    No module that only a file names is imported: for a scene of somebody's own the map is plain.
    """
    if isinstance(drive, Episode):
        return drive.scene.roads
    if isinstance(drive, StoredEpisode) and ":" not in drive.metadata.scene:
        try:
            return find_scene(drive.metadata.scene, **drive.metadata.knobs).roads
        except TrackingError:
            return Roads()  # an episode of somebody else's scene: a plain map
    return Roads()
