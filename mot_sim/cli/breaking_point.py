"""`mot-sim breaking-point`: the level of an axis at which a score has fallen by a given drop."""

import json as jsonlib
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from mot_sim.cli.keeping import keep
from mot_sim.cli.options import File, IsolationOptions, Jobs, Verbose, help_of, option
from mot_sim.cli.sweep import Many
from mot_sim.cli.terminal import BROKEN, INTERRUPTED, OK, STDOUT, Terminal

if TYPE_CHECKING:
    from mot_sim.experiments.stress.breaking_point import BreakingPoint, BreakingPointSpec
    from mot_sim.experiments.sweep.tracker_specs import TrackerSpec

_of_search = partial(help_of, "mot_sim.experiments.stress.breaking_point", "BreakingPointSpec")


@dataclass(frozen=True)
class BreakingPointCommand:
    """Find the level of an axis at which HOTA or IDF1 has fallen by a given drop.

    mot-sim breaking-point --axis detector.jitter --drop 0.05 --costs volume,image_overlap

    mot-sim breaking-point --axis rig.frame_rate --levels 10,5,3.333,2.5,2,1 --metric IDF1

    Starting from the level without noise, the level is doubled until the score has fallen; then
    the bracket is halved. The fall is measured seed by seed, with the same traffic and draws; the
    interval of the level is where the fall's 95 % interval contains the drop. The search assumes
    that the score falls monotonically with the level. The error of a tracker that fails is shown,
    and the exit code is 1.
    """

    axis: Annotated[str, option("NAME")]
    """mot-sim sweep --list-axes shows them."""
    metric: Annotated[str, option("NAME", "HOTA", help=_of_search("metric"))] = "HOTA"
    drop: Annotated[float, option("SHARE", "0.05", help=_of_search("drop"))] = 0.05
    start: Annotated[float, option("LEVEL", "0", name="from", help=_of_search("start"))] = 0.0
    end: Annotated[float | None, option("LEVEL", "as far as it goes", name="to")] = None
    """The farthest level."""
    levels: Annotated[str | None, option("LEVELS", "any between")] = None
    """Separated by commas, the best first: for axes that take only some levels."""
    trackers: Annotated[str | None, option("NAMES", "default,paper; none with --costs")] = None
    """Separated by commas, as for mot-sim sweep."""
    costs: Annotated[str | None, option("COSTS")] = None
    """Cue sets, separated by commas: a cost, or several (volume=0.6+reprojection=0.4)."""
    base_tracker: Annotated[str, option("TRACKER", "paper")] = "paper"
    """The tracker that uses the cue sets."""
    scene: Annotated[str, option("NAME", "intersection")] = "intersection"
    """mot-sim scenes."""
    profile: Annotated[str, option("NAME|FILE", "rrc")] = "rrc"
    """The detector's noise; cues has those that shape_pose and appearance need."""
    settings: Annotated[Many, option("NAME=LEVEL", name="set")] = ()
    """Any other axis, set to one level; repeatable."""
    seeds: Annotated[int, option("N", "8", help=_of_search("seeds"))] = 8
    first_seed: Annotated[int, option("N", "0", help=_of_search("first_seed"))] = 0
    frames: Annotated[int, option("N", "80", help=_of_search("frames"))] = 80
    precision: Annotated[float, option("SHARE", "0.1", help=_of_search("precision"))] = 0.1
    out: Annotated[Path | None, option("DIR", "nothing is kept")] = None
    """Keep finished trials here; after Ctrl-C the same command continues and repeats nothing."""
    jobs: Jobs = 1
    isolation: IsolationOptions = field(default_factory=IsolationOptions)
    """Where trackers run, and what they may take there."""
    plot: Annotated[Path | None, option("FILE", "no picture")] = None
    """The score over the tested levels, as PNG, SVG or PDF, one line per tracker."""
    json: File = None
    """The points and curves as JSON into a file; - prints it instead of the table."""
    verbose: Verbose = 0
    """Say more: -v, -vv."""

    def __call__(self, terminal: Terminal) -> int:
        """Search and show."""
        from mot_sim.cli.evaluate import require_targets
        from mot_sim.experiments.stress.breaking_point import breaking_points

        require_targets(self.json, None)
        if self.plot is not None:
            from mot_sim.plotting.charts import require_figure

            require_figure(self.plot)
        spec = self.spec()
        keep(self.out, "breaking-point", self._title(spec), finished=False)

        def tell(tracker: str, level: Any) -> None:
            if self.verbose:
                terminal.note(f"{tracker}: {self.axis} = {level}")

        try:
            points = breaking_points(spec, self.out, jobs=self.jobs, tell=tell)
        except KeyboardInterrupt:
            kept = "" if self.out is None else f"; finished trials stand in {self.out}"
            terminal.note(f"interrupted{kept}")
            return INTERRUPTED
        return self._show(terminal, spec, points)

    def _title(self, spec: "BreakingPointSpec") -> str:
        return f"{spec.scene}: where {spec.metric} breaks over {spec.axis}"

    def spec(self) -> "BreakingPointSpec":
        """The search that the options describe."""
        from mot_sim.experiments.stress.breaking_point import BreakingPointSpec
        from mot_sim.experiments.sweep.paths import parse_level, parse_settings

        words = () if self.levels is None else self.levels.split(",")
        levels = tuple(parse_level(word.strip()) for word in words)
        return BreakingPointSpec(
            self.axis,
            self.metric,
            self.drop,
            self.start,
            self.end,
            levels,
            self.precision,
            self.isolation.specs(self.tracker_specs()),
            self.scene,
            self.seeds,
            self.first_seed,
            self.frames,
            {"scene.profile": parse_level(self.profile), **parse_settings(self.settings)},
        )

    def tracker_specs(self) -> "tuple[str | TrackerSpec, ...]":
        """The trackers, then one per cue set."""
        from mot_sim.experiments.sweep.tracker_specs import TrackerSpec

        names = self.trackers or ("default,paper" if self.costs is None else "")
        cues = [] if self.costs is None else self.costs.split(",")
        return (
            *(name.strip() for name in names.split(",") if name),
            *(TrackerSpec(cue.strip(), self.base_tracker, {"costs": cue.strip()}) for cue in cues),
        )

    def _show(
        self, terminal: Terminal, spec: "BreakingPointSpec", points: "Sequence[BreakingPoint]"
    ) -> int:
        """The table, the JSON, the picture, what failed; the exit code."""
        from mot_sim.experiments.stress.breaking_table import (
            breaking_content,
            breaking_table,
            breaking_tables,
        )
        from mot_sim.experiments.sweep.curves import save_curves

        tables = breaking_tables(spec, points)
        keep(self.out, "breaking-point", self._title(spec), tables)
        if self.json is not None:
            content = breaking_content(spec, points)
            terminal.save(jsonlib.dumps(content, indent=2) + "\n", self.json)
        if self.json != STDOUT:
            terminal.show(breaking_table(spec, points))
        if self.plot is not None:
            save_curves(tables[1], self.plot, (self.metric,))
            terminal.note(f"written: {self.plot}")
        failed = [each for each in points if each.failed]
        for each in failed:
            terminal.note(f"{each.tracker}: {each.failed} trials failed: {each.error}")
        return BROKEN if failed else OK
