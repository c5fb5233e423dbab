"""One run of a scene while it is watched: frames and truth of a moment, made when asked for."""

from dataclasses import dataclass, field, fields, is_dataclass
from typing import Any

import numpy as np
from jaxtyping import Float
from numpy import ndarray as Array

from mot_sim.datasets.recorded import DetectionLog
from mot_sim.simulation import random_numbers
from mot_sim.simulation.cars.vehicles import Vehicles
from mot_sim.simulation.scene import Rollout, Scene
from mot_sim.simulation.scene_meshes import SceneMeshes
from mot_sim.simulation.sensors import Sightings
from mot_sim.simulation.traffic.driving import Driven
from mot_sim.simulation.traffic.recording import RecordedTraffic
from mot_sim.simulation.traffic.traffic_state import STEP, TrafficState
from mot_sim.simulation.truth import Annotations, Occlusions, Truth, annotate_frame, labels
from tracker.errors import BadConfig
from tracker.geometry import invert
from tracker.types import Detections, Frame, Tracks

BLOCK_FRAMES = (
    16  # frames that are labelled at once where they are known: detectors have long memories
)


@dataclass(frozen=True, eq=False)
class FrameTruth:
    """Everything that is true in one frame; equal to another where all arrays are.

    exact: of every car. occlusions: who hides whom. labels: as KITTI writes them, which is what
    is scored. world: who drives where.
    """

    exact: Truth
    occlusions: Occlusions
    labels: Tracks
    world: TrafficState

    def __eq__(self, other: object) -> bool:
        return isinstance(other, FrameTruth) and same(self, other)

    __hash__ = None  # type: ignore[assignment]


def same(one: Any, other: Any) -> bool:
    """Whether two tables hold the same numbers in all columns; NaN is like NaN."""
    if type(one) is not type(other):
        return False
    if is_dataclass(one):
        return all(same(getattr(one, f.name), getattr(other, f.name)) for f in fields(one))
    if isinstance(one, Array):
        is_float = np.issubdtype(one.dtype, np.floating)
        return np.array_equal(one, other, equal_nan=bool(is_float))
    return bool(one == other)


@dataclass(frozen=True, eq=False)
class LiveRollout(Rollout):
    """A take that is still being made: its ego car obeys, its worlds and cast grow."""

    driver: Driven
    log: list[TrafficState] = field(default_factory=list)
    meshes_by_frame: list[SceneMeshes] = field(
        default_factory=list
    )  # one: of all cars that were there so far

    @classmethod
    def begin(cls, scene: Scene, seed: int) -> "LiveRollout":
        """A new run. Raises BadConfig for a scene whose ego car cannot be driven."""
        driver = driver_of(scene, seed)
        world = driver.reset_live(random_numbers.named_stream(seed, "traffic"))
        take = cls(scene, seed, RecordedTraffic.of([world]), driver)
        take.log.append(world)
        take.meshes_by_frame.append(
            SceneMeshes(scene.vehicle_sampler.cast(take.traffic, seed), scene.rig)
        )
        return take

    def __len__(self) -> int:
        return len(self.log)

    @property
    def scene_meshes(self) -> SceneMeshes:
        """Who the cars are so far, and the camera."""
        return self.meshes_by_frame[-1]

    @property
    def traffic_states(self) -> tuple[TrafficState, ...]:
        """The worlds so far."""
        return tuple(self.log)

    def advance(self, command: str) -> None:
        """0.1 s of traffic under a command."""
        self.driver.command(command)
        world = self.driver.step()
        self.log.append(world)
        new = ~np.isin(world.ids, self.scene_meshes.vehicles.ids)
        if new.any():
            known = self.scene.vehicle_sampler.cast(
                RecordedTraffic.of([only(world, new)]), self.seed
            )
            cast = Vehicles.concatenate((self.scene_meshes.vehicles, known))
            cast = cast.select(np.argsort(cast.ids))
            self.meshes_by_frame[:] = [SceneMeshes(cast, self.scene.rig)]


def driver_of(scene: Scene, seed: int) -> Driven:
    """The traffic of a scene, if it is driven live. Raises BadConfig."""
    traffic = scene.make_traffic(scene.vehicle_sampler.models_of(seed))
    if not isinstance(traffic, Driven):
        raise BadConfig(
            f"scene {scene.name} has no live traffic ({type(traffic).__name__} cannot answer): "
            "take traffic='recorded'"
        )
    return traffic


def only(world: TrafficState, rows: Array) -> TrafficState:
    """A world with some of its cars."""
    columns = {f.name: getattr(world, f.name) for f in fields(world)}
    apart = {"time", "ego", "ego_size"}
    chosen = {
        name: column if name in apart or column is None else column[rows]
        for name, column in columns.items()
    }
    return TrafficState(**chosen)


@dataclass(eq=False)
class LazyRollout:
    """A take, and what was found out of its frames so far; nothing is found out twice."""

    rollout: Rollout
    annotations: list[Annotations] = field(default_factory=list)
    detections: list[Detections] = field(default_factory=list)

    def frame(self, index: int, image: Array | None = None) -> Frame:
        """What a tracker may know of a frame."""
        self._watch(index)
        return Frame(
            index, index * STEP, self.detections[index], self.T_now_before(index), None, image
        )

    def truth(self, index: int) -> FrameTruth:
        """What is true in a frame."""
        self._watch(index)
        found = self.annotations[index]
        return FrameTruth(
            found.truth, found.occlusions, labels(found.truth), self.rollout.traffic_states[index]
        )

    def T_now_before(self, index: int) -> Float[Array, "4 4"] | None:
        """The motion of the camera since the frame before; None at the first."""
        if index == 0:
            return None
        before, now = (self.rollout.traffic_states[at].ego for at in (index - 1, index))
        rig = self.rollout.scene.rig
        return invert(rig.T_world_cam(now)) @ rig.T_world_cam(before)

    def _watch(self, index: int) -> None:
        """Label and sense the frames up to this one, and some more where they are known."""
        first = len(self.annotations)
        if index < first:
            return
        last = min(max(first + BLOCK_FRAMES, index + 1), len(self.rollout))
        found = [annotation_of(self.rollout, frame) for frame in range(first, last)]
        self.annotations += found
        log = sense(self.rollout, Annotations.concatenate(found).truth, np.arange(first, last))
        self.detections += [log.at(frame) for frame in range(first, last)]


def annotation_of(take: Rollout, frame: int) -> Annotations:
    """The truth of a frame of a take."""
    world, before = take.traffic_states[frame], take.traffic_states[frame - 1] if frame else None
    return annotate_frame(world, take.scene_meshes, frame, before, take.scenery_in(world))


def sense(take: Rollout, truth: Truth, frames: Array) -> DetectionLog:
    """What the scene's detector says of some frames of a take."""
    seen, camera = Sightings.from_truth(truth, take.scene_meshes.vehicles), take.scene.rig.camera
    return take.scene.detector.sense(seen, take.seed, camera, STEP, frames).log
