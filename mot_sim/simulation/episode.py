"""One recorded run of a scene: to a tracker the same thing as a recorded drive."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from mot_sim.datasets.images import ImageSource
from mot_sim.datasets.recorded import RecordedSequence
from mot_sim.simulation.cars.vehicles import Vehicles
from mot_sim.simulation.imaging import RenderedImages
from mot_sim.simulation.scene import Rollout, Scene, record_scene_traffic
from mot_sim.simulation.scene_meshes import SceneMeshes
from mot_sim.simulation.traffic.recording import RecordedTraffic
from mot_sim.simulation.traffic.traffic_state import STEP_SECONDS, TrafficState
from mot_sim.simulation.truth import (
    Annotations,
    Events,
    Occlusions,
    Truth,
    annotate,
    find_events,
    labels,
)
from tracker.types import Tracks


@dataclass(frozen=True, eq=False, kw_only=True)
class SimulatedDrive(RecordedSequence):
    """A drive of which everything is known, whether it was run just now or read from a file."""

    seed: int
    """Random seed, from which everything follows."""
    traffic: RecordedTraffic
    """Who was where; state i is frame i."""
    scene_meshes: SceneMeshes
    """The cars and the camera."""
    annotations: Annotations
    """The ground truth of all frames of the run, whether they are delivered or not."""

    @property
    def vehicles(self) -> Vehicles:
        """Who the cars are."""
        return self.scene_meshes.vehicles

    @property
    def exact(self) -> Truth:
        """Everything that is true of every car in every frame of the run."""
        return self.annotations.truth

    @property
    def occlusions(self) -> Occlusions:
        """Who hides whom."""
        return self.annotations.occlusions

    @cached_property
    def traffic_states(self) -> tuple[TrafficState, ...]:
        """The state of each frame of the run."""
        return self.traffic.states

    @cached_property
    def events(self) -> Events:
        """What happens in the run."""
        return find_events(self.exact, self.traffic_states)

    @cached_property
    def truth(self) -> Tracks:
        """The labels of the frames that are delivered, as KITTI writes them."""
        labelled = labels(self.exact)
        return labelled.select(np.isin(labelled.frames, self.frame_indices))


@dataclass(frozen=True, eq=False, kw_only=True)
class Episode(SimulatedDrive):
    """One run of a scene."""

    scene: Scene
    """What was run."""


def record(
    scene: Scene, seed: int = 0, traffic: RecordedTraffic | None = None, renderer: str | None = None
) -> Episode:
    """Run a scene. The same seed gives the same episode, bit by bit.

    traffic: of this scene and seed, where it was recorded before. renderer: a name of RENDERERS
    or `auto`: frames carry images, each drawn when it is its turn. None: they carry none.
    """
    rollout = Rollout.of(scene, seed, traffic)
    images = None if renderer is None else RenderedImages(rollout, renderer)
    return episode_of(
        rollout, annotate(rollout.traffic_states, rollout.scene_meshes, rollout.scenery_in), images
    )


def episode_of(
    rollout: Rollout, annotations: Annotations, images: ImageSource | None = None
) -> Episode:
    """The episode of a rollout and the truth of all its frames."""
    scene = rollout.scene
    return Episode(
        name=scene.name,
        camera=scene.rig.camera,
        frame_count=len(rollout),
        log=scene.detector(
            annotations.truth,
            rollout.seed,
            scene.rig.camera,
            len(rollout),
            rollout.scene_meshes.vehicles,
        ),
        frame_indices=np.arange(len(rollout)),
        Ts_world_cam=scene.rig.Ts_world_cam(rollout.traffic),
        images=images,
        frame_rate=1.0 / STEP_SECONDS,
        scene=scene,
        seed=rollout.seed,
        traffic=rollout.traffic,
        scene_meshes=rollout.scene_meshes,
        annotations=annotations,
    )


__all__ = ["Episode", "Scene", "SimulatedDrive", "episode_of", "record", "record_scene_traffic"]
