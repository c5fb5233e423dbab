"""`mot-sim track`: boxes in, identities out."""

from collections.abc import Mapping, Sequence
from contextlib import nullcontext
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from mot_sim.cli.options import (
    EGO,
    Flag,
    FolderOptions,
    KittiOptions,
    TrackerOptions,
    Verbose,
    option,
)
from mot_sim.cli.terminal import INTERRUPTED, OK, Terminal

if TYPE_CHECKING:
    import mot_sim.datasets
    import mot_sim.evaluation.run_folder
    import mot_sim.evaluation.runs
    import mot_sim.files.settings


@dataclass(frozen=True)
class Track:
    """Track the cars (or pedestrians) in KITTI sequences, or in boxes of your own.

    mot-sim track --root KITTI --detections rrc --ego oxts --out out/rrc

    mot-sim track --boxes boxes.csv --camera camera.toml --ego poses.txt --out out/mine

    Writes DIR/SSSS.txt for every sequence, as the KITTI server and TrackEval read them (each file
    appears when its sequence is finished), and DIR/run.json: settings, versions, counts.
    """

    out: Annotated[Path, option("DIR", "none: it must be given")]
    """Where the results go: a new or empty folder, unless --resume or --overwrite is given."""
    tracker: Annotated[str, option("NAME", "default")] = "default"
    """default (memory, motion model, two score stages), paper (the paper's two frames), or
    MODULE:FUNCTION of your own that gives a Tracker."""
    method: TrackerOptions = field(default_factory=TrackerOptions)
    """What is changed in the tracker."""
    kitti: KittiOptions = field(default_factory=KittiOptions)
    """The sequences, unless --boxes is given, and what is known about them."""
    boxes: Annotated[Path | None, option("FILE|DIR")] = None
    """Boxes of your own instead of KITTI: CSV with the header frame,x_min,y_min,x_max,y_max,score
    (frames from 0, pixels; also class, time, yaw, length_m,height_m,width_m), MOTChallenge's
    det.txt, rows of KITTI, or COCO's results as JSON. A folder of such files: a drive each."""
    camera: Annotated[Path | None, option("FILE|DIR")] = None
    """The camera of --boxes (of all drives, or a folder with NAME.toml), a TOML file: fx fy cx cy,
    image_width, image_height in pixels, camera_height in metres, and pitch_deg, roll_deg,
    frame_rate if they are not 0, 0, 10, and distortion (OpenCV's k1, k2, p1, p2, k3)."""
    images: Annotated[Path | None, option("DIR")] = None
    """The images of --boxes: 000000.png, ...; of a folder of drives, in DIR/NAME."""
    folder: FolderOptions = field(default_factory=FolderOptions)
    """What happens to results that are in DIR already."""
    json: Flag = False
    """Print a summary as JSON instead of one line."""
    verbose: Verbose = 0
    """Say more: -v one line per sequence, -vv details."""

    def __call__(self, terminal: Terminal) -> int:
        """Track, and show a summary."""
        self.method.recipe(self.tracker)  # its names are checked before anything is read
        drives, settings = self._input()
        recipe = self.method.recipe(self.tracker, drives[0].kinds if drives else ("Car",))
        folder = self.folder.open(
            self.out,
            {**self.method.settings(self.tracker), **settings},
            [drive.name for drive in drives],
        )
        run = run_tracker(terminal, recipe, drives, folder)
        if run is None:
            return INTERRUPTED
        self._report(terminal, run)
        return OK

    def _input(
        self,
    ) -> "tuple[Sequence[mot_sim.datasets.RecordedSequence], mot_sim.files.settings.Settings]":
        """The drives, and the settings that say which they are."""
        from mot_sim.datasets import box_sequences
        from tracker.errors import BadConfig

        if self.boxes is None:
            alone = "--camera" if self.camera else "--images" if self.images else None
            if alone:
                raise BadConfig(f"{alone} belongs to --boxes: give boxes.csv too")
            return self.kitti.open(images=self.method.wants_images), self.kitti.settings()
        if self.camera is None:
            raise BadConfig("--boxes needs --camera: a TOML file, see mot-sim track --help")
        if self.kitti.named():
            option_name = self.kitti.named()[0].replace("_", "-")
            raise BadConfig(f"--boxes and --{option_name} exclude each other: KITTI or your own")
        if self.method.wants_images and self.images is None:
            raise BadConfig(f"--cues {self.method.cues} needs images: give --images DIR too")
        is_name = self.kitti.ego in (None, "none", "visual")
        poses = None if is_name else Path(str(self.kitti.ego))
        drop = self.kitti.drop_bad_boxes
        drives = box_sequences(
            self.boxes,
            self.camera,
            self.images,
            poses,
            visual=self.kitti.ego == "visual",
            metric=self.kitti.metric,
            bad_boxes="drop" if drop else "error",
            score_map=self.kitti.parsed_score_map(),
            every=self.kitti.every,
            kinds=self.kitti.kinds(),
        )
        files = {"boxes": self.boxes, "camera": self.camera, "images": self.images, "ego": poses}
        settings = {
            name: None if path is None else str(path.resolve()) for name, path in files.items()
        }
        settings["ego"] = settings["ego"] or self.kitti.ego
        of_boxes = {"drop_bad_boxes": drop, "score_map": self.kitti.score_map}
        of_boxes |= {} if self.kitti.metric else {"ego_scale": self.kitti.ego_scale}
        return drives, {**settings, **of_boxes, **self.kitti.looks()}

    def _report(self, terminal: Terminal, run: "mot_sim.evaluation.runs.TrackingRun") -> None:
        frames = sum(counts.frames for counts in run.counts.values())
        if self.json:
            terminal.write_json(
                {
                    "out": str(self.out),
                    "frames": frames,
                    "frames_per_second": run.frames_per_second,
                    "pairs_skipped": run.skipped_share,
                    "stages_ms": run.stage_ms,
                    "ego_motion": self._knows_motion,
                    "resumed": list(run.resumed),
                    "sequences": {name: vars(counts) for name, counts in run.counts.items()},
                }
            )
            return
        kept = f", {len(run.resumed)} of them finished before" if run.resumed else ""
        speed = run.frames_per_second
        pace = "" if speed is None else f", {speed:,.0f} frames/s"
        share = run.skipped_share
        spared = "" if share is None else f"; search areas spared {100 * share:.0f} % of the pairs"
        unmeasured = sum(counts.unmeasured for counts in run.counts.values())
        missing = f"; {unmeasured:,} costs had no cue" if unmeasured else ""
        count = len(run.counts)
        terminal.write(
            f"{self.out}: {count} sequence{'s' * (count != 1)}{kept}, {frames:,} frames{pace}"
            f"{spared}{missing}{stages_said(run)}\n"
        )
        if not self._knows_motion:
            terminal.write(
                "Without ego-motion cuboids are far less certain, and their covariances larger: "
                "whether a car or the camera moves is not known; --ego gives the motion.\n"
            )
        for name, counts in run.counts.items():
            if not self.kitti.metric:
                terminal.write(f"{name}: {scale_said(counts.ego_scale)}\n")
            if counts.rows == 0:
                terminal.note(f"warning: {name}: {nothing_said(counts.detections)}")

    @property
    def _knows_motion(self) -> bool:
        """Whether anything tells how the camera moves."""
        assumed = EGO if self.boxes is None else "none"
        return (self.kitti.ego or assumed) != "none"


