"""`mot-sim scenes`: the scenes, what a camera sees of them, and their knobs."""

from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import tyro

from mot_sim.cli.options import Flag, Root, Verbose, option
from mot_sim.cli.terminal import INTERRUPTED, OK, Terminal

if TYPE_CHECKING:
    from collections.abc import Mapping

    import mot_sim.experiments.validation.likeness
    import mot_sim.simulation.drive_statistics
    import mot_sim.simulation.scene
    import mot_sim.simulation.scene_figures
    import mot_sim.tables

SEEDS = 2


@dataclass(frozen=True)
class Scenes:
    """List the scenes, measure what a camera sees of them, or show the knobs of one.

    mot-sim scenes

    mot-sim scenes intersection

    mot-sim scenes --measure --seeds 3

    mot-sim scenes street --measure --knobs parked=0.5 --like kitti --root KITTI --out out/street

    --measure runs every scene without images (a minute or two of CPU time) and shows: cars that a
    KITTI camera sees in a frame (25 pixels high, within 80 m, a fifth visible), share of those in
    sight that are more than half occluded, share heading more than 30 degrees off our heading,
    different cars a minute, our fastest turn in degrees a second. A second table is about the
    labels by which trackers are scored, beside those of KITTI's given drives: shares of occlusion
    levels 2 and 3, of boxes under 25 pixels and of those with level 2, and how many pixels of a car
    a scored label shows, at the quantiles 1, 5, 10 and 50 %.

    --like kitti adds how our car and the others drive and what labels show of them, beside the
    sequences of a KITTI tree that have labels and OXTS: the value of the scene, the median and the
    range of the drives, how far the value lies outside that range (in lengths of it; 0: inside),
    and the largest difference of the cumulated distributions (gap; usual gap: between one drive
    and the others). With --out, mot-sim report shows it with curves.
    """

    scene: Annotated[str | None, tyro.conf.Positional, option("SCENE", "all")] = None
    """Show the knobs of this one, or measure it alone; MODULE:FUNCTION for one of your own."""
    measure: Flag = False
    """Run the scenes and show what a camera sees of them."""
    seeds: Annotated[int | None, option("N", f"{SEEDS}")] = None
    """With --measure: how many runs each figure is the mean of."""
    knobs: Annotated[str | None, option("NAME=VALUE,...", "the scene's own")] = None
    """With --measure and SCENE: what is turned in it."""
    like: Annotated[str | None, option("NAME", "no drives")] = None
    """With --measure: the recorded drives that the scenes are held against: kitti."""
    root: Root = None
    """With --like: the folder that holds training/ with label_02, oxts and calib."""
    out: Annotated[Path | None, option("DIR", "nothing is kept")] = None
    """With --measure: keeps the tables, and the curves of --like, for mot-sim report."""
    json: Flag = False
    """Print as JSON."""
    verbose: Verbose = 0
    """Say more: -v, -vv."""

    def __call__(self, terminal: Terminal) -> int:
        """Show the table that was asked for."""
        self._require_measure()
        if self.measure:
            return self._measure(terminal)
        if self.scene is not None:
            self._show_knobs(self.scene, terminal)
        else:
            self._list(terminal)
        return OK

    def _require_measure(self) -> None:
        """Raise BadConfig for options of what is not asked for."""
        from tracker.errors import BadConfig

        for name in ("seeds", "knobs", "like", "out"):
            given = getattr(self, name)
            if given is not None and not self.measure:
                raise BadConfig(f"--{name} {given} is for --measure; nothing is run without it")
        if self.root is not None and self.like is None:
            raise BadConfig(f"--root {self.root} is for --like NAME; nothing is read without it")
        if self.knobs is not None and self.scene is None:
            raise BadConfig(f"--knobs {self.knobs}: name the scene whose knobs these are")
        if self.seeds is not None and self.seeds < 1:
            raise BadConfig(f"--seeds {self.seeds}: give 1 or more")

    def _list(self, terminal: Terminal) -> None:
        """What every scene is, and its knobs, from its source; no scene is made."""
        from mot_sim.simulation.scene_descriptions import SCENE_NAMES, SceneDescription
        from mot_sim.simulation.scene_names import COMMON_KNOBS
        from mot_sim.tables import Column, Table
        from tracker.errors import BadConfig

        found: dict[str, SceneDescription] = {}
        for name in SCENE_NAMES.names():
            try:
                found[name] = SceneDescription.of(name)
            except BadConfig as error:
                terminal.note(str(error))
        if self.json:
            terminal.write_json({name: asdict(one) for name, one in found.items()})
            return
        rows = tuple((name, one.about, knob_text(one.knobs)) for name, one in found.items())
        columns = (Column("scene", "name"), Column("what it is"), Column("knobs"))
        terminal.show(Table(columns, rows))
        terminal.note(
            f"knobs of every scene: {knob_text(COMMON_KNOBS)}; mot-sim scenes NAME explains them; "
            "mot-sim scenes --measure shows what a camera sees"
        )

    def _measure(self, terminal: Terminal) -> int:
        """What a camera sees of the scenes, or of one; beside recorded drives if asked for."""
        from mot_sim.cli.options import parse_knobs
        from mot_sim.experiments.validation.likeness import find_reference
        from mot_sim.simulation.registry import find_scene

        reference = None if self.like is None else find_reference(self.like, self.root)
        for why, which in () if reference is None else reference.left_out.items():
            terminal.note(f"left out: {', '.join(which)}: {why}")
        names = self._usable(terminal) if self.scene is None else [self.scene]
        scenes = {name: find_scene(name, **parse_knobs(name, self.knobs)) for name in names}
        measured: dict[str, mot_sim.simulation.scene_figures.Figures] = {}
        drives: dict[str, list[mot_sim.simulation.drive_statistics.MeasuredDrive]] = {}
        try:
            self._run(terminal, scenes, measured, drives)
        except KeyboardInterrupt:
            terminal.note(f"interrupted: {len(measured)} of {len(scenes)} scenes are measured")
            self._show(terminal, measured, drives, reference)
            return INTERRUPTED
        self._show(terminal, measured, drives, reference)
        return OK

    def _run(
        self,
        terminal: Terminal,
        scenes: "dict[str, mot_sim.simulation.scene.Scene]",
        measured: "dict[str, mot_sim.simulation.scene_figures.Figures]",
        drives: "dict[str, list[mot_sim.simulation.drive_statistics.MeasuredDrive]]",
    ) -> None:
        """Run the scenes; each is entered when all its runs are done."""
        from functools import partial

        from mot_sim.simulation.drive_statistics import MeasuredDrive
        from mot_sim.simulation.scene import Rollout
        from mot_sim.simulation.scene_figures import (
            annotated_truth,
            figures_of_rollout,
            mean_figures,
        )

        seeds = SEEDS if self.seeds is None else self.seeds
        total = seeds * sum(scene.frame_count for scene in scenes.values())
        with terminal.progress(total, unit="frames", lines=True) as advance:
            for name, scene in scenes.items():
                figures, runs = [], []
                for seed in range(seeds):
                    rollout = Rollout.of(scene, seed)
                    truth = annotated_truth(rollout, partial(advance, name))
                    figures.append(figures_of_rollout(rollout, truth))
                    runs.append(MeasuredDrive.of_rollout(rollout, truth))
                measured[name], drives[name] = mean_figures(figures), runs

    def _show(
        self,
        terminal: Terminal,
        measured: "dict[str, mot_sim.simulation.scene_figures.Figures]",
        drives: "dict[str, list[mot_sim.simulation.drive_statistics.MeasuredDrive]]",
        reference: "mot_sim.experiments.validation.likeness.ReferenceDrives | None",
    ) -> None:
        """Tables or JSON, and the result file."""
        from mot_sim.cli.keeping import keep
        from mot_sim.experiments.validation.likeness import likeness
        from mot_sim.experiments.validation.likeness_tables import (
            distributions_table,
            likeness_content,
            likeness_table,
            statistics_table,
        )

        content = {name: without_nan(asdict(one)) for name, one in measured.items()}
        tables = [figure_table(measured), label_table(measured)]
        kept = []
        if reference is not None:
            alike = {name: likeness(runs, reference) for name, runs in drives.items()}
            for name, one in alike.items():
                content[name]["like"] = {reference.name: likeness_content(one)}
            tables += [statistics_table(alike, reference), likeness_table(alike, reference)]
            kept.append(distributions_table(drives, reference))
        if self.json:
            terminal.write_json(content)
        else:
            for table in tables:
                terminal.show(table)
        keep(self.out, "scenes", "What a camera sees of the scenes", (*tables, *kept))

    def _usable(self, terminal: Terminal) -> list[str]:
        """The scenes that can be made; what is wrong with the others is told."""
        from mot_sim.simulation.registry import SCENE_NAMES

        broken = SCENE_NAMES.broken()
        for why in broken.values():
            terminal.note(why)
        ours = SCENE_NAMES.ours
        return [each for each in SCENE_NAMES.names() if each in ours or each not in broken]

    def _show_knobs(self, name: str, terminal: Terminal) -> None:
        """The knobs of a scene, and what it says of them."""
        from mot_sim.experiments.validation.scene_ranks import rank_line
        from mot_sim.simulation.registry import knob_descriptions, knobs_of, scene_about
        from mot_sim.tables import Column, Table

        knobs, texts, about = knobs_of(name), knob_descriptions(name), scene_about(name)
        ranks = rank_line(name)
        if self.json:
            content = {
                "scene": name, "about": about, "knobs": knobs, "descriptions": texts,
                "ranks": ranks,
            }  # fmt: skip
            terminal.write_json(content)
            return
        terminal.write(f"{about}\n\n")
        rows = tuple(
            (knob, type(value).__name__, str(value), texts[knob]) for knob, value in knobs.items()
        )
        names = ("type", "default", "what it is")
        terminal.show(Table((Column("knob", "name"), *map(Column, names)), rows))
        terminal.write(f"{ranks}\n")


