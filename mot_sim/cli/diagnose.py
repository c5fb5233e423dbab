"""`mot-sim diagnose`: what happened around each switch, and which noise source caused it."""

import json as jsonlib
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import tyro

from mot_sim.cli.options import File, Flag, IsolationOptions, Jobs, KittiOptions, Verbose, option
from mot_sim.cli.terminal import INTERRUPTED, OK, STDOUT, Terminal

if TYPE_CHECKING:
    import mot_sim.diagnosis.findings
    import mot_sim.diagnosis.tasks
    import mot_sim.tables

DEFAULT_SEEDS = 8
DEFAULT_FRAMES = 100
Many = tyro.conf.UseAppendAction[tuple[str, ...]]


@dataclass(frozen=True)
class DiagnosedDrives(KittiOptions):
    """The drives of a KITTI tree; one option is for scenes as well."""

    frames: Annotated[str | None, option("N|PART", f"{DEFAULT_FRAMES}, the suite's; all")] = None
    """Of a scene or suite: frames per run, at 10 Hz. Of KITTI: first-half or second-half of every
    sequence, or FIRST-LAST. Tracking begins there anew."""


@dataclass(frozen=True)
class Diagnose:
    """Say why a tracker broke: switches by event, and by the noise source that causes them.

    mot-sim diagnose intersection --seeds 8 --profile rrc --tracker default --attribute

    mot-sim diagnose --suite long-occlusions --attribute --contact-sheet out/sheet --out out/why

    mot-sim diagnose --root KITTI --sequences labelled --detections rrc

    One row per kind of event (occlusion by length and depth, crossing, turn, look-alike, gap of
    the detector): how often it occurred, and how many switches and fragments were around it.
    --attribute tracks every drive again with one noise source off around each switch, and all
    other random draws equal; docs/diagnosis.md explains it.
    """

    scene: tyro.conf.Positional[Annotated[str | None, option("SCENE", "see --suite, --root")]] = (
        None
    )
    """mot-sim scenes."""
    suite: Annotated[str | None, option("NAME")] = None
    """Scene, frames and settings of a stress suite: mot-sim stress --list."""
    tracker: Annotated[str, option("NAME", "default")] = "default"
    """One tracker, as for mot-sim sweep --trackers."""
    profile: Annotated[str | None, option("NAME|FILE", "rrc")] = None
    """The detector's noise."""
    settings: Annotated[Many, option("NAME=LEVEL", name="set")] = ()
    """Any axis of mot-sim sweep, set to one level; repeatable."""
    seeds: Annotated[int | None, option("N", f"{DEFAULT_SEEDS}")] = None
    """Number of runs."""
    first_seed: Annotated[int | None, option("N", "0")] = None
    """First seed; the runs use consecutive seeds."""
    kitti: DiagnosedDrives = field(default_factory=DiagnosedDrives)
    """The drives of a KITTI tree, without SCENE and --suite, and what is known about them."""
    attribute: Flag = False
    """Find the noise source that causes each switch; not for KITTI, whose noise is real."""
    contact_sheet: Annotated[Path | None, option("DIR", "no pictures")] = None
    """Draw the worst switches into this folder: a picture each, and sheet.png."""
    max_switches: Annotated[int, option("N", "12")] = 12
    """How many switches are drawn."""
    renderer: Annotated[str, option("NAME|none", "raster")] = "raster"
    """Renderer of a scene's images; none: boxes on plain ground, which is faster."""
    out: Annotated[Path | None, option("DIR", "nothing is kept")] = None
    """Tables (Parquet, CSV), result.json, and finished drives, so that the command can continue."""
    jobs: Jobs = 1
    isolation: IsolationOptions = field(default_factory=IsolationOptions)
    """Where the tracker runs, and what it may take there."""
    json: File = None
    """The tables as JSON into a file; - prints it instead of the tables."""
    csv: File = None
    """The table of events as CSV into a file; - prints it instead of the tables."""
    verbose: Verbose = 0
    """Say more: -v, -vv."""

    def __call__(self, terminal: Terminal) -> int:
        """Diagnose, draw, keep and show."""
        from mot_sim.cli.evaluate import require_targets
        from mot_sim.diagnosis.tables import tables_of
        from mot_sim.diagnosis.work import diagnose

        require_targets(self.json, self.csv)
        self._require_sense()
        tasks = self._tasks()
        try:
            with terminal.progress(lines=True) as advance:
                found = diagnose(tasks, self.out, jobs=self.jobs, progress=advance)
                pictures = self._draw(found, tasks, advance)
        except KeyboardInterrupt:
            kept = "" if self.out is None else f": finished drives stand in {self.out}"
            terminal.note(f"interrupted{kept}")
            return INTERRUPTED
        tables = tables_of(found, self.attribute)
        self._keep(tables, pictures, len(tasks))
        self._show(terminal, tables, found)
        for path in pictures[:1]:
            terminal.note(f"written: {path} and {len(pictures) - 1} pictures")
        return OK

    def _require_sense(self) -> None:
        """Raise BadConfig for options that contradict each other."""
        from mot_sim.files.writing import require_writable
        from tracker.errors import BadConfig

        of_kitti = [name for name in self.kitti.named() if name != "frames"]
        of_kitti += ["ego"] if self.kitti.ego is not None else []
        given = [self.scene is not None, self.suite is not None, bool(of_kitti)]
        if sum(given) != 1:
            raise BadConfig(
                "what is to be diagnosed? give one of: a SCENE, --suite NAME, --root DIR (KITTI)"
            )
        if self.max_switches < 1:
            raise BadConfig(f"--max-switches {self.max_switches}: give 1 or more")
        made = ("profile", "seeds", "first_seed")
        of_scenes = [name for name in made if getattr(self, name) is not None]
        of_scenes += [name for name in ("settings", "attribute") if getattr(self, name)]
        if of_kitti and of_scenes:
            raise BadConfig(
                f"--{of_scenes[0].replace('_', '-')} is for scenes: the noise of a recorded drive "
                "cannot be changed; leave it out, or name a scene"
            )
        if self.contact_sheet is not None and self.renderer != "none":
            from mot_sim.simulation.renderers import find_renderer

            find_renderer(self.renderer)
        for folder in (self.out, self.contact_sheet):
            if folder is not None:
                require_writable(folder / "x")

    def _tasks(self) -> "list[mot_sim.diagnosis.tasks.Task]":
        """The drives, checked."""
        from mot_sim.diagnosis.attribution import require_tracker

        tracker_spec = require_tracker(self.tracker, self.isolation.read())
        if self.scene is None and self.suite is None:
            from mot_sim.diagnosis.tasks import kitti_tasks

            return list(kitti_tasks(self.kitti.open("labelled"), tracker_spec))
        from mot_sim.diagnosis.tasks import scene_tasks, suite_tasks

        count = DEFAULT_SEEDS if self.seeds is None else self.seeds
        seeds = range(self.first_seed or 0, (self.first_seed or 0) + count)
        settings = self._settings()
        if self.suite is not None:
            return list(suite_tasks(self.suite, settings, seeds, tracker_spec, self.attribute))
        assert self.scene is not None
        settings = {"scene.frames": DEFAULT_FRAMES, **settings}
        return list(scene_tasks(self.scene, settings, seeds, tracker_spec, self.attribute))

    def _settings(self) -> "dict[str, float | int | str | bool]":
        """The axes that were set."""
        from mot_sim.experiments.sweep.paths import parse_settings

        found: dict[str, float | int | str | bool] = {}
        if self.profile is not None:
            found["scene.profile"] = self.profile
        frames = self.kitti.frames
        if frames is not None:
            if not (frames.isascii() and frames.isdigit()):
                from tracker.errors import BadConfig

                raise BadConfig(f"--frames {frames}: give a whole number, the frames of a scene")
            found["scene.frames"] = int(frames)
        return parse_settings(self.settings, found)

    def _draw(
        self,
        found: "Sequence[mot_sim.diagnosis.findings.Findings]",
        tasks: "Sequence[mot_sim.diagnosis.tasks.Task]",
        advance: object,
    ) -> list[Path]:
        """The pictures, if they were asked for."""
        if self.contact_sheet is None:
            return []
        from mot_sim.diagnosis.contact_sheet import draw_contact_sheet

        renderer = None if self.renderer == "none" else self.renderer
        return draw_contact_sheet(
            self.contact_sheet,
            found,
            tasks,
            max_switches=self.max_switches,
            renderer=renderer,
            progress=advance,  # type: ignore[arg-type]
        )

    def _keep(
        self,
        tables: "Sequence[mot_sim.tables.Table]",
        pictures: Sequence[Path],
        drives: int,
    ) -> None:
        """Tables and result, if a folder was named; pictures inside it are named in the result."""
        if self.out is None:
            return
        from mot_sim.diagnosis.tables import write_tables

        home = self.out.resolve()
        inside = [path.resolve() for path in pictures if path.resolve().is_relative_to(home)]
        files = [path.relative_to(home).as_posix() for path in inside]
        what = self.scene or self.suite or "KITTI"
        title = f"{what}: why {self.tracker} broke"
        write_tables(self.out, title, tables, files, drives=(drives, drives))

    def _show(
        self,
        terminal: Terminal,
        tables: "Sequence[mot_sim.tables.Table]",
        found: "Sequence[mot_sim.diagnosis.findings.Findings]",
    ) -> None:
        """The tables, and a note if they are empty."""
        from mot_sim.diagnosis.tables import for_terminal

        if self.json is not None:
            content = {table.name: table.as_records() for table in tables}
            terminal.save(jsonlib.dumps(content, indent=2) + "\n", self.json)
        if self.csv is not None:
            terminal.save(tables[0].as_csv(), self.csv)
        if STDOUT not in (self.json, self.csv):
            for table in tables[:-1]:
                terminal.show(for_terminal(table))
        if not any(each.cars for each in found):
            terminal.note("no car that counts in any drive: nothing could break")
        elif not any(each.switches for each in found):
            terminal.note("no switches: there is nothing to explain")
