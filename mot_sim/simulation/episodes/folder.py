"""A folder of episodes: a KITTI tree, and `episodes.json`, how they were made."""

import re
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

from mot_sim.files.resumable_folder import ResumableFolder
from mot_sim.files.settings import Settings
from mot_sim.simulation.episodes.extra import read_extra
from mot_sim.simulation.episodes.places import EPISODES_FILE, EpisodeFiles, stored_episodes
from mot_sim.simulation.episodes.recording import NO_PICTURES, PictureOptions, record_episode
from mot_sim.simulation.scene import Scene
from tracker.errors import BadConfig, BadFile

MAX_EPISODES = 10_000  # names have four digits


@dataclass(eq=False)
class EpisodeFolder(ResumableFolder):
    """Episodes that appear one by one, each as a whole; `wanted` are the names of all of them."""

    FILE = EPISODES_FILE
    PARTS = "episodes"
    STRANGE = "no episodes of ours"
    DAMAGED = "no list of ours"
    STANDS = "holds episodes already; --resume records the rest, --overwrite replaces them"

    finished: frozenset[str] = frozenset()
    """Names of the episodes that stand in the folder, whole and of full length."""
    is_complete: bool = False
    """Whether all wanted episodes were recorded."""

    @classmethod
    def open(
        cls,
        path: Path,
        settings: Settings,
        count: int,
        frame_count: int,
        *,
        resume: bool = False,
        overwrite: bool = False,
    ) -> "EpisodeFolder":
        """The folder for so many episodes of so many frames, checked; nothing is written yet.

        resume: episodes that are missing, damaged or too short are recorded. Raises BadConfig
        for a count out of range, and as `ResumableFolder.standing`.
        """
        if not 1 <= count <= MAX_EPISODES:
            raise BadConfig(f"{count} episodes: give 1 to {MAX_EPISODES}")
        there = cls.standing(path, settings, resume=resume, overwrite=overwrite)
        wanted = tuple(f"{number:04d}" for number in range(count))
        if not resume:
            return cls(path, settings, wanted, stale=tuple(there))
        files = {name: EpisodeFiles(path, name) for name in wanted}
        whole = frozenset(name for name in wanted if _is_whole(files[name], frame_count))
        return cls(path, settings, wanted, finished=whole)

    @classmethod
    def parse(cls, told: Any, file: Path) -> dict[str, None]:
        """The names of the episodes."""
        names = tuple(told)
        if not all(isinstance(name, str) and re.fullmatch("[0-9]{4}", name) for name in names):
            raise BadFile(f"{file}: its episodes {names} are not numbered; choose another folder")
        return dict.fromkeys(names)

    @property
    def missing(self) -> tuple[str, ...]:
        """The episodes that are still to be recorded."""
        return tuple(name for name in self.wanted if name not in self.finished)

    def remove(self, name: str) -> None:
        """Remove every file of an episode."""
        EpisodeFiles(self.path, name).remove()

    def holds_any(self) -> bool:
        """Whether any episode stands."""
        return bool(stored_episodes(self.path))

    def describe(self) -> tuple[bool, list[str]]:
        """Whether all were recorded, and their names."""
        return self.is_complete, list(self.wanted)


def record_episodes(
    scene: Scene,
    seed: int,
    folder: EpisodeFolder,
    options: PictureOptions = NO_PICTURES,
    progress: Callable[[str], None] | None = None,
    driven: Callable[[int], None] | None = None,
) -> None:
    """Record the episodes that the folder lacks; the first has the seed, the next seed + 1, ...

    progress: called after every frame with the episode's name. driven: see
    `record_scene_traffic`. See `record_episode` for what an interruption leaves.
    """
    with folder:
        for name in folder.missing:
            advance = None if progress is None else partial(progress, name)
            places = EpisodeFiles(folder.path, name)
            own_seed = seed + folder.wanted.index(name)
            record_episode(scene, own_seed, places, options, advance, driven)
        folder.is_complete = True
        folder.write()


def _is_whole(places: EpisodeFiles, frame_count: int) -> bool:
    """Whether an episode was finished, with all its frames."""
    try:
        return read_extra(places.extra).metadata.frames == frame_count
    except BadFile:
        return False
