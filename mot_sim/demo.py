"""The demo that needs no data: an intersection, rendered, tracked, scored and filmed."""

import json
import os
import shutil
from collections.abc import Callable, Iterator
from contextlib import closing
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from mot_sim.datasets import write_labels, write_results
from mot_sim.files.writing import write_lines
from mot_sim.metrics import Scores, evaluate_sequence
from mot_sim.plotting import write_image, write_video
from mot_sim.plotting.canvas import Image
from mot_sim.plotting.video import put_in_place
from mot_sim.report import Film, Layers
from mot_sim.simulation.episode import Episode, Scene, record
from mot_sim.simulation.imaging import ImagesAhead, RenderedImages
from mot_sim.simulation.registry import SCENES, find_scene
from mot_sim.tables import score_table
from tracker import Tracker
from tracker.errors import BadOutput, OutputExists
from tracker.types import Camera, Tracks

DEMO_SCENE = "intersection"
DEMO_FRAMES = 140
STILL_SHARES = (0.15, 0.65)  # of the film's length
PICTURE_SHARE = 0.54  # of its length: the README's picture, named after the scene
DEMO_FILES = frozenset(
    {"tracks.txt", "tracks.estimates.csv", "truth.txt", "scores.json", "scores.md", "demo.mp4"}
    | {f"{scene}.jpg" for scene in SCENES}
)

MakeTracker = Callable[[Camera], Tracker]


@dataclass(frozen=True, eq=False)
class DemoResult:
    """The result of the demo: its scores and the files that it wrote."""

    folder: Path
    """The folder with all files."""
    still_names: tuple[str, ...]
    """Names of the single frames; the last one is the README's picture."""
    frame_count: int
    """Number of frames of the episode."""
    scores: dict[str, Scores]
    """Scores by the tracker's name; the tracker of the film comes first."""

    @property
    def video(self) -> Path:
        """The film."""
        return self.folder / "demo.mp4"

    @property
    def stills(self) -> tuple[Path, ...]:
        """Single frames; the last one is the README's."""
        return tuple(self.folder / name for name in self.still_names)

    @property
    def tracks(self) -> Path:
        """The shown tracker's rows, in the format of the KITTI server."""
        return self.folder / "tracks.txt"

    @property
    def truth(self) -> Path:
        """The true rows, as KITTI labels."""
        return self.folder / "truth.txt"

    @property
    def scores_json(self) -> Path:
        """All scores as JSON."""
        return self.folder / "scores.json"

    @property
    def scores_table(self) -> Path:
        """The scores as a Markdown table."""
        return self.folder / "scores.md"


def run_demo(
    out: Path,
    seed: int = 0,
    overwrite: bool = False,
    progress: Callable[[int, int], None] | None = None,
    make_tracker: MakeTracker = Tracker.default,
    scene: Scene | None = None,
) -> DemoResult:
    """Run the demo and put everything into the folder `out`, as a whole or not at all.

    scene: by default the intersection, for FRAMES. The film shows the tracker of `make_tracker`;
    `Tracker.paper` is scored beside it. The same seed writes the same tracks and scores, bit by
    bit. progress: called with (frames drawn, all frames). Raises OutputExists where `out` stands
    and overwrite is False, or where it holds what no demo wrote; BadOutput where it cannot be
    written.
    """
    half = out.absolute().with_name(f".{out.name}.{os.getpid()}.half")
    try:
        require_free(out, overwrite)
        half.mkdir(parents=True)
        result = _make(
            half,
            seed,
            progress or _silence,
            make_tracker,
            scene or find_scene(DEMO_SCENE, frames=DEMO_FRAMES),
        )
        put_in_place(half, out)
    except OSError as error:
        raise BadOutput(f"{out}: cannot be written: {error.strerror or error}") from None
    finally:
        shutil.rmtree(half, ignore_errors=True)
    return replace(result, folder=out)


def track_episode(episode: Episode, make_tracker: MakeTracker) -> Tracks:
    """All rows that a fresh tracker gives for an episode; no image is drawn for it."""
    tracker = make_tracker(episode.camera)
    return Tracks.concatenate([tracker.step(frame) for frame in replace(episode, images=None)])


def require_free(out: Path, overwrite: bool) -> None:
    """Raise OutputExists unless `out` is free or empty, or an older demo's to be overwritten."""
    if not os.path.lexists(out):
        return
    if out.is_symlink() or not out.is_dir():
        raise OutputExists(f"{out}: exists and is no folder; name another one")
    there = list(out.iterdir())
    if there and not overwrite:
        raise OutputExists(
            f"{out}: exists and is not empty; name another folder, or give --overwrite"
        )
    foreign = sorted(
        path.name for path in there if path.name not in DEMO_FILES and not path.match("frame_*.jpg")
    )
    if foreign:
        raise OutputExists(
            f"{out}: holds {foreign[0]}, which the demo did not write; name another folder"
        )


def _make(
    folder: Path,
    seed: int,
    progress: Callable[[int, int], None],
    make_tracker: MakeTracker,
    scene: Scene,
) -> DemoResult:
    """Write everything into an existing folder."""
    episode = record(scene, seed, renderer="raster")
    name = getattr(make_tracker, "__name__", "given")
    outputs = {
        name: track_episode(episode, make_tracker),
        "paper": track_episode(episode, Tracker.paper),
    }
    scores = {
        tracker: evaluate_sequence(episode.truth, tracks, episode.frame_count)
        for tracker, tracks in outputs.items()
    }
    stills = _still_names(episode)
    result = DemoResult(folder, tuple(stills.values()), episode.frame_count, scores)
    write_results(outputs[name], result.tracks, episode.camera.T_road_cam)
    write_labels(episode.truth, result.truth, episode.camera.T_road_cam)
    write_lines(result.scores_json, [json.dumps(_as_json(episode, scores), indent=1)])
    write_lines(result.scores_table, score_table(scores, "tracker").as_markdown().splitlines())
    assert isinstance(episode.images, RenderedImages)
    images = ImagesAhead(episode.images)
    film = Film(
        replace(episode, images=images),
        outputs[name],
        name,
        Layers(truth=True, cuboids=True, follow=False),
        episode.truth,
    )
    frames = _frames(film, {frame: folder / still for frame, still in stills.items()}, progress)
    with closing(images):
        write_video(result.video, frames, episode.frame_rate)
    return result


def _frames(
    film: Film, stills: dict[int, Path], progress: Callable[[int, int], None]
) -> Iterator[Image]:
    """The film's frames; some are also written as stills."""
    total = len(film.drive)
    for done, (index, image) in enumerate(film.frames(), 1):
        if index in stills:
            write_image(stills[index], image)
        yield image
        progress(done, total)


def _still_names(episode: Episode) -> dict[int, str]:
    """The file names of the stills, by frame."""
    frames = [int(share * episode.frame_count) for share in STILL_SHARES]
    names = {frame: f"frame_{frame:03d}.jpg" for frame in frames}
    picture = int(PICTURE_SHARE * episode.frame_count)
    return {frame: name for frame, name in names.items() if frame != picture} | {
        picture: f"{episode.name}.jpg"
    }


def _as_json(episode: Episode, scores: dict[str, Scores]) -> dict[str, Any]:
    return {
        "scene": episode.name,
        "seed": episode.seed,
        "frames": episode.frame_count,
        "trackers": {tracker: column.as_dict() for tracker, column in scores.items()},
    }


def _silence(done: int, total: int) -> None:
    """No progress."""
