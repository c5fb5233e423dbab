"""Rollouts of a scene whose frames and truth are made when asked for, and their replay."""

from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass, field, fields, is_dataclass
from functools import lru_cache
from typing import Any, TypeVar

import numpy as np
from jaxtyping import Float
from numpy import ndarray as Array

from mot_sim.datasets.recorded import DetectionLog
from mot_sim.simulation import random_numbers
from mot_sim.simulation.cars.vehicles import Vehicles
from mot_sim.simulation.registry import find_scene
from mot_sim.simulation.scene import Knob, Rollout, Scene
from mot_sim.simulation.scene_meshes import SceneMeshes
from mot_sim.simulation.sensors import Sightings
from mot_sim.simulation.traffic.driving import Driven
from mot_sim.simulation.traffic.recording import RecordedTraffic
from mot_sim.simulation.traffic.traffic_state import STEP_SECONDS, TrafficState
from mot_sim.simulation.truth import Annotations, Occlusions, Truth, annotate_frame, labels
from tracker.errors import BadConfig
from tracker.geometry import invert
from tracker.types import Detections, Frame, Tracks, max_step

# Frames that are labelled at once where they are known: detectors have long memories.
# The first blocks are shorter, so that a reset does not wait for frames that may never be seen.
BLOCK_FRAMES = 16
# States of live traffic that are kept: of the frame now and the one before.
KEPT_STATES = 2
# What a pickled environment keeps beside its arguments and actions.
KEPT_ATTRIBUTES = (
    "spec",
    "_np_random",
    "_np_random_seed",
    "observation_space",
    "action_space",
)


T = TypeVar("T")


@dataclass(frozen=True, eq=False)
class FrameTruth:
    """Everything that is true in one frame; equal to another where all arrays are."""

    exact: Truth
    """What is true of every car in the image."""
    occlusions: Occlusions
    """Which car hides which."""
    labels: Tracks
    """The labels as KITTI's annotators write them who see this frame alone: a hidden car has
    none, though the labels of the whole run keep it where it comes back soon."""
    traffic_state: TrafficState
    """Where every car is."""

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


class Recent(Sequence[T]):
    """A sequence that grows for ever and keeps its last items, so that memory stays flat.

    It is as long as all that was appended; an item that is no longer kept raises IndexError.
    """

    def __init__(self) -> None:
        self._items: deque[T] = deque(maxlen=KEPT_STATES)
        self._count = 0

    def append(self, item: T) -> None:
        """Add an item at the end."""
        self._items.append(item)
        self._count += 1

    def __len__(self) -> int:
        return self._count

    @property
    def first(self) -> int:
        """The index of the first item that is kept."""
        return self._count - len(self._items)

    def __getitem__(self, index: Any) -> Any:
        if not self.first <= index < self._count:
            raise IndexError(f"item {index}: kept are {self.first} to {self._count - 1}")
        return self._items[index - self.first]


@dataclass(frozen=True, eq=False)
class LiveRollout(Rollout):
    """A rollout in progress: its ego car obeys commands, its last states are known."""

    driver: Driven
    """The traffic, whose ego car is driven."""
    log: Recent[TrafficState] = field(default_factory=Recent)
    """States of the traffic, one per 0.1 s."""
    meshes: list[SceneMeshes] = field(default_factory=list)
    """One element: the meshes of the cars now, and the camera."""

    @classmethod
    def begin(
        cls, scene: Scene, seed: int, driver: Driven, continuous: bool = False
    ) -> "LiveRollout":
        """A new rollout of the scene's traffic of that seed, see `driver_of`."""
        driver.continuous = continuous
        first = driver.reset_live(random_numbers.named_stream(seed, "traffic"))
        rollout = cls(scene, seed, RecordedTraffic.of([first]), driver)
        rollout.log.append(first)
        vehicles = scene.vehicle_sampler.sample(rollout.traffic, seed)
        parked = frozenset(rollout.traffic.parked_ids.tolist())
        rollout.meshes.append(SceneMeshes(vehicles, scene.rig, parked))
        return rollout

    def __len__(self) -> int:
        return len(self.log)

    @property
    def scene_meshes(self) -> SceneMeshes:
        """The cars now, and the camera."""
        return self.meshes[-1]

    @property
    def traffic_states(self) -> Recent[Any]:  # type: ignore[override]
        """The states so far, of which the last are kept."""
        return self.log

    def advance(self) -> None:
        """0.1 s of traffic, whose ego car does what it was told last."""
        now, known = self.driver.step(), self.scene_meshes.vehicles
        self.log.append(now)
        is_new = ~np.isin(now.ids, known.ids)
        if is_new.any():
            traffic = RecordedTraffic.of([only(now, is_new)])
            new = self.scene.vehicle_sampler.sample(traffic, self.seed)
            known = known.select(np.flatnonzero(np.isin(known.ids, now.ids)))
            vehicles = Vehicles.concatenate((known, new))
            vehicles = vehicles.select(np.argsort(vehicles.ids))
            parked = (self.scene_meshes.parked | {*traffic.parked_ids.tolist()}) & {
                *now.ids.tolist()
            }
            self.meshes[:] = [SceneMeshes(vehicles, self.scene.rig, parked)]


