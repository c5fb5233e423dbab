"""`mot-sim breaking-point`: the level of an axis at which trackers have lost so much of a score."""

import json as jsonlib
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from mot_sim.cli.keeping import keep
from mot_sim.cli.options import File, Verbose, option
from mot_sim.cli.sweep import Many
from mot_sim.cli.terminal import BROKEN, INTERRUPTED, OK, STDOUT, Terminal

if TYPE_CHECKING:
    from mot_sim.experiments.stress.breaking_point import BreakingPoint
    from mot_sim.experiments.stress.breaking_point_spec import BreakingPointSpec
    from mot_sim.experiments.sweep.paths import Level
    from mot_sim.experiments.sweep.tracker_specs import TrackerSpec


@dataclass(frozen=True)
class BreakingPointCommand:
    """Find the level of an axis at which HOTA or IDF1 has fallen by so much.

    mot-sim breaking-point --axis detector.jitter --drop 0.05 --costs volume,reprojection

    mot-sim breaking-point --axis rig.frame_rate --levels 10,5,3.333,2.5,2,1 --metric IDF1

    From the level where nothing is wrong the level is doubled until the score has fallen, then
    the last two are halved. A level's fall is measured seed by seed, with the same traffic and
    draws; the level's interval is where the fall's 95 % interval holds the drop. The score is
    taken to fall on the way. Trackers that fail have their error told, and the exit code is 1.
    """

    axis: Annotated[str, option("NAME")]
    """mot-sim sweep --list-axes shows them."""
    metric: str = "HOTA"
    """A rate: HOTA, DetA, AssA, MOTA, IDF1, ..."""
    drop: float = 0.05
    """By how much it must have fallen; 0.05 = 5 points."""
    start: Annotated[float, option("LEVEL", "0", name="from")] = 0.0
    """Where nothing is wrong."""
    end: Annotated[float | None, option("LEVEL", "as far as it goes", name="to")] = None
    """The farthest level."""
    levels: Annotated[str | None, option("LEVELS", "any between")] = None
    """With commas, the best first: for axes that take only some levels."""
    trackers: Annotated[str | None, option("NAMES", "default,paper; none with --costs")] = None
    """With commas, as for mot-sim sweep."""
    costs: Annotated[str | None, option("COSTS")] = None
    """Cue sets, with commas: each a cost, or some with weights (volume=0.6+reprojection=0.4)."""
    base_tracker: Annotated[str, option("TRACKER", "paper")] = "paper"
    """The tracker that the cue sets are for."""
    scene: Annotated[str, option("NAME", "intersection")] = "intersection"
    """mot-sim scenes."""
    profile: Annotated[str, option("NAME|FILE", "rrc")] = "rrc"
    """The detector's noise; cues has those that shape_pose and appearance need."""
    settings: Annotated[Many, option("NAME=LEVEL", name="set")] = ()
    """Any other axis, set to one level; repeatable."""
    seeds: int = 8
    """How many runs of each."""
    first_seed: int = 0
    """The next ones follow."""
    frames: int = 80
    """Of each run, at 10 Hz."""
    precision: float = 0.1
    """Of the level, relative."""
    out: Annotated[Path | None, option("DIR", "nothing is kept")] = None
    """Keep finished trials here: the same command goes on after Ctrl-C and repeats nothing."""
    jobs: int = 1
    """Processes on this machine; -1: one a core."""
    plot: Annotated[Path | None, option("FILE", "no picture")] = None
    """The score over the levels that were tried, as PNG, SVG or PDF, a line a tracker."""
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
        question = self.question()
        keep(self.out, "breaking-point", self._title(question), finished=False)

        def tell(tracker: str, level: Any) -> None:
            if self.verbose:
                terminal.note(f"{tracker}: {self.axis} = {level}")

        try:
            points = breaking_points(question, self.out, jobs=self.jobs, tell=tell)
        except KeyboardInterrupt:
            kept = "" if self.out is None else f"; finished trials stand in {self.out}"
            terminal.note(f"interrupted{kept}")
            return INTERRUPTED
        return self._show(terminal, question, points)

    def _title(self, question: "BreakingPointSpec") -> str:
        return f"{question.scene}: where {question.metric} breaks over {question.axis}"

    def question(self) -> "BreakingPointSpec":
        """What the options ask."""
        from mot_sim.experiments.stress.breaking_point_spec import BreakingPointSpec
        from mot_sim.experiments.sweep.paths import parse_level

        levels = () if self.levels is None else tuple(
            parse_level(word.strip()) for word in self.levels.split(",")
        )  # fmt: skip
        return BreakingPointSpec(
            self.axis, self.metric, self.drop, self.start, self.end, levels, self.precision,
            self.contenders(), self.scene, self.seeds, self.first_seed, self.frames,
            {"scene.profile": parse_level(self.profile), **dict(map(setting_of, self.settings))},
        )  # fmt: skip

    def contenders(self) -> "tuple[str | TrackerSpec, ...]":
        """The trackers, then one a cue set."""
        from mot_sim.experiments.sweep.tracker_specs import TrackerSpec

        names = self.trackers or ("default,paper" if self.costs is None else "")
        cues = [] if self.costs is None else self.costs.split(",")
        return (
            *(name.strip() for name in names.split(",") if name),
            *(TrackerSpec(cue.strip(), self.base_tracker, {"costs": cue.strip()}) for cue in cues),
        )

    def _show(
        self, terminal: Terminal, question: "BreakingPointSpec", points: "Sequence[BreakingPoint]"
    ) -> int:
        """The table, the JSON, the picture, what failed; the exit code."""
        from mot_sim.experiments.stress.breaking_table import (
            breaking_content,
            breaking_table,
            breaking_tables,
        )
        from mot_sim.experiments.sweep.curves import save_curves

        tables = breaking_tables(question, points)
        keep(self.out, "breaking-point", self._title(question), tables)
        if self.json is not None:
            content = breaking_content(question, points)
            terminal.save(jsonlib.dumps(content, indent=2) + "\n", self.json)
        if self.json != STDOUT:
            terminal.show(breaking_table(question, points))
        if self.plot is not None:
            save_curves(tables[1], self.plot, (self.metric,))
            terminal.note(f"written: {self.plot}")
        failed = [each for each in points if each.failed]
        for each in failed:
            terminal.note(f"{each.tracker}: {each.failed} trials failed: {each.error}")
        return BROKEN if failed else OK


def setting_of(text: str) -> "tuple[str, Level]":
    """An axis and its level from NAME=LEVEL."""
    from mot_sim.experiments.sweep.paths import parse_level
    from tracker.errors import BadConfig

    name, equals, value = (part.strip() for part in text.partition("="))
    if not (name and equals and value):
        raise BadConfig(f"--set {text}: write NAME=LEVEL")
    return name, parse_level(value)
