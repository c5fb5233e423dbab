"""Episodes on disk as sequences with their exact truth: nothing is computed anew."""

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np

from mot_sim.datasets.images import ImageFolder
from mot_sim.simulation.episode import SimulatedDrive
from mot_sim.simulation.episodes.extra import Metadata, read_extra
from mot_sim.simulation.episodes.places import EpisodeFiles, stored_episodes
from mot_sim.simulation.rig import Rig
from mot_sim.simulation.scene_meshes import SceneMeshes
from mot_sim.simulation.traffic.traffic_state import STEP_SECONDS
from mot_sim.simulation.truth import Events
from tracker.errors import DatasetNotFound


@dataclass(frozen=True, eq=False, kw_only=True)
class StoredEpisode(SimulatedDrive):
    """An episode that was recorded before."""

    metadata: Metadata
    """Of which scene it is, and how it was made."""
    kept_events: Events
    """The events that the file holds."""

    @cached_property
    def events(self) -> Events:
        """What happens in the run."""
        return self.kept_events


def read_episode(root: Path | str, name: str = "0000", images: bool = False) -> StoredEpisode:
    """An episode of a tree that `mot-sim record` wrote, bit-equal to what was recorded.

    images: load the frames' images, one by one while iterating. The tree's KITTI files hold the
    same, rounded as they are printed; `kitti_sequence` reads those. Raises DatasetNotFound
    where there is no such episode, BadFile for a damaged, older or foreign file.
    """
    places = EpisodeFiles(Path(root), name)
    if not places.extra.is_file():
        there = ", ".join(stored_episodes(places.root)) or "none"
        raise DatasetNotFound(
            f"{places.extra}: no episode '{name}'; episodes there: {there}; mot-sim record makes "
            "some"
        )
    extra = read_extra(places.extra)
    rig, frame_count = Rig(extra.camera), extra.metadata.frames
    return StoredEpisode(
        name=name,
        camera=extra.camera,
        frame_count=frame_count,
        log=extra.log,
        frame_indices=np.arange(frame_count),
        Ts_world_cam=rig.Ts_world_cam(extra.traffic),
        images=ImageFolder.require(places.pictures("images")) if images else None,
        frame_rate=1.0 / STEP_SECONDS,
        seed=extra.metadata.seed,
        traffic=extra.traffic,
        scene_meshes=SceneMeshes(extra.vehicles, rig),
        annotations=extra.annotations,
        metadata=extra.metadata,
        kept_events=extra.events,
    )
