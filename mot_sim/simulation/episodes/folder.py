"""A folder of episodes: a KITTI tree, and `episodes.json`, how they were made."""

import json
import re
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType

from mot_sim.files.documents import read_json
from mot_sim.files.settings import Settings, holds_something, plain_settings, require_same, versions
from mot_sim.files.writing import write_lines
from mot_sim.simulation.episodes.extra import read_extra
from mot_sim.simulation.episodes.places import EPISODES_FILE, EpisodeFiles, stored_episodes
from mot_sim.simulation.episodes.recording import NO_PICTURES, PictureOptions, record_episode
from mot_sim.simulation.scene import Scene
from tracker.errors import BadConfig, BadFile, BadOutput, OutputExists

MOST_EPISODES = 10_000  # names have four digits


@dataclass(eq=False)
class EpisodeFolder:
    """Episodes that appear one by one, each as a whole.

    Opening one only looks; entering it as a context writes `episodes.json`, and leaving it by an
    exception before any episode stands takes back all that was made.
    wanted: the names of all episodes. finished: those that stand in the folder, whole and of
    full length. stale: what is to be replaced.
    """

    path: Path
    settings: Settings
    wanted: tuple[str, ...]
    finished: frozenset[str] = frozenset()
    stale: tuple[str, ...] = ()
    made: tuple[Path, ...] = ()

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

        resume: go on with a run of the same settings: episodes that are missing, damaged or too
        short are recorded. overwrite: replace an earlier run. Raises OutputExists for a folder
        that holds something, BadConfig for a run that was made with other settings, BadFile for
        an `episodes.json` that is none, BadOutput for no folder.
        """
        if not 1 <= count <= MOST_EPISODES:
            raise BadConfig(f"{count} episodes: give 1 to {MOST_EPISODES}")
        if resume and overwrite:
            raise BadConfig("--resume goes on with a run, --overwrite replaces it: keep one")
        wanted = tuple(f"{number:04d}" for number in range(count))
        if not holds_something(path):
            return cls(path, settings, wanted)
        if not (path / EPISODES_FILE).is_file():
            raise OutputExists(f"{path}: not empty, and no episodes of ours; choose another folder")
        if not (resume or overwrite):
            raise OutputExists(
                f"{path}: holds episodes already; --resume records the rest, --overwrite "
                "replaces them"
            )
        before, names = _read_file(path / EPISODES_FILE)
        if overwrite:
            return cls(path, settings, wanted, stale=names)
        require_same(path, before, settings)
        finished = frozenset(
            name for name in wanted if _is_whole(EpisodeFiles(path, name), frame_count)
        )
        return cls(path, settings, wanted, finished)

    @property
    def missing(self) -> tuple[str, ...]:
        """The episodes that are still to be recorded."""
        return tuple(name for name in self.wanted if name not in self.finished)

    def __enter__(self) -> "EpisodeFolder":
        self.made = tuple(place for place in (self.path, *self.path.parents) if not place.exists())
        try:
            for name in self.stale:
                EpisodeFiles(self.path, name).remove()
            self._write_file(complete=False)
        except OSError as error:
            raise BadOutput(f"{self.path}: cannot be written: {error.strerror}") from None
        except BaseException:
            self._take_back()
            raise
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, _: TracebackType | None
    ) -> None:
        if kind is not None:
            self._take_back()
        else:
            self._write_file(complete=True)

    def _take_back(self) -> None:
        """Remove what was made, unless an episode stands."""
        if stored_episodes(self.path):
            return
        with suppress(OSError):
            (self.path / EPISODES_FILE).unlink(missing_ok=True)
            for place in self.made:
                place.rmdir()

    def _write_file(self, complete: bool) -> None:
        described = {
            "settings": dict(self.settings),
            "versions": versions(),
            "complete": complete,
            "episodes": list(self.wanted),
        }
        write_lines(self.path / EPISODES_FILE, [json.dumps(described, indent=2)])


def record_episodes(
    scene: Scene,
    seed: int,
    folder: EpisodeFolder,
    options: PictureOptions = NO_PICTURES,
    progress: Callable[[str], None] | None = None,
) -> None:
    """Record the episodes that the folder lacks; the first has the seed, the next seed + 1, ...

    progress: called after every frame with the episode's name. See `record_episode` for what an
    interruption leaves.
    """
    with folder:
        for name in folder.missing:
            advance = None if progress is None else _naming(progress, name)
            places = EpisodeFiles(folder.path, name)
            record_episode(scene, seed + folder.wanted.index(name), places, options, advance)


def _naming(progress: Callable[[str], None], name: str) -> Callable[[], None]:
    return lambda: progress(name)


def _is_whole(places: EpisodeFiles, frame_count: int) -> bool:
    """Whether an episode was finished, with all its frames."""
    try:
        return read_extra(places.extra).metadata.frames == frame_count
    except BadFile:
        return False


def _read_file(path: Path) -> tuple[Settings, tuple[str, ...]]:
    """The settings and the names of the episodes."""
    try:
        described = read_json(path, "no list of ours")
        settings, names = plain_settings(described["settings"]), tuple(described["episodes"])
    except (ValueError, TypeError, KeyError, AttributeError) as error:
        raise BadFile(f"{path}: no list of ours: {error!r}; choose another folder") from None
    if not all(isinstance(name, str) and re.fullmatch("[0-9]{4}", name) for name in names):
        raise BadFile(f"{path}: its episodes {names} are not numbered; choose another folder")
    return settings, names
