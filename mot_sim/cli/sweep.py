"""`mot-sim sweep`: trackers under controlled stress."""

import json as jsonlib
from dataclasses import dataclass, field, replace
from functools import partial
from itertools import groupby
from pathlib import Path
from textwrap import wrap
from typing import TYPE_CHECKING, Annotated, Any

import tyro

from mot_sim.cli.keeping import begun, keep_sweep
from mot_sim.cli.options import File, Flag, IsolationOptions, Jobs, Verbose, help_of, option
from mot_sim.cli.terminal import BROKEN, INTERRUPTED, OK, STDOUT, Terminal

if TYPE_CHECKING:
    import mot_sim.experiments.sweep
    import mot_sim.tables

_of_design = partial(help_of, "mot_sim.experiments.sweep.design", "Design")
MIN_TABLE_WIDTH = 100  # of a terminal: an axis and its value take 60 columns

Many = tyro.conf.UseAppendAction[tuple[str, ...]]


@dataclass(frozen=True)
class Sweep:
    """Run trackers side by side over levels of noise, scenes, camera errors or parameters.

    mot-sim sweep --axis detector.jitter=0,0.5,1,2,4 --trackers default,paper --out out/jitter

    mot-sim sweep --design noise --jobs -1 --plot out/noise.png --out out/noise

    Every point and tracker gets the same traffic and the same random draws, seed by seed.
    DIR/trials contains one file per finished trial: after Ctrl-C, a kill or a crash the same
    command continues and repeats nothing. DIR/table.parquet has one row per trial, with the error
    of a tracker that failed; the exit code is then 1. mot-sim report DIR shows it as a page.
    --list-axes shows what can be an axis.
    """

    out: Annotated[Path | None, option("DIR", "none: it must be given")] = None
    """The sweep's folder; with --scheduler all workers must see it under the same path."""
    design: Annotated[str | None, option("NAME|FILE")] = None
    """noise, or a TOML file (docs/clusters.md shows one); other options change it."""
    axis: Annotated[Many, option("NAME=LEVEL,...", aliases=("-a",))] = ()
    """An axis with its levels, or NAME=LOW..HIGH for --random; repeat it for more axes."""
    settings: Annotated[Many, option("NAME=LEVEL", name="set")] = ()
    """Any axis, set to one level everywhere; repeatable."""
    trackers: Annotated[str | None, option("NAMES", "default,paper")] = None
    """Separated by commas: default, paper, one with settings (slow=default:lifecycle.max_gap=1,
    p=paper:costs=volume=0.6+reprojection=0.4) or without a component (default:car_filter=none), or
    your own (mine=MODULE:CALLABLE). Differences are to the first."""
    scene: Annotated[str | None, option("NAME", "intersection")] = None
    """mot-sim scenes."""
    profile: Annotated[str | None, option("NAME|FILE", "rrc")] = None
    """The detector's noise."""
    seeds: Annotated[int | None, option("N", "20", help=_of_design("seeds"))] = None
    first_seed: Annotated[int | None, option("N", "0", help=_of_design("first_seed"))] = None
    frames: Annotated[int | None, option("N", "100", help=_of_design("frames"))] = None
    one_at_a_time: Flag = False
    """Vary one axis at a time, the others at their own values, instead of all combinations."""
    random: Annotated[int | None, option("N", "no")] = None
    """Draw N points (a Latin hypercube) instead of all combinations."""
    spatial: Annotated[bool, tyro.conf.arg(name="3d", help_behavior_hint="")] = False
    """Score cuboids, too: AB3DMOT's sAMOTA, HOTA in 3D, errors of place and heading."""
    jobs: Jobs = 1
    isolation: IsolationOptions = field(default_factory=IsolationOptions)
    """Where trackers run, and what they may take there."""
    scheduler: Annotated[str | None, option("tcp://HOST:PORT")] = None
    """Use the workers of this Dask scheduler instead (pip install 'mot-sim[scale]')."""
    extend: Flag = False
    """Use the folder of another design: trials that are the same are kept."""
    overwrite: Flag = False
    """Remove the sweep in the folder first."""
    retry: Flag = False
    """Run failed trials again."""
    plot: Annotated[Path | None, option("FILE", "no picture")] = None
    """Curves as PNG, SVG or PDF: HOTA and IDF1 over each axis, one line per tracker."""
    json: File = None
    """The summary (with --list-axes: the axes) as JSON into a file; - prints it instead of the
    tables."""
    list_axes: Flag = False
    """Show what can be an axis of this scene, profile and trackers: its own value, what it is."""
    verbose: Verbose = 0
    """Say more: -v, -vv."""

    def __call__(self, terminal: Terminal) -> int:
        """Sweep and show."""
        from mot_sim.cli.evaluate import require_targets
        from mot_sim.experiments.sweep.running import sweep

        require_targets(self.json, None)
        self._require_picture()
        design = self.read()
        if self.list_axes:
            table = axis_table(design)
            if self.json is not None:
                terminal.save(jsonlib.dumps(table.as_records(), indent=2) + "\n", self.json)
            if self.json != STDOUT:
                show_axes(terminal, table)
            return OK
        if self.out is None:
            from tracker.errors import BadConfig

            raise BadConfig("give --out DIR: where the trials and the table go")
        try:
            with terminal.progress(lines=True) as advance:
                table = sweep(
                    design, self.out, jobs=self.jobs, scheduler=self.scheduler,
                    extend=self.extend, overwrite=self.overwrite, retry=self.retry,
                    progress=begun(self.out, design, advance),
                )  # fmt: skip
        except KeyboardInterrupt:
            terminal.note(
                f"interrupted: finished trials stand in {self.out}; the same command does the rest"
            )
            return INTERRUPTED
        return self._show(terminal, design, table)

    def read(self) -> "mot_sim.experiments.sweep.Design":
        """The design that the options spell."""
        from mot_sim.experiments.sweep import Design, read_design
        from mot_sim.experiments.sweep.points import parse_axes

        changes: dict[str, Any] = {
            name: getattr(self, name)
            for name in ("scene", "seeds", "first_seed", "frames")
            if getattr(self, name) is not None
        }
        if self.trackers is not None:
            names = (name.strip() for name in self.trackers.split(","))
            changes["trackers"] = self.isolation.specs(names)
        if self.axis:
            changes["axes"] = parse_axes(self.axis)
        if self.list_axes and not self.axis:
            changes["axes"] = {"detector.jitter": (1.0,)}
        if self.spatial:
            changes["spatial"] = True
        if self.one_at_a_time:
            changes["mode"] = "one_at_a_time"
        if self.random is not None:
            changes |= {"mode": "random", "samples": self.random}
        if fixed := self._fixed():
            changes["fixed"] = fixed
        if self.design is not None:
            found = read_design(self.design, **changes)
            return replace(found, trackers=self.isolation.specs(found.contenders))
        return Design(**{"axes": {}, **changes})

    def _fixed(self) -> "dict[str, float | int | str | bool]":
        """The axes that are set to one level everywhere."""
        from mot_sim.experiments.sweep.paths import parse_level, parse_settings

        found = {} if self.profile is None else {"scene.profile": parse_level(self.profile)}
        return parse_settings(self.settings, found)

    def _require_picture(self) -> None:
        from mot_sim.plotting.charts import require_figure

        if self.plot is not None:
            require_figure(self.plot)

    def _show(
        self, terminal: Terminal, design: "mot_sim.experiments.sweep.Design", table: Any
    ) -> int:
        """The tables, the picture, the result for the report, what failed; the exit code."""
        from mot_sim.experiments.sweep.curves import save_curves
        from mot_sim.experiments.sweep.summary import (
            PRINTED_METRICS,
            difference_table,
            failure_lines,
            mean_table,
            summary,
            summary_content,
            sweep_tables,
        )

        lines = summary(table)
        keep_sweep(self.out, design, sweep_tables(table, lines, design.description()), len(table))
        if self.json is not None:
            terminal.save(jsonlib.dumps(summary_content(lines), indent=2) + "\n", self.json)
        if self.json != STDOUT:
            for show in (mean_table, difference_table):
                shown = show(lines, PRINTED_METRICS, is_printed=True)
                if shown is not None:
                    terminal.show(shown)
        if self.plot is not None:
            save_curves(mean_table(lines), self.plot)
            terminal.note(f"written: {self.plot}")
        terminal.note(f"{len(table):,} trials: {self.out}/table.parquet")
        failed = failure_lines(table)
        for line in failed:
            terminal.note(line)
        return BROKEN if failed else OK


def axis_table(design: "mot_sim.experiments.sweep.Design") -> "mot_sim.tables.Table":
    """What can be an axis, with its own value as --set takes it, and what it is."""
    from mot_sim.tables import Column, Table

    texts = design.axis_descriptions()
    rows = tuple(
        (axis, _spelled(value), texts[axis]) for axis, value in design.known_axes().items()
    )
    columns = (Column("axis", "name"), Column("own value", "name"), Column("what it is"))
    return Table(columns, rows, name="axes")


def _spelled(value: "mot_sim.experiments.sweep.paths.Level") -> float | int | str:
    """A level as the command line spells it."""
    return str(value).lower() if isinstance(value, bool) else value


def show_axes(terminal: Terminal, table: "mot_sim.tables.Table") -> None:
    """The table of axes; on a narrow terminal as a list, since its names are long."""
    if terminal.out.width >= MIN_TABLE_WIDTH:
        terminal.show(table)
        return
    width = terminal.out.width
    for text, rows in groupby(table.shown_rows(), key=lambda row: row[2]):
        lines = [f"{axis} = {value}".rstrip() for axis, value, _ in rows]
        lines += wrap(text, width, initial_indent="    ", subsequent_indent="    ")
        terminal.write("\n".join(lines) + "\n")
