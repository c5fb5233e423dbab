"""`mot-sim scenes`: the scenes, what a camera sees of them, and their knobs."""

from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Annotated

import tyro

from mot_sim.cli.options import Flag, Verbose, option
from mot_sim.cli.terminal import OK, Terminal

if TYPE_CHECKING:
    import mot_sim.simulation.scene_figures
    import mot_sim.tables

SEEDS = 2


@dataclass(frozen=True)
class Scenes:
    """Show the scenes, measured, or the knobs of one.

    mot-sim scenes

    mot-sim scenes intersection

    Without a name every scene is run without images, and measured: cars that a KITTI camera sees
    in a frame (25 pixels high, within 80 m, a fifth visible), share of those in sight that are
    more than half occluded, share heading more than 30 degrees off our heading, different cars
    a minute, our fastest turn in degrees a second.
    """

    scene: Annotated[str | None, tyro.conf.Positional, option("SCENE", "all")] = None
    """Show the knobs of this one instead; MODULE:FUNCTION for one of your own."""
    seeds: int = SEEDS
    """How many runs each figure is the mean of."""
    json: Flag = False
    """Print as JSON."""
    verbose: Verbose = 0
    """Say more: -v, -vv."""

    def __call__(self, terminal: Terminal) -> int:
        """Show the table that was asked for."""
        if self.scene is not None:
            self._show_knobs(self.scene, terminal)
            return OK
        from functools import partial

        from mot_sim.simulation.registry import SCENE_NAMES, find_scene
        from mot_sim.simulation.scene_figures import figures_of
        from tracker.errors import BadConfig

        if self.seeds < 1:
            raise BadConfig(f"--seeds {self.seeds}: give 1 or more")
        broken = SCENE_NAMES.broken()
        for why in broken.values():
            terminal.note(why)
        ours = SCENE_NAMES.ours
        names = [each for each in SCENE_NAMES.names() if each in ours or each not in broken]
        scenes = {name: find_scene(name) for name in names}
        total = self.seeds * sum(scene.frame_count for scene in scenes.values())
        with terminal.progress(total, unit="frames") as advance:
            measured = {
                name: figures_of(scene, range(self.seeds), partial(advance, name))
                for name, scene in scenes.items()
            }
        if self.json:
            terminal.write_json({name: asdict(one) for name, one in measured.items()})
            return OK
        terminal.show(figure_table(measured))
        return OK

    def _show_knobs(self, name: str, terminal: Terminal) -> None:
        """The knobs of a scene, and what it says of them."""
        from mot_sim.simulation.registry import knob_descriptions, knobs_of, scene_about
        from mot_sim.tables import Column, Table

        knobs, texts, about = knobs_of(name), knob_descriptions(name), scene_about(name)
        if self.json:
            content = {"scene": name, "about": about, "knobs": knobs, "descriptions": texts}
            terminal.write_json(content)
            return
        terminal.write(f"{about}\n\n")
        rows = tuple(
            (knob, type(value).__name__, str(value), texts[knob]) for knob, value in knobs.items()
        )
        names = ("type", "default", "what it is")
        terminal.show(Table((Column("knob", "name"), *map(Column, names)), rows))


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