def driver_of(scene: Scene, seed: int) -> Driven:
    """The traffic of a scene, if it is driven live. Raises BadConfig."""
    traffic = scene.make_traffic(scene.vehicle_sampler.models_of(seed))
    if not isinstance(traffic, Driven):
        raise BadConfig(
            f"scene {scene.name} has no live traffic ({type(traffic).__name__} cannot answer): "
            "take traffic='recorded'"
        )
    return traffic


def only(state: TrafficState, rows: Array) -> TrafficState:
    """A state with some of its cars."""
    columns = {f.name: getattr(state, f.name) for f in fields(state)}
    of_no_car = {"time", "ego", "ego_size", "tilt"}
    return TrafficState(
        **{
            name: column if name in of_no_car or column is None else column[rows]
            for name, column in columns.items()
        }
    )


@dataclass(eq=False)
class LazyRollout:
    """A rollout, and the labels and detections of its frames so far; none is made twice."""

    rollout: Rollout
    """The run, which may be in progress."""
    annotations: dict[int, Annotations] = field(default_factory=dict)
    """What is true of each frame so far; of live traffic of the last one alone."""
    detections: dict[int, Detections] = field(default_factory=dict)
    """The detections of the same frames."""

    def frame(self, index: int, image: Array | None = None) -> Frame:
        """What a tracker may know of a frame."""
        self._sense_up_to(index)
        return Frame(
            index,
            index * STEP_SECONDS,
            self.detections[index],
            self.T_now_before(index),
            None,
            image,
        )

    def truth(self, index: int) -> FrameTruth:
        """What is true in a frame."""
        self._sense_up_to(index)
        found = self.annotations[index]
        return FrameTruth(
            found.truth, found.occlusions, labels(found.truth), self.rollout.traffic_states[index]
        )

    def T_now_before(self, index: int) -> Float[Array, "4 4"] | None:
        """The motion of the camera since the frame before.

        None at the first, and where the ego car has begun a new way elsewhere.
        """
        if index == 0:
            return None
        before, now = (self.rollout.traffic_states[at] for at in (index - 1, index))
        if np.hypot(*(now.ego - before.ego)[:2]) > max_step(STEP_SECONDS):
            return None
        rig = self.rollout.scene.rig
        T_world_now = rig.T_world_cam(now.ego, now.tilt)
        return invert(T_world_now) @ rig.T_world_cam(before.ego, before.tilt)

    def _sense_up_to(self, index: int) -> None:
        """Label and sense the frames up to this one, and some more where they are known."""
        if index in self.annotations:
            return
        first, last = index, index + 1
        if not isinstance(self.rollout, LiveRollout):
            first = len(self.annotations)
            block = min(max(first, 1), BLOCK_FRAMES)
            last = min(max(first + block, last), len(self.rollout))
        found = [annotation_of(self.rollout, frame) for frame in range(first, last)]
        log = sense(self.rollout, Annotations.concatenate(found).truth, np.arange(first, last))
        if isinstance(self.rollout, LiveRollout):
            self.annotations.clear()
            self.detections.clear()
        for frame in range(first, last):
            self.annotations[frame] = found[frame - first]
            self.detections[frame] = log.at(frame)


def annotation_of(rollout: Rollout, frame: int) -> Annotations:
    """The truth of a frame."""
    states = rollout.traffic_states
    now, before = states[frame], states[frame - 1] if frame else None
    return annotate_frame(now, rollout.scene_meshes, frame, before, rollout.scenery_in(now))


def sense(rollout: Rollout, truth: Truth, frames: Array) -> DetectionLog:
    """What the scene's detector reports of some frames."""
    seen = Sightings.from_truth(truth, rollout.scene_meshes.vehicles)
    camera = rollout.scene.rig.camera
    return rollout.scene.detector.sense(seen, rollout.seed, camera, STEP_SECONDS, frames).log


@lru_cache(maxsize=32)
def scene_made(name: str, knobs: tuple[tuple[str, Knob], ...]) -> Scene:
    """The one scene of a name and its knobs: what stands beside its roads is kept."""
    return find_scene(name, **dict(knobs))


class ReplayPickle:
    """Mixin of environments that are pickled as how they were made and what was done since.

    A copy begins the same episode and does the same actions, so it goes on where this one is.
    """

    _arguments: dict[str, Any]
    """Of the constructor."""
    _episode: int | None
    """The number that the episode follows from; None where none has begun."""
    _actions: list[Any]
    """Since the reset."""

    def _begin(self, episode: int) -> None:
        """Start an episode."""
        raise NotImplementedError

    def _advance(self, action: Any) -> None:
        """Do an action that is in the space."""
        raise NotImplementedError

    def __getstate__(self) -> dict[str, Any]:
        begun = None if self._episode is None else (self._episode, self._actions)
        kept = {name: getattr(self, name) for name in KEPT_ATTRIBUTES}
        return {"arguments": self._arguments, "begun": begun, "kept": kept}

    def __setstate__(self, pickled: dict[str, Any]) -> None:
        type(self).__init__(self, **pickled["arguments"])
        vars(self).update(pickled["kept"])
        if pickled["begun"] is not None:
            episode, actions = pickled["begun"]
            self._begin(episode)
            for action in actions:
                self._advance(action)
