"""What can be run (a scene) and one recorded run of it (an episode)."""

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from mot_sim import draws
from mot_sim.datasets.recorded import RecordedSequence
from mot_sim.rig import Rig
from mot_sim.sensors import Detector
from mot_sim.traffic.roads import Roads
from mot_sim.traffic.world import STEP, Traffic, World
from mot_sim.truth import Truth, exact_truth
from tracker.errors import BadConfig
from tracker.types import Tracks


@dataclass(frozen=True, eq=False)
class Scene:
    """What can be run: who drives on which roads, and what watches them, for how many frames."""

    name: str
    make_traffic: Callable[[], Traffic]
    frame_count: int
    roads: Roads = field(default_factory=Roads)
    rig: Rig = field(default_factory=Rig.kitti)
    detector: Detector = field(default_factory=Detector)

    def __post_init__(self) -> None:
        if self.frame_count < 1:
            raise BadConfig(f"scene {self.name}: {self.frame_count} frames; give 1 or more")


@dataclass(frozen=True, eq=False, kw_only=True)
class Episode(RecordedSequence):
    """One run of a scene; to a tracker the same thing as a recorded drive.

    exact: the truth of all frames of the run; world i is frame i.
    """

    scene: Scene
    seed: int
    worlds: tuple[World, ...]
    exact: Truth

    @cached_property
    def truth(self) -> Tracks:
        """The true tracks of the frames that are delivered."""
        tracks = self.exact.tracks
        return tracks.select(np.isin(tracks.frames, self.frame_indices))


def record(scene: Scene, seed: int = 0) -> Episode:
    """Run a scene. The same seed gives the same episode, bit by bit."""
    traffic = scene.make_traffic()
    worlds = [traffic.reset(draws.named_stream(seed, "traffic"))]
    worlds += [traffic.step() for _ in range(scene.frame_count - 1)]
    exact = exact_truth(worlds, scene.rig)
    return Episode(
        name=scene.name,
        camera=scene.rig.camera,
        frame_count=scene.frame_count,
        log=scene.detector(exact, seed, scene.rig.camera),
        frame_indices=np.arange(scene.frame_count),
        Ts_world_cam=np.array([scene.rig.T_world_cam(world.ego) for world in worlds]),
        frame_rate=1.0 / STEP,
        scene=scene,
        seed=seed,
        worlds=tuple(worlds),
        exact=exact,
    )
