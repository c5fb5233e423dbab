"""Whether episodes are what they say: their files are hashed, their scenes run again."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from tempfile import TemporaryDirectory

from mot_sim.files.documents import require_inside
from mot_sim.simulation.episodes.closeness import prints_the_same
from mot_sim.simulation.episodes.extra import Metadata
from mot_sim.simulation.episodes.pictures import digest_of_folder
from mot_sim.simulation.episodes.places import (
    EPISODES_FILE,
    PICTURES,
    TEXTS,
    EpisodeFiles,
    begun_episodes,
    file_digest,
    stored_episodes,
)
from mot_sim.simulation.episodes.reading import read_episode
from mot_sim.simulation.episodes.recording import PictureOptions, replay_digests
from mot_sim.simulation.scene import Scene
from tracker.errors import BadFile, DatasetNotFound, TrackingError

SAME = "same"
# The last bits differ, as they do on another CPU or build of NumPy; no printed digit does.
SAME_DIGITS = "same to the printed digits"
# What the columns of a table of verdicts put together.
GROUPS: dict[str, tuple[str, ...]] = {
    "labels": ("labels", "truth"),
    "detections": ("detections", "exact detections"),
    "trajectories": ("trajectories", "oxts", "odometry", "calibration"),
    "pictures": tuple(PICTURES),
}


@dataclass(frozen=True)
class EpisodeVerification:
    """What was found of one episode."""

    name: str
    """Name of the episode."""
    frames: int
    """Frames that it holds; 0 where it cannot be read."""
    parts: Mapping[str, str]
    """For each part `same`, or what differs."""
    trouble: str | None = None
    """Why not everything could be compared; None where all could be."""

    @property
    def is_same(self) -> bool:
        """Whether nothing differs in the digits that are printed."""
        return self.trouble is None and set(self.parts.values()) <= {SAME, SAME_DIGITS}

    @property
    def is_bit_equal(self) -> bool:
        """Whether nothing differs at all."""
        return self.is_same and SAME_DIGITS not in self.parts.values()

    def verdict(self, group: str) -> str:
        """Of a group of GROUPS: `same`, what differs, or `-` where nothing was compared."""
        found = {part: self.parts[part] for part in GROUPS[group] if part in self.parts}
        differing = [f"{part}: {what}" for part, what in found.items() if what != SAME]
        if differing and set(found.values()) <= {SAME, SAME_DIGITS}:
            return SAME_DIGITS
        return "; ".join(differing) or (SAME if found else "-")


def verify_tree(
    root: Path,
    find_scene: Callable[..., Scene],
    pictures: bool = False,
    progress: Callable[[str, int], None] | None = None,
) -> list[EpisodeVerification]:
    """What is found of every episode of a tree; a bad one does not keep the others from it.

    progress: called after every episode with its name and how many there are. Raises
    DatasetNotFound for a tree without episodes.
    """
    ours = (root / EPISODES_FILE).is_file()
    names = begun_episodes(root) if ours else stored_episodes(root)
    if not names:
        raise DatasetNotFound(f"{root}: no episodes in it; mot-sim record makes some")
    found = []
    for name in names:
        found.append(verify_episode(root, name, find_scene, pictures))
        if progress is not None:
            progress(name, len(names))
    return found


def verify_episode(
    root: Path, name: str, find_scene: Callable[..., Scene], pictures: bool = False
) -> EpisodeVerification:
    """Compare the hashes of an episode's metadata with its files, and with a new run.

    find_scene: gives the scene of a name and its knobs. pictures: decode and draw them too.
    """
    places = EpisodeFiles(root, name)
    if not places.extra.is_file():
        trouble = "half-made: it has no extra file; mot-sim record --resume does it again"
        return EpisodeVerification(name, 0, {}, trouble)
    try:
        metadata = read_episode(root, name).metadata
    except TrackingError as error:
        return EpisodeVerification(name, 0, {}, str(error))
    parts = {part: SAME for part in metadata.sha256 if pictures or part not in PICTURES}
    for part, what in _changes(places, metadata, pictures).items():
        parts[part] = what
    try:
        for knob in ("profile", "camera_look"):
            named = str(metadata.knobs.get(knob, ""))
            if named.endswith(".toml"):
                require_inside(named, f"{places.extra}", root, Path.cwd())
        scene = find_scene(metadata.scene, **metadata.knobs)
        parts |= _differing(scene, metadata, places, parts, pictures)
    except TrackingError as error:
        return EpisodeVerification(name, metadata.frames, parts, f"cannot be run again: {error}")
    return EpisodeVerification(name, metadata.frames, parts)


def _changes(places: EpisodeFiles, metadata: Metadata, pictures: bool) -> dict[str, str]:
    """What the files on disk have become since they were written."""
    changed = {}
    for part in TEXTS:
        digest = file_digest(places.text(part))
        if digest != metadata.sha256.get(part):
            changed[part] = "file missing" if digest is None else "file changed"
    for part in metadata.pictures if pictures else ():
        try:
            digest = digest_of_folder(places, part, metadata.frames)
        except BadFile as error:
            changed[part] = str(error)
            continue
        if digest != metadata.sha256.get(part):
            changed[part] = "files changed"
    return changed


def _differing(
    scene: Scene,
    metadata: Metadata,
    recorded: EpisodeFiles,
    parts: Mapping[str, str],
    pictures: bool,
) -> dict[str, str]:
    """Which parts that are whole a new run of the same scene, seed and length has otherwise."""
    drawn = metadata.pictures if pictures else ()
    options = PictureOptions(drawn, metadata.renderer or "raster")
    with TemporaryDirectory() as folder:
        short = replace(scene, frame_count=metadata.frames)
        rerun = EpisodeFiles(Path(folder), "0000")
        digests = replay_digests(short, metadata.seed, rerun, options)
        return {
            part: SAME_DIGITS if prints_the_same(part, recorded, rerun) else "a new run differs"
            for part, told in metadata.sha256.items()
            if parts.get(part) == SAME and digests.get(part) != told
        }
