"""`mot-sim scenes`: the scenes, what a camera sees of them, and their knobs."""

from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Annotated, Any

import tyro

from mot_sim.cli.options import Flag, Verbose, option
from mot_sim.cli.terminal import OK, Terminal

if TYPE_CHECKING:
    from collections.abc import Mapping

    import mot_sim.simulation.scene_figures
    import mot_sim.tables

SEEDS = 2


@dataclass(frozen=True)
class Scenes:
    """List the scenes, measure what a camera sees of them, or show the knobs of one.

    mot-sim scenes

    mot-sim scenes intersection

    mot-sim scenes --measure --seeds 3

    --measure runs every scene without images (a minute or two of CPU time) and shows: cars that a
    KITTI camera sees in a frame (25 pixels high, within 80 m, a fifth visible), share of those in
    sight that are more than half occluded, share heading more than 30 degrees off our heading,
    different cars a minute, our fastest turn in degrees a second. A second table is about the
    labels by which trackers are scored, beside those of KITTI's given drives: shares of occlusion
    levels 2 and 3, of boxes under 25 pixels and of those with level 2, and how many pixels of a car
    a scored label shows, at the quantiles 1, 5, 10 and 50 %.
    """

    scene: Annotated[str | None, tyro.conf.Positional, option("SCENE", "all")] = None
    """Show the knobs of this one, or measure it alone; MODULE:FUNCTION for one of your own."""
    measure: Flag = False
    """Run the scenes and show what a camera sees of them."""
    seeds: Annotated[int | None, option("N", f"{SEEDS}")] = None
    """With --measure: how many runs each figure is the mean of."""
    json: Flag = False
    """Print as JSON."""
    verbose: Verbose = 0
    """Say more: -v, -vv."""

    def __call__(self, terminal: Terminal) -> int:
        """Show the table that was asked for."""
        from tracker.errors import BadConfig

        if self.seeds is not None and not self.measure:
            raise BadConfig(f"--seeds {self.seeds} is for --measure; nothing is run without it")
        if self.measure:
            self._measure(terminal)
        elif self.scene is not None:
            self._show_knobs(self.scene, terminal)
        else:
            self._list(terminal)
        return OK

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

    def _measure(self, terminal: Terminal) -> None:
        """What a camera sees of the scenes, or of one."""
        from functools import partial

        from mot_sim.simulation.registry import find_scene
        from mot_sim.simulation.scene_figures import figures_of
        from tracker.errors import BadConfig

        seeds = SEEDS if self.seeds is None else self.seeds
        if seeds < 1:
            raise BadConfig(f"--seeds {seeds}: give 1 or more")
        names = self._usable(terminal) if self.scene is None else [self.scene]
        scenes = {name: find_scene(name) for name in names}
        total = seeds * sum(scene.frame_count for scene in scenes.values())
        with terminal.progress(total, unit="frames") as advance:
            measured = {
                name: figures_of(scene, range(seeds), partial(advance, name))
                for name, scene in scenes.items()
            }
        if self.json:
            terminal.write_json({name: without_nan(asdict(one)) for name, one in measured.items()})
        else:
            terminal.show(figure_table(measured))
            terminal.show(label_table(measured))

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