def scale_said(scale: Mapping[str, float]) -> str:
    """The scale that was found in a drive, in words."""
    if not scale:
        return "no scale of the odometry found: the camera stands, or no car was passed"
    interval = f"{scale['low']:.3g} to {scale['high']:.3g}"
    return f"{scale['factor']:.3g} metres a unit of the odometry (95 %: {interval})"


def nothing_said(detections: int) -> str:
    """Why a drive has no row."""
    if not detections:
        return "no row, for the detections hold none of this drive"
    return (
        f"no row of {detections:,} detections: too weak, or never twice in one place; see their "
        "scores and boxes"
    )


def stages_said(run: "mot_sim.evaluation.runs.TrackingRun") -> str:
    """How long the stages of the front end took, if there was one."""
    parts = [f"{stage} {spent:.1f}" for stage, spent in run.stage_ms.items()]
    return f"; ms a frame: {', '.join(parts)}" if parts else ""


def run_tracker(
    terminal: Terminal,
    recipe: "mot_sim.evaluation.runs.Recipe",
    drives: "Sequence[mot_sim.datasets.RecordedSequence]",
    folder: "mot_sim.evaluation.run_folder.RunFolder | None",
) -> "mot_sim.evaluation.runs.TrackingRun | None":
    """Track under a progress bar; None after Ctrl-C, with a note on how to continue."""
    from mot_sim.evaluation.runs import track_sequences

    finished = folder.finished if folder is not None else {}
    frames = sum(len(drive) for drive in drives if drive.name not in finished)
    try:
        with folder or nullcontext(), terminal.progress(frames, unit="frames") as advance:
            return track_sequences(
                drives, recipe.build, folder, lambda name, _: advance(name), recipe.front_end
            )
    except KeyboardInterrupt:
        if folder is None:
            terminal.note("interrupted: nothing is left behind, results are kept only with --out")
        elif folder.finished:
            terminal.note(
                f"interrupted: {len(folder.finished)} of {len(drives)} sequences are finished in "
                f"{folder.path}; the same command with --resume does the rest"
            )
        else:
            terminal.note("interrupted: no sequence was finished and nothing is left behind")
        return None
