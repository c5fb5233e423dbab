"""The labelled cars of a real drive, re-enacted: KITTI's tracks as states.

A state is planar, a drive is not. Kept exactly, in every frame: the pose of every labelled car
in the road frame under the camera (x, y, z and yaw) and its size, so that the rig gives the
label's cuboid back. Of the drive itself we keep what happens in the road plane of the first
frame: the rise, pitch and roll of our car between frames are left out, so a parked car may move
by the centimetres that these make.
"""

from collections.abc import Sequence

import numpy as np
from jaxtyping import Float
from numpy import ndarray as Array

from mot_sim.datasets.camera_files import planar_poses
from mot_sim.datasets.kitti import KittiSequence
from mot_sim.simulation.traffic.recording import RecordedTraffic, Replay
from mot_sim.simulation.traffic.scripted import SEDAN_SIZE
from mot_sim.simulation.traffic.traffic_state import STEP_SECONDS, TrafficState
from tracker.errors import BadConfig
from tracker.types import Tracks

REPLAYED_KINDS = ("Car", "Van")


def kitti_replay(sequence: KittiSequence, kinds: Sequence[str] = REPLAYED_KINDS) -> Replay:
    """The labelled cars of a sequence as traffic; see `kitti_recording`."""
    return Replay(kitti_recording(sequence, kinds))


def kitti_recording(
    sequence: KittiSequence, kinds: Sequence[str] = REPLAYED_KINDS
) -> RecordedTraffic:
    """The labelled cars of a sequence, a state a frame, with the ids of the labels.

    Raises BadConfig for a sequence without labels or motion, for a subset, and for kinds that
    no label has.
    """
    tracks, Ts_world_cam = sequence.truth, sequence.Ts_world_cam
    if tracks is None or tracks.cuboids is None or tracks.kinds is None:
        raise BadConfig(f"sequence {sequence.name} has no labelled cuboids to replay")
    if Ts_world_cam is None:
        raise BadConfig(f"sequence {sequence.name}: its motion is unknown; read it with ego 'oxts'")
    if len(sequence) != sequence.frame_count or not len(sequence):
        raise BadConfig(f"sequence {sequence.name}: replay needs all frames, not a subset or none")
    known = np.isfinite(tracks.cuboids.base).all(axis=1)
    if not (known & np.isin(tracks.kinds, list(kinds))).any():
        raise BadConfig(
            f"sequence {sequence.name} has no labels of kinds {', '.join(kinds)}; it has "
            f"{', '.join(np.unique(tracks.kinds[known]).tolist())}"
        )
    cars = tracks.select(known & np.isin(tracks.kinds, list(kinds)))
    cars = cars.select(np.lexsort((cars.ids, cars.frames)))
    egos = planar_poses(Ts_world_cam @ sequence.camera.T_cam_road)
    poses = world_poses(cars, egos)
    speed = speeds(cars, poses)
    states = []
    for frame, ego in enumerate(egos):
        rows = slice(*np.searchsorted(cars.frames, [frame, frame + 1]).tolist())
        states.append(_state(cars.select(rows), poses[rows], speed[rows], ego, frame))
    return RecordedTraffic.of(states)


def world_poses(cars: Tracks, egos: Float[Array, "t 3"]) -> Float[Array, "n 3"]:
    """x, y, heading of labelled cars: the inverse of what the rig does. Not wrapped."""
    assert cars.cuboids is not None
    x, y, heading = egos[cars.frames].T
    right, _, forward = cars.cuboids.base.T
    c, s = np.cos(heading), np.sin(heading)
    turned = cars.cuboids.yaw + heading + 0.5 * np.pi
    return np.stack((x + c * forward - s * right, y + s * forward + c * right, turned), axis=1)


def speeds(cars: Tracks, poses: Float[Array, "n 3"]) -> Float[Array, " n"]:
    """Metres per second along the heading, between the frames before and after; 0 if alone."""
    speed = np.zeros(len(cars))
    for number in np.unique(cars.ids):
        rows = np.flatnonzero(cars.ids == number)
        if len(rows) > 1:
            moved = np.gradient(poses[rows, :2], cars.frames[rows] * STEP_SECONDS, axis=0)
            heading = poses[rows, 2]
            speed[rows] = moved[:, 0] * np.cos(heading) + moved[:, 1] * np.sin(heading)
    return speed


def _state(
    cars: Tracks,
    poses: Float[Array, "n 3"],
    speed: Float[Array, " n"],
    ego: Float[Array, "3"],
    frame: int,
) -> TrafficState:
    assert cars.cuboids is not None
    return TrafficState(
        time=frame * STEP_SECONDS,
        ids=cars.ids,
        x=poses[:, 0],
        y=poses[:, 1],
        heading=poses[:, 2],
        speed=speed,
        size=cars.cuboids.size,
        ego=ego,
        ego_size=np.array(SEDAN_SIZE),
        z=cars.cuboids.base[:, 1],
        kinds=cars.kinds,
    )
