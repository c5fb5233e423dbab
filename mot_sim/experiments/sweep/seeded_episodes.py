"""Episodes for tests: made once from scene, seed and knobs, then kept in memory and on disk."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path

from mot_sim.experiments.executor import one_thread
from mot_sim.experiments.sweep.conditions import Conditions
from mot_sim.experiments.sweep.drives import Recordings, TrialSequence, drive_of
from mot_sim.experiments.sweep.paths import Level
from tracker import Camera, Frame, Sequence, Tracks
from tracker.errors import BadConfig
from tracker.types import SequenceWrapper

DEFAULT_FRAMES = 50  # of an episode, where a test does not say; 5 s
MAX_EPISODES_IN_MEMORY = 16  # episodes


@dataclass(frozen=True, eq=False)
class CopiedFrames(SequenceWrapper):
    """A sequence whose every frame is a copy, so that no tracker spoils it for the next."""

    def __iter__(self) -> Iterator[Frame]:
        for frame in self.sequence:
            seen = frame.detections
            yield replace(frame, detections=None if seen is None else seen.copied())


@dataclass(frozen=True, eq=False)
class SeededEpisode:
    """One run of a scene: `frames` is all that a tracker is given, `truth` stays apart."""

    scene: str
    """Name of the scene."""
    seed: int
    """The seed of the run, 0 or more."""
    settings: dict[str, Level]
    """The axes that were set, by name."""
    drive: TrialSequence
    """The frames, their labels and the length of the recording."""

    @property
    def name(self) -> str:
        """Scene, seed and settings in one line."""
        told = ", ".join(
            f"{axis.removeprefix('scene.')}={at}" for axis, at in self.settings.items()
        )
        return f"{self.scene}, seed {self.seed}, {told}"

    @property
    def frames(self) -> Sequence:
        """The frames in the order of time, copied for whoever asks."""
        return CopiedFrames(self.drive.sequence)

    @property
    def truth(self) -> Tracks:
        """The labels of the frames that come, as KITTI writes them."""
        return self.drive.truth

    @property
    def camera(self) -> Camera:
        """The camera, as the tracker is told of it."""
        return self.drive.sequence.camera

    @property
    def frame_count(self) -> int:
        """Of the recording."""
        return self.drive.frame_count

    def __len__(self) -> int:
        return len(self.drive.sequence)


def mot_episode(
    scene: str,
    seed: int = 0,
    *,
    profile: str = "rrc",
    frames: int = DEFAULT_FRAMES,
    cache: Path | str | None = None,
    **knobs: Level,
) -> SeededEpisode:
    """The episode of a scene and seed, bit by bit the same in every run.

    profile: of the detector's noise. knobs: the scene's own by name (cars=10), and any axis of
    `mot-sim sweep` by its whole name (**{"detector.jitter": 2.0, "timing.drops": 0.1}).
    cache: the folder of recorded truths; None: $MOT_SIM_CACHE, else mot-sim/episodes in the
    user's cache. Files that are damaged, or of other code, are made anew. Raises UnknownName
    and BadConfig.
    """
    if isinstance(seed, bool) or not isinstance(seed, int) or seed < 0:
        raise BadConfig(f"seed {seed!r} of an episode: give a whole number, 0 or more")
    axes: dict[str, Level] = {"scene.profile": profile, "scene.frames": frames}
    for name, value in knobs.items():
        axes[name if "." in name else f"scene.{name}"] = value
    kept = Recordings.shared() if cache is None else Recordings(Path(cache))
    return SeededEpisode(scene, seed, axes, _drive(scene, seed, tuple(axes.items()), kept))


@lru_cache(maxsize=MAX_EPISODES_IN_MEMORY)
def _drive(
    scene: str, seed: int, axes: tuple[tuple[str, Level], ...], kept: Recordings
) -> TrialSequence:
    """The run under these conditions."""
    conditions = Conditions.of(scene, dict(axes))
    with one_thread():
        return drive_of(conditions, kept.truth(conditions, seed), seed)


__all__ = ["SeededEpisode", "mot_episode"]
