"""Records an episode of a scene, frame by frame, into the files of a KITTI tree."""

from collections.abc import Callable, Sequence
from contextlib import closing, suppress
from dataclasses import dataclass

from mot_sim.files.settings import versions
from mot_sim.simulation.cores import core_count, frame_by_frame
from mot_sim.simulation.episode import episode_of
from mot_sim.simulation.episodes.extra import Metadata, array_digests, arrays_of, write_extra
from mot_sim.simulation.episodes.pictures import Encoded, Pictures
from mot_sim.simulation.episodes.places import PICTURES, EpisodeFiles
from mot_sim.simulation.episodes.texts import write_texts
from mot_sim.simulation.imaging import RenderedImages
from mot_sim.simulation.scene import Rollout, Scene, record_scene_traffic
from mot_sim.simulation.truth import Annotations, annotate_frame
from tracker.errors import BadConfig, UnknownName


@dataclass(frozen=True)
class PictureOptions:
    """Which pictures are drawn."""

    parts: tuple[str, ...] = ("images",)
    """Kinds of pictures, of PICTURES, each named once; empty: none is drawn."""
    renderer: str = "raster"
    """A name of RENDERERS, or `auto`."""
    jobs: int = 1
    """Processes that draw: 1 or more, or -1 for one per core; the files are the same."""

    def __post_init__(self) -> None:
        for part in self.parts:
            if part not in PICTURES:
                raise UnknownName.of("kind of picture", part, PICTURES)
        core_count(self.jobs)
        if len(set(self.parts)) < len(self.parts):
            raise BadConfig(f"pictures {', '.join(self.parts)}: name each kind once")


NO_PICTURES = PictureOptions(())


def record_episode(
    scene: Scene,
    seed: int,
    places: EpisodeFiles,
    options: PictureOptions = NO_PICTURES,
    progress: Callable[[], None] | None = None,
    driven: Callable[[int], None] | None = None,
) -> Metadata:
    """Run a scene and write the episode; an older one of that name is replaced.

    progress: called after every frame. driven: before, see `record_scene_traffic`. The extra file
    comes last and makes the episode whole. A KeyboardInterrupt leaves a valid episode of the frames
    that were finished, as if the scene had so many, and goes on; without any finished frame, and
    after any other error, such as BadOutput on a full disk, nothing of the episode is left.
    """
    places.remove()
    try:
        rollout = Rollout.of(scene, seed, record_scene_traffic(scene, seed, driven))
        drawn = RenderedImages(rollout, options.renderer) if options.parts else None
        parts, pictures, interrupt = _look(
            rollout, drawn, Pictures(options.parts, places), options.jobs, progress
        )
        if interrupt is not None and not parts:
            raise interrupt
        metadata = _finish(rollout, parts, pictures, drawn, places)
    except BaseException:
        with suppress(OSError):
            places.remove()
        raise
    if interrupt is not None:
        raise interrupt
    return metadata


def replay_digests(
    scene: Scene, seed: int, scratch: EpisodeFiles, options: PictureOptions
) -> dict[str, str]:
    """What every part hashes to when the scene is run again; text files go to `scratch`."""
    rollout = Rollout.of(scene, seed)
    drawn = RenderedImages(rollout, options.renderer) if options.parts else None
    parts, pictures, interrupt = _look(rollout, drawn, Pictures(options.parts), options.jobs, None)
    if interrupt is not None:
        raise interrupt
    return dict(_finish(rollout, parts, pictures, drawn, scratch).sha256)


def _look(
    rollout: Rollout,
    drawn: RenderedImages | None,
    pictures: Pictures,
    jobs: int,
    progress: Callable[[], None] | None,
) -> tuple[list[Annotations], Pictures, KeyboardInterrupt | None]:
    """The truth of frame after frame, its pictures written; until the end or an interruption."""
    parts: list[Annotations] = []
    states, scene_meshes = rollout.traffic_states, rollout.scene_meshes

    def look(frame: int) -> tuple[Annotations, Encoded]:
        state, before = states[frame], states[frame - 1] if frame else None
        part = annotate_frame(state, scene_meshes, frame, before, rollout.scenery_in(state))
        return part, {} if drawn is None else pictures.encode(drawn.render(frame))

    try:
        with closing(frame_by_frame(look, len(rollout), jobs if pictures.parts else 1)) as looked:
            for part, encoded in looked:
                pictures.add(len(parts), encoded)
                parts.append(part)
                if progress is not None:
                    progress()
    except KeyboardInterrupt as interrupt:
        return parts, pictures, interrupt
    return parts, pictures, None


def _finish(
    rollout: Rollout,
    parts: Sequence[Annotations],
    pictures: Pictures,
    drawn: RenderedImages | None,
    places: EpisodeFiles,
) -> Metadata:
    """Cut everything to the finished frames, and write all but the pictures; extra file last."""
    places.trim(len(parts))
    episode = episode_of(rollout.until(len(parts)), Annotations.concatenate(list(parts)))
    arrays = arrays_of(episode)
    digests = write_texts(episode, places) | array_digests(arrays) | pictures.digests(len(parts))
    metadata = Metadata(
        scene=rollout.scene.name,
        knobs=dict(rollout.scene.knobs),
        seed=rollout.seed,
        frames=len(parts),
        renderer=None if drawn is None else drawn.renderer_name,
        pictures=tuple(pictures.parts),
        versions=versions(),
        sha256=digests,
    )
    write_extra(places.extra, metadata, arrays)
    return metadata