def knob_text(knobs: "Mapping[str, object]") -> str:
    """Knobs as --knobs takes them, with spaces to fold at."""
    return ", ".join(f"{knob}={value}" for knob, value in knobs.items())


def figure_table(
    measured: "dict[str, mot_sim.simulation.scene_figures.Figures]",
) -> "mot_sim.tables.Table":
    """The figures as a table."""
    from mot_sim.tables import Column, Table

    columns = (
        Column("scene", "name"), Column("cars a frame", "value", digits=1),
        Column("half occluded, %", "rate", digits=0), Column("turned off, %", "rate", digits=0),
        Column("ids a minute", "value", digits=0), Column("deg/s", "value", digits=0),
    )  # fmt: skip
    rows = tuple(
        (name, one.cars, one.occluded, one.turned, one.ids, one.yaw_rate)
        for name, one in measured.items()
    )
    return Table(columns, rows)


def label_table(
    measured: "dict[str, mot_sim.simulation.scene_figures.Figures]",
) -> "mot_sim.tables.Table":
    """The figures of the labels as a table, KITTI's first."""
    from mot_sim.simulation.scene_figures import KITTI_LABELS
    from mot_sim.tables import Column, Table

    columns = (
        Column("labels of", "name"), Column("level 2, %", "rate", digits=1),
        Column("level 3, %", "rate", digits=1), Column("under 25 px, %", "rate", digits=1),
        Column("and level 2, %", "rate", digits=1), Column("pixels: 1 %", "value", digits=0),
        Column("5 %", "value", digits=0), Column("10 %", "value", digits=0),
        Column("50 %", "value", digits=0),
    )  # fmt: skip
    found = {"KITTI": KITTI_LABELS, **{name: one.labels for name, one in measured.items()}}
    rows = [(name, *without_nan(asdict(one)).values()) for name, one in found.items()]
    return Table(columns, tuple(rows), "Labels by which trackers are scored")


def without_nan(numbers: dict[str, Any]) -> dict[str, Any]:
    """The same numbers, None for NaN, as JSON and tables take them."""
    from math import isnan

    return {
        name: without_nan(one) if isinstance(one, dict) else None if isnan(one) else one
        for name, one in numbers.items()
    }
