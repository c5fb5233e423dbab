"""`mot-sim record`: runs a scene and writes the episodes as a KITTI tree."""

from dataclasses import dataclass, field
from itertools import count
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import tyro

from mot_sim.cli.options import Flag, FolderOptions, Verbose, option, parse_knobs
from mot_sim.cli.terminal import INTERRUPTED, OK, Terminal

if TYPE_CHECKING:
    import mot_sim.evaluation.run_folder
    import mot_sim.files.settings
    import mot_sim.simulation.episodes
    import mot_sim.simulation.scene


@dataclass(frozen=True)
class Record:
    """Run a scene and write episodes as a KITTI tree.

    mot-sim record crossing --out out/crossing

    mot-sim record crossing --out out/ten --seed 7 --episodes 10 --no-images

    DIR is a KITTI tree that every command takes as --root: training/ with image_02, calib, oxts,
    label_02, and beside it detections/simulated, detections/exact, odometry/noisy.
    training/extra/SSSS.npz holds what KITTI's files cannot. Ctrl-C leaves a valid shorter episode.
    """

    scene: Annotated[str, tyro.conf.Positional, tyro.conf.arg(metavar="SCENE")]
    """Its name (mot-sim list), or MODULE:FUNCTION of your own."""
    out: Annotated[Path, option("DIR", "none: it must be given")]
    """A new or empty folder, unless --resume or --overwrite is given."""
    knobs: Annotated[str | None, option("NAME=VALUE,...", "the scene's own")] = None
    """Changes to the scene; a wrong name is answered with the valid ones."""
    seed: int = 0
    """Seed of the first episode; the next ones use consecutive seeds."""
    episodes: int = 1
    """Number of episodes; they are named 0000, 0001, ..."""
    frames: Annotated[int | None, option("N", "as long as the scene is")] = None
    """Frames per episode."""
    renderer: Annotated[str, option("NAME", "raster")] = "raster"
    """raster; smooth (with smooth edges); mesh (needs OpenGL); auto: mesh where that works."""
    jobs: Annotated[int, option("N", "all cores")] = -1
    """Processes that draw, on this machine; -1: one per core. The files are the same."""
    no_images: Flag = False
    """Write no images: labels, detections and motion alone."""
    depth: Flag = False
    """Write depth too: depth_02, 16-bit PNG, 256 steps a metre, 0 = nothing within 256 m."""
    masks: Flag = False
    """Write instance_02 (16-bit PNG, id + 1, 0 = no car) and semantic_02 (8-bit) too."""
    folder: FolderOptions = field(default_factory=FolderOptions)
    """What happens to episodes that are in DIR already."""
    json: Flag = False
    """Print a summary as JSON instead of one line."""
    verbose: Verbose = 0
    """Say more: -v, -vv."""

    def __call__(self, terminal: Terminal) -> int:
        """Record, and show a summary."""
        from mot_sim.simulation.episodes import EpisodeFolder, record_episodes
        from mot_sim.simulation.registry import find_scene

        knobs = parse_knobs(self.scene, self.knobs)
        if self.frames is not None:
            knobs["frames"] = self.frames
        scene = find_scene(self.scene, **knobs)
        pictures = self._pictures()
        folder = EpisodeFolder.open(
            self.out,
            self._settings(scene, pictures),
            self.episodes,
            scene.frame_count,
            resume=self.folder.resume,
            overwrite=self.folder.overwrite,
        )
        kept = len(folder.finished)
        total = len(folder.missing) * scene.frame_count
        try:
            with terminal.progress(total, unit="frames", lines=True) as advance:
                frames = count(1)
                record_episodes(
                    scene, self.seed, folder, pictures,
                    lambda name: advance(name, next(frames), total),
                    lambda driven: advance("traffic", driven, scene.frame_count),
                )  # fmt: skip
        except KeyboardInterrupt:
            self._say_interrupted(terminal)
            return INTERRUPTED
        self._report(terminal, total, kept, pictures)
        return OK

    def _pictures(self) -> "mot_sim.simulation.episodes.PictureOptions":
        """What is drawn by which renderer; `auto` is resolved."""
        from mot_sim.simulation.episodes import PictureOptions
        from mot_sim.simulation.imaging import renderer_name
        from mot_sim.simulation.renderers import find_renderer

        chosen = {
            "images": not self.no_images,
            "depth": self.depth,
            "instances": self.masks,
            "semantics": self.masks,
        }
        parts = tuple(part for part, wanted in chosen.items() if wanted)
        return PictureOptions(parts, renderer_name(find_renderer(self.renderer)), self.jobs)

    def _settings(
        self,
        scene: "mot_sim.simulation.scene.Scene",
        pictures: "mot_sim.simulation.episodes.PictureOptions",
    ) -> "mot_sim.files.settings.Settings":
        """What decides the files; source: of a scene that is none of ours."""
        from mot_sim.simulation.registry import SCENE_NAMES

        source = SCENE_NAMES.source(self.scene)
        return {
            "scene": self.scene,
            "knobs": ",".join(f"{name}={value}" for name, value in sorted(scene.knobs.items())),
            "seed": self.seed,
            "episodes": self.episodes,
            "frames": scene.frame_count,
            "pictures": ",".join(pictures.parts) or None,
            "renderer": pictures.renderer if pictures.parts else None,
            **({} if source is None else {"source": source}),
        }

    def _say_interrupted(self, terminal: Terminal) -> None:
        """Say what is there now, and how to continue."""
        from mot_sim.simulation.episodes import read_episode, stored_episodes

        there = stored_episodes(self.out)
        if not there:
            terminal.note("interrupted: no frame was finished and nothing is left behind")
            return
        frames = read_episode(self.out, there[-1]).frame_count
        terminal.note(
            f"interrupted: {len(there)} of {self.episodes} episodes stand in {self.out}, the last "
            f"with {frames} frames; the same command with --resume does the rest"
        )

    def _report(
        self,
        terminal: Terminal,
        frames: int,
        kept: int,
        pictures: "mot_sim.simulation.episodes.PictureOptions",
    ) -> None:
        if self.json:
            summary = {"out": str(self.out), "episodes": self.episodes, "kept": kept}
            drawn = {"pictures": list(pictures.parts), "renderer": pictures.renderer}
            terminal.write_json({**summary, "frames_recorded": frames, **drawn})
            return
        stood = f", {kept} of them stood there before" if kept else ""
        drawn_by = f"; {', '.join(pictures.parts)} by {pictures.renderer}"
        terminal.write(
            f"{self.out}: {self.episodes} episode{'s' * (self.episodes != 1)}{stood}, "
            f"{frames:,} frames recorded"
            f"{drawn_by if pictures.parts else ''}\n"
        )
