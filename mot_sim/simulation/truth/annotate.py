"""From traffic to ground truth: the cars are drawn, and what the pixels say is written down."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, Int, UInt8
from numpy import ndarray as Array

from mot_sim.simulation.cars.vehicles import Vehicles
from mot_sim.simulation.renderers import MeshInstances, Scan, View, scan_view
from mot_sim.simulation.renderers.triangles import NEAR_METRES
from mot_sim.simulation.scene_meshes import SceneMeshes
from mot_sim.simulation.traffic.traffic_state import TrafficState
from mot_sim.simulation.truth.cuboid_boxes import truncation_of
from mot_sim.simulation.truth.table import (
    MAX_TRUNCATION,
    Occlusions,
    Truth,
    occlusion_level,
)
from tracker.geometry import wrap_angle
from tracker.kernels import Kernel
from tracker.types import Camera, Tracks

# How far behind its own car's drawn surface a point may seem to lie and still be on it: metres,
# and besides the slant of a surface over a pixel at grazing angles, in pixels of that depth.
THICKNESS_METRES = 0.04
SLANT_PIXELS = 3.0
JUDGE_KEYPOINTS = Kernel("mot_sim.simulation.kernels.layers", "judge_keypoints")


@dataclass(frozen=True, eq=False)
class Annotations:
    """The ground truth of some frames."""

    truth: Truth
    """One row per car and frame."""
    occlusions: Occlusions
    """Who hides whom."""

    @classmethod
    def concatenate(cls, parts: "list[Annotations]") -> "Annotations":
        """The frames of all parts, in order."""
        return cls(
            Truth.concatenate([part.truth for part in parts]),
            Occlusions.concatenate([part.occlusions for part in parts]),
        )


def annotate(
    states: Iterable[TrafficState],
    scene_meshes: SceneMeshes,
    scenery_in: Callable[[TrafficState], MeshInstances | None] | None = None,
) -> Annotations:
    """The truth of a run of one or more states; state i is frame i.

    scenery_in: what else the camera may see in a state.
    """
    parts: list[Annotations] = []
    before: TrafficState | None = None
    for frame, state in enumerate(states):
        scenery = None if scenery_in is None else scenery_in(state)
        parts.append(annotate_frame(state, scene_meshes, frame, before, scenery))
        before = state
    return Annotations.concatenate(parts)


def annotate_frame(
    state: TrafficState,
    scene_meshes: SceneMeshes,
    frame: int,
    before: TrafficState | None = None,
    scenery: MeshInstances | None = None,
) -> Annotations:
    """The truth of one frame; before: the state a step earlier. scenery hides cars, has no row."""
    rig, vehicles = scene_meshes.rig, scene_meshes.vehicles
    instances = scene_meshes.instances(state, scenery)
    scanned = scan_view(View(rig.camera, instances, road=None))
    seen = scanned.silhouettes
    boxes, truncation = seen.clipped_boxes, truncation_of(seen.amodal_boxes, rig.camera)
    rows = np.flatnonzero((seen.amodal > 0) & (boxes[:, 2:] > boxes[:, :2]).all(axis=1))
    seen, vehicle_rows = seen.select(rows), vehicles.rows(state.ids[rows])
    keypoints_cam, faces_us = keypoints_of(vehicles, vehicle_rows, instances.T_cam_object[rows])
    keypoints, states = seen_keypoints(keypoints_cam, faces_us, seen.instances, scanned, rig.camera)
    speed, heading = state.speed[rows], state.heading[rows]
    acceleration, yaw_rate = rates(state, before)
    truth = Truth(
        tracks=Tracks(
            frames=np.full(len(rows), frame),
            ids=seen.instances,
            boxes=boxes[rows],
            kinds=vehicles.kinds[vehicle_rows],
            truncation=(truncation[rows] > MAX_TRUNCATION).astype(np.int64),
            occlusion=occlusion_level(seen.fraction),
            cuboids=rig.cuboids(state).select(rows),
        ),
        visible=seen.fraction,
        truncation=truncation[rows],
        amodal_boxes=seen.amodal_boxes,
        visible_boxes=np.where(np.isinf(seen.visible_boxes), np.nan, seen.visible_boxes),
        pixels=seen.visible,
        amodal_pixels=seen.amodal,
        keypoints=keypoints,
        keypoint_states=states,
        speed=speed,
        velocity=speed[:, None] * np.stack((np.cos(heading), np.sin(heading)), axis=1),
        acceleration=acceleration[rows],
        yaw_rate=yaw_rate[rows],
    )
    return Annotations(truth, occlusions_of(scanned, truth, frame))


def keypoints_of(
    vehicles: Vehicles, rows: Int[Array, " n"], Ts_cam_car: Float[Array, "n 4 4"]
) -> tuple[Float[Array, "n 36 3"], Bool[Array, "n 36"]]:
    """The keypoints of some cars in camera coordinates; which lie on a face that looks at us."""
    points_cam = vehicles.keypoints[rows] @ Ts_cam_car[:, :3, :3].swapaxes(1, 2)
    points_cam += Ts_cam_car[:, None, :3, 3]
    eyes = -(Ts_cam_car[:, None, :3, 3] @ Ts_cam_car[:, :3, :3])[:, 0]  # the camera, to each car
    return points_cam, vehicles.faces_eye(rows, eyes)


def occlusions_of(scanned: Scan, truth: Truth, frame: int) -> Occlusions:
    """Who hides the cars that have a row."""
    hidden, known = scanned.hidden, np.zeros(len(scanned.layers.instances), bool)
    known[np.searchsorted(scanned.layers.instances, truth.tracks.ids)] = True
    hidden = hidden.select(known[np.searchsorted(scanned.layers.instances, hidden.instances)])
    frames = np.full(len(hidden), frame)
    return Occlusions(frames, hidden.instances, hidden.occluder_ids, hidden.pixels)


def rates(
    state: TrafficState, before: TrafficState | None
) -> tuple[Float[Array, " n"], Float[Array, " n"]]:
    """Acceleration and yaw rate since the state before; 0 for who was not there."""
    acceleration, yaw_rate = np.zeros(len(state)), np.zeros(len(state))
    if before is not None and len(before):
        at = np.searchsorted(before.ids, state.ids).clip(max=len(before) - 1)
        here = before.ids[at] == state.ids
        step = state.time - before.time
        turned = np.asarray(wrap_angle(state.heading - before.heading[at]))
        acceleration = np.where(here, (state.speed - before.speed[at]) / step, 0.0)
        yaw_rate = np.where(here, turned / step, 0.0)
    return acceleration, yaw_rate


def seen_keypoints(
    points_cam: Float[Array, "n k 3"],
    faces_us: Bool[Array, "n k"],
    ids: Int[Array, " n"],
    scanned: Scan,
    camera: Camera,
) -> tuple[Float[Array, "n k 2"], UInt8[Array, "n k"]]:
    """The pixels of the keypoints of cars, and a `KeypointVisibility` of each.

    faces_us: which points lie on a face of their car that looks at the camera. All others are
    self-occluded, and so are points where their own car, drawn alone, is nearer in all nine pixels
    around; occluded are points at whose pixel another object is seen.
    """
    states = np.empty(points_cam.shape[:2], np.uint8)
    layers = scanned.layers
    JUDGE_KEYPOINTS(
        np.ascontiguousarray(points_cam),
        np.ascontiguousarray(faces_us),
        np.searchsorted(layers.instances, ids),
        np.ascontiguousarray(camera.K, float),
        NEAR_METRES,
        layers.nearness,
        layers.starts,
        layers.boxes,
        scanned.numbers,
        THICKNESS_METRES,
        SLANT_PIXELS / float(camera.K[0, 0]),
        states,
    )
    return camera.project(points_cam), states
