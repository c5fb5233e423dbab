"""`mot-sim show`: a drive as a film, with its tracks, search areas, wireframes and truth."""

from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import tyro

from mot_sim.cli.options import Flag, TrackerOptions, Verbose, option, parse_knobs
from mot_sim.cli.terminal import INTERRUPTED, OK, Terminal

if TYPE_CHECKING:
    import mot_sim.datasets
    import mot_sim.plotting
    import mot_sim.report.opening

MIN_SCALE = 0.1
MAX_SCALE = 4.0


@dataclass(frozen=True)
class LayerOptions:
    """What is drawn."""

    search_areas: Flag = False
    """Where each track is predicted: its uncertainty, projected."""
    wireframes: Flag = False
    """The shape that is fitted to every detected track; needs images."""
    true_wireframes: Flag = False
    """The cars as they are; simulated drives only."""
    cuboids: Flag = False
    """Tracks in the image as cuboids, their fronts tinted, in place of boxes."""
    no_detections: Flag = False
    """Leave out the detector's boxes."""
    no_truth: Flag = False
    """Leave out true boxes, missed cars, false boxes, switches, and outlines from above."""
    no_top_view: Flag = False
    """The image alone: no view from above, and no errors over time."""


@dataclass(frozen=True)
class Show:
    """Draw a drive as a film: an MP4, a GIF or pictures, or a recording for rerun.

    mot-sim show out/crossing --out crossing.mp4 --search-areas

    mot-sim show KITTI --sequence 0000 --tracks out/rrc --frames 60:120 --out drive.gif --scale 0.5

    mot-sim show intersection --seed 3 --out frames --true-wireframes

    Without --tracks the drive is tracked now. Frames without an image are drawn on plain ground.
    Ctrl-C keeps a shorter film.
    """

    episode: Annotated[str, tyro.conf.Positional, tyro.conf.arg(metavar="EPISODE")]
    """A folder of mot-sim record, a KITTI root, or a scene: its name (mot-sim list), or
    MODULE:FUNCTION of your own."""
    out: Annotated[Path | None, option("FILE|DIR")] = None
    """FILE.mp4 (H.264), FILE.gif, or a folder for 000000.png, ..."""
    rerun: Annotated[Path | None, option("FILE.rrd")] = None
    """A recording for the rerun viewer: images, boxes, cuboids, trails, poses (extra `view`)."""
    sequence: Annotated[str | None, option("NAME", "the only one")] = None
    """Which one of a folder that holds several, for example 0000."""
    tracks: Annotated[Path | None, option("DIR|FILE", "tracked now")] = None
    """A run of mot-sim track, or one file of results."""
    detections: Annotated[str | None, option("NAME", "rrc; simulated")] = None
    """A detector of the tree (mot-sim list)."""
    ego: Annotated[str, option("NAME", "oxts")] = "oxts"
    """How the camera moved, for a KITTI root: oxts, orbslam3, none."""
    knobs: Annotated[str | None, option("NAME=VALUE,...", "the scene's own")] = None
    """Changes to a scene."""
    seed: int = 0
    """Seed of a scene."""
    frames: Annotated[str | None, option("A:B", "all")] = None
    """Frames A to B - 1; A: or :B leave one end open."""
    scale: Annotated[float, option("FACTOR", "1")] = 1.0
    """Scale of the pictures: 0.5 halves them."""
    layers: LayerOptions = field(default_factory=LayerOptions)
    """What is drawn."""
    tracker: Annotated[str, option("NAME", "default")] = "default"
    """The tracker without --tracks: default or paper."""
    method: TrackerOptions = field(default_factory=TrackerOptions)
    """What is changed in the tracker, without --tracks."""
    overwrite: Flag = False
    """Replace an older film."""
    verbose: Verbose = 0
    """Say more: -v, -vv."""

    def __call__(self, terminal: Terminal) -> int:
        """Open, track, draw, and say what was written."""
        from mot_sim.plotting import FilmWriter
        from mot_sim.report import Film
        from mot_sim.report.opening import open_tracks, track_drive, truth_of
        from mot_sim.report.rerun_file import write_rerun

        span = parse_frames(self.frames)
        self._check()
        drive = self._request(span).open()
        first, end = clip_frames(span, drive)
        self._check_layers(drive)
        tracks = None if self.tracks is None else open_tracks(self.tracks, drive)
        truth = None if self.layers.no_truth else truth_of(drive)
        name = self.tracker if self.tracks is None else self.tracks.name
        recipe = self.method.recipe(self.tracker)
        total = (end - first) * (1 + (self.rerun is not None and self.out is not None))
        film: FilmWriter | None = None
        try:
            with terminal.progress(
                total + (end if tracks is None else 0), unit="frames"
            ) as advance:
                if tracks is None:
                    tracks = track_drive(drive, recipe, end, lambda: advance("tracking"))
                layers = self._layers(truth is not None)
                shown = Film(drive, tracks, name, layers, truth, self.scale)
                if self.rerun is not None:
                    write_rerun(self.rerun, shown, first, end, lambda: advance("rerun"))
                    terminal.write(f"{self.rerun}: {end - first} frames for the rerun viewer\n")
                if self.out is not None:
                    film = FilmWriter(self.out, drive.frame_rate)
                    with film:
                        for index, picture in shown.frames(first, end):
                            film.add(picture, index)
                            advance("drawing")
        except KeyboardInterrupt:
            return self._say_interrupted(terminal, film)
        if film is not None:
            terminal.write(f"{self.out}: {film.frames} frame{'s' * (film.frames != 1)}\n")
        return OK

    def _check(self) -> None:
        """What can be checked before any work. Raises BadConfig, OutputExists, BadOutput."""
        from mot_sim.plotting.video import require_target
        from mot_sim.report.rerun_file import require_rerun
        from tracker.errors import BadConfig

        if self.out is None and self.rerun is None:
            raise BadConfig("give --out FILE.mp4, FILE.gif or a folder, or --rerun FILE.rrd")
        if not MIN_SCALE <= self.scale <= MAX_SCALE:
            raise BadConfig(
                f"--scale {self.scale:g}: give a factor from {MIN_SCALE} to {MAX_SCALE}"
            )
        if self.out is not None:
            require_target(self.out, self.overwrite)
        if self.rerun is not None:
            require_rerun(self.rerun, self.overwrite)
        self.method.recipe(self.tracker)

    def _check_layers(self, drive: "mot_sim.datasets.RecordedSequence") -> None:
        """Fitted wireframes need images, true ones a simulated drive."""
        from mot_sim.simulation.episode import SimulatedDrive
        from tracker.errors import BadConfig, DatasetNotFound

        if self.layers.true_wireframes and not isinstance(drive, SimulatedDrive):
            raise BadConfig(
                f"--true-wireframes: '{drive.name}' is a real drive; --wireframes fits some"
            )
        needs = "--wireframes" if self.layers.wireframes else f"--cues {self.method.cues}"
        if drive.images is None and (self.layers.wireframes or self.method.wants_images):
            raise DatasetNotFound(f"{needs} needs images, and '{drive.name}' has none")

    def _request(self, span: tuple[int, int | None]) -> "mot_sim.report.opening.DriveRequest":
        """The drive that the options name."""
        from mot_sim.report.opening import DriveRequest
        from mot_sim.simulation.registry import SCENE_NAMES
        from tracker.errors import BadConfig

        is_scene = self.episode in SCENE_NAMES and not Path(self.episode).is_dir()
        if self.knobs and not is_scene:
            raise BadConfig(f"--knobs {self.knobs}: '{self.episode}' is no scene")
        knobs = parse_knobs(self.episode, self.knobs) if is_scene else {}
        return DriveRequest(
            self.episode, self.sequence, self.detections, self.ego, self.seed, knobs, span[1]
        )

    def _layers(self, has_truth: bool) -> "mot_sim.report.Layers":
        """What is drawn."""
        from mot_sim.report import Layers

        chosen = self.layers
        return Layers(
            detections=not chosen.no_detections,
            truth=has_truth,
            search_areas=chosen.search_areas,
            wireframes=chosen.wireframes,
            true_wireframes=chosen.true_wireframes,
            cuboids=chosen.cuboids,
            top_view=not chosen.no_top_view,
        )

    def _say_interrupted(
        self, terminal: Terminal, film: "mot_sim.plotting.FilmWriter | None"
    ) -> int:
        """Say what is there now."""
        if film is not None and film.frames:
            terminal.note(f"interrupted: {self.out} stands with {film.frames} frames")
        else:
            terminal.note("interrupted: no frame was finished and no film is left behind")
        return INTERRUPTED


def parse_frames(text: str | None) -> tuple[int, int | None]:
    """The first frame and the one after the last; None: to the end. Raises BadConfig."""
    from tracker.errors import BadConfig

    parts = (text or ":").split(":")
    if len(parts) != 2 or not all(part.strip().isdecimal() or not part.strip() for part in parts):
        raise BadConfig(f"--frames {text}: write A:B, for example 60:120, A: or :B")
    first, end = (int(part) if part.strip() else None for part in parts)
    if end is not None and end <= (first or 0):
        raise BadConfig(f"--frames {text}: no frame lies in it; A is the first, B is left out")
    return first or 0, end


def clip_frames(
    span: tuple[int, int | None], drive: "mot_sim.datasets.RecordedSequence"
) -> tuple[int, int]:
    """The frames of the span that the drive has. Raises BadConfig where it has none."""
    from tracker.errors import BadConfig

    first, end = span
    if first >= drive.frame_count:
        raise BadConfig(
            f"--frames {first}:...: '{drive.name}' has the frames 0 to {drive.frame_count - 1}"
        )
    return first, drive.frame_count if end is None else min(end, drive.frame_count)
