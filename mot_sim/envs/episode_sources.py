"""Where the episodes of an environment come from: a scene's seeds, or a folder of recordings."""

from dataclasses import dataclass, field
from pathlib import Path
from typing import Protocol, runtime_checkable

from mot_sim.simulation.episode import SimulatedDrive, record
from mot_sim.simulation.episodes import read_episode, stored_episodes
from mot_sim.simulation.scene import Scene
from tracker.errors import BadConfig, DatasetNotFound
from tracker.types import Camera


@runtime_checkable
class EpisodeSource(Protocol):
    """Numbered episodes of one camera."""

    def __len__(self) -> int:
        """How many there are."""
        ...

    @property
    def camera(self) -> Camera:
        """The camera of all of them."""
        ...

    def load(self, number: int) -> SimulatedDrive:
        """The episode of a number from 0 on."""
        ...


@dataclass(frozen=True, eq=False)
class SceneSource:
    """The episodes of a scene: number i has seed first_seed + i. Each is run when asked for, and
    kept."""

    scene: Scene
    """The scene."""
    count: int
    """Number of episodes, 1 or more."""
    first_seed: int = 0
    """Seed of episode 0, 0 or more."""
    kept: dict[int, SimulatedDrive] = field(default_factory=dict)
    """Episodes that were run, by number."""

    def __post_init__(self) -> None:
        if self.count < 1:
            raise BadConfig(f"a pool of {self.count} episodes: give 1 or more")
        if self.first_seed < 0:
            raise BadConfig(f"first_seed is {self.first_seed}: give 0 or more")

    def __len__(self) -> int:
        return self.count

    @property
    def camera(self) -> Camera:
        """The scene's."""
        return self.scene.rig.camera

    def load(self, number: int) -> SimulatedDrive:
        """The episode of that seed."""
        if number not in self.kept:
            self.kept[number] = record(self.scene, self.first_seed + number)
        return self.kept[number]


@dataclass(frozen=True, eq=False)
class FolderSource:
    """The episodes that `mot-sim record` wrote to a folder, in the order of their names."""

    root: Path
    """The folder."""
    names: tuple[str, ...]
    """Names of the episodes, in order."""
    kept: dict[int, SimulatedDrive] = field(default_factory=dict)
    """Episodes that were read, by number."""

    @classmethod
    def find(cls, root: Path) -> "FolderSource":
        """The episodes of a folder. Raises DatasetNotFound where there are none."""
        names = tuple(stored_episodes(root))
        if not names:
            raise DatasetNotFound(f"{root}: no episodes in it; mot-sim record makes some")
        return cls(root, names)

    def __len__(self) -> int:
        return len(self.names)

    @property
    def camera(self) -> Camera:
        """That of the first episode."""
        return self.load(0).camera

    def load(self, number: int) -> SimulatedDrive:
        """Read an episode. Raises BadFile, and BadConfig for one of another image size."""
        if number not in self.kept:
            drive = read_episode(self.root, self.names[number])
            if number and drive.camera.image_size != self.camera.image_size:
                raise BadConfig(
                    f"{self.root}: episode {drive.name} has images of {drive.camera.image_size} "
                    f"pixels, the first one of {self.camera.image_size}: keep them apart"
                )
            self.kept[number] = drive
        return self.kept[number]
