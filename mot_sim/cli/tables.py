"""`mot-sim tables`: the paper's tables, measured."""

import os
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from mot_sim.cli.keeping import keep
from mot_sim.cli.options import SPLIT, Flag, Jobs, Root, Verbose, help_of, option
from mot_sim.cli.terminal import INTERRUPTED, OK, Terminal

if TYPE_CHECKING:
    import mot_sim.experiments.paper.studies
    import mot_sim.experiments.tuning.measuring
    import mot_sim.tables

_of_paper = partial(help_of, "mot_sim.experiments.paper.studies", "PaperConfig")
DEFAULT_SEEDS = 50
DEFAULT_FRAMES = 100
TUNING_SEEDS = 4
# With --quick: as little as shows the form of every table.
QUICK_SEEDS = 2
QUICK_FRAMES = 12
QUICK_SCENES = ("intersection",)
QUICK_KITTI_FRAMES = 6
FORM_ONLY = "form only, no result"


@dataclass(frozen=True)
class Tables:
    """Print the tables of the paper: its rows quoted, ours measured.

    mot-sim tables --table III IV --root KITTI --jobs 2 --out out/tables

    I overall; II result files for the test server (DIR/server); III cues x detectors; IV shape and
    pose at intersections; V the same costs in four frameworks. Synthetic rows are means over seeds
    with 95 % intervals. DIR keeps every result: after Ctrl-C the same command continues and
    repeats nothing. DIR/tables has one Markdown file per table.
    """

    out: Annotated[Path, option("DIR", "none: it must be given")]
    """Where results are kept."""
    table: Annotated[tuple[str, ...], option("NAME...", "all")] = ("I", "II", "III", "IV", "V")
    """I, II, III, IV, V."""
    root: Root = None
    """The KITTI tree; without it only synthetic rows are measured."""
    quick: Flag = False
    """Show the form of the tables in less than a minute of CPU time: a few frames of a few drives.
    What it measures is no result, and no files for the test server are written."""
    seeds: Annotated[
        int | None,
        option(
            "N",
            f"{DEFAULT_SEEDS}; {QUICK_SEEDS} with --quick",
            help=_of_paper("seeds"),
        ),
    ] = None
    scenes: Annotated[str | None, option("NAMES", "intersection,roundabout")] = None
    """Scenes of Table IV, separated by commas."""
    split: Annotated[str, option("NAME", SPLIT)] = SPLIT
    """Split of Table II: training or testing."""
    jobs: Jobs = 1
    verbose: Verbose = 0
    """Say more: -v, -vv."""

    def __call__(self, terminal: Terminal) -> int:
        """Measure and show."""
        from mot_sim.experiments.paper.tables import TABLES
        from mot_sim.files.writing import write_lines
        from tracker.errors import UnknownName

        found: list[mot_sim.tables.Table] = []
        names = list(dict.fromkeys(self.table))
        for name in self.table:
            if name not in TABLES:
                raise UnknownName.of("table", name, TABLES)
        try:
            with terminal.progress(lines=True) as advance:
                studies = self._studies(advance)
                if not studies.kitti:
                    terminal.note("no KITTI tree: its rows are left out; give --root DIR")
                for name in names:
                    if name == "II" and studies.kitti and not self.quick:
                        self._write_results(terminal, studies)
                    text = []
                    for table in TABLES[name](studies):
                        title = f"{FORM_ONLY}: {table.title}" if self.quick else table.title
                        found.append(replace(table, title=title, name=f"{name}.{len(found) + 1}"))
                        terminal.show(found[-1])
                        text += [f"**{title}**", "", table.as_markdown()]
                    write_lines(self.out / "tables" / f"{name}.md", "\n".join(text).split("\n"))
                    title = f"The paper's tables: {', '.join(names)}"
                    if self.quick:
                        title = f"{FORM_ONLY}: {title}"
                    keep(
                        self.out, "tables", title, tuple(found), finished=name == names[-1],
                        form_only=self.quick,
                    )  # fmt: skip
        except KeyboardInterrupt:
            terminal.note(f"interrupted: results stand in {self.out}; the same command goes on")
            return INTERRUPTED
        terminal.note(f"written: {self.out}/tables")
        if self.quick:
            terminal.note(
                "--quick: these tables show their form, a few frames of a few drives; what was "
                "measured is no result. Run without --quick for results"
            )
        return OK

    def _studies(
        self, advance: "mot_sim.experiments.tuning.measuring.Progress"
    ) -> "mot_sim.experiments.paper.studies.PaperConfig":
        """How much is measured."""
        from mot_sim.datasets import find_root
        from mot_sim.experiments.paper.studies import JUNCTIONS, PaperConfig
        from mot_sim.simulation.registry import scene_maker
        from tracker.errors import BadConfig

        seeds = (
            self.seeds if self.seeds is not None else QUICK_SEEDS if self.quick else DEFAULT_SEEDS
        )
        if seeds < 1:
            raise BadConfig(f"--seeds {seeds}: give 1 or more")
        named = self.scenes.split(",") if self.scenes else None
        scenes = tuple(name.strip() for name in named) if named else JUNCTIONS
        for name in scenes:
            scene_maker(name)
        has_kitti = self.root is not None or bool(os.environ.get("MOT_SIM_KITTI_ROOT"))
        return PaperConfig(
            self.out,
            find_root(self.root) if has_kitti else None,
            has_kitti,
            seeds,
            QUICK_FRAMES if self.quick else DEFAULT_FRAMES,
            QUICK_SCENES if self.quick and not named else scenes,
            tuning=QUICK_SEEDS if self.quick else TUNING_SEEDS,
            sample_frames=QUICK_KITTI_FRAMES if self.quick else None,
            jobs=self.jobs,
            tell=advance,
        )

    def _write_results(
        self, terminal: Terminal, studies: "mot_sim.experiments.paper.studies.PaperConfig"
    ) -> None:
        """Table II: the files that the server wants, of every sequence of the split."""
        from mot_sim.datasets import kitti_sequence
        from mot_sim.datasets.boxes import RUN_FILE
        from mot_sim.evaluation.run_folder import RunFolder
        from mot_sim.evaluation.runs import Recipe, track_sequences
        from mot_sim.evaluation.scoring import choose_sequences

        names = choose_sequences(studies.root, split=self.split)
        place = self.out / "server" / self.split
        settings = {"tracker": "default", "detections": "rrc", "ego": "oxts", "split": self.split}
        there = (place / RUN_FILE).is_file()
        drives = (kitti_sequence(studies.root, name, split=self.split) for name in names)
        with RunFolder.open(place, settings, names, resume=there) as folder:
            track_sequences(drives, Recipe().build, folder)
        terminal.note(f"written: {place}: {len(names)} sequences as the test server reads them")
