"""`mot-sim stress`: hard situations, each with the scores that a tracker must reach."""

import json as jsonlib
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from time import perf_counter
from typing import TYPE_CHECKING, Annotated, Any

import tyro

from mot_sim.cli.keeping import keep
from mot_sim.cli.options import File, Flag, IsolationOptions, Jobs, Verbose, option
from mot_sim.cli.terminal import BROKEN, INTERRUPTED, OK, STDOUT, Terminal

if TYPE_CHECKING:
    from mot_sim.experiments.stress.baseline import BaselineVerdict
    from mot_sim.experiments.stress.suites import Suite, Verdict


@dataclass(frozen=True)
class Stress:
    """Run named suites of hard situations: pass or fail, for CI.

    mot-sim stress intersection night --trackers mine=my_module:MyTracker

    mot-sim stress smoke --trackers mine=my_module:MyTracker --junit out.xml --baseline base.json

    One line per bound: the mean over the seeds, its 95 % interval, and the bound that the mean
    must keep. Exit codes: 0 all bounds are kept; 1 a bound is broken, a tracker fails, or a score
    is worse than the baseline; 2 wrong input, nothing is written; 130 interrupted. `default` keeps
    the bounds with a margin; mot-sim stress --list shows them, --measure how they are derived.
    """

    suites: tyro.conf.Positional[Annotated[tuple[str, ...], option("SUITE", "all of them")]] = ()
    """Names of suites, see --list; or MODULE:NAME of your own."""
    list_suites: Annotated[bool, tyro.conf.arg(name="list", help_behavior_hint="")] = False
    """Show the suites and their bounds."""
    trackers: Annotated[str, option("NAMES", "default")] = "default"
    """Separated by commas, as for mot-sim sweep: default, paper, or mine=MODULE:CALLABLE."""
    seeds: int = 8
    """Number of runs of each; the bounds are for 8."""
    first_seed: int = 0
    """First seed; the runs use consecutive seeds."""
    file: Annotated[Path | None, option("FILE", "the suites of mot-sim")] = None
    """Suites of your own: a TOML file, see docs/testing.md."""
    out: Annotated[Path | None, option("DIR", "nothing is kept")] = None
    """Keep finished trials here; after Ctrl-C the same command continues and repeats nothing."""
    jobs: Jobs = 1
    isolation: IsolationOptions = field(default_factory=IsolationOptions)
    """Where trackers run, and what they may take there."""
    measure: Flag = False
    """Show what the trackers reach and the bounds that follow; nothing fails."""
    baseline: Annotated[Path | None, option("FILE")] = None
    """Fail for a mean that is worse than the one in this file by more than half of its 95 %
    interval; a file that is not there is written."""
    update_baseline: Flag = False
    """Write the baseline anew."""
    junit: Annotated[Path | None, option("FILE")] = None
    """The verdicts as JUnit's XML: a test case per bound, and per score of the baseline."""
    markdown: File = None
    """The verdicts as Markdown into a file, for the summary of a CI job; - prints it instead of
    the lines."""
    json: File = None
    """The verdicts as JSON into a file; - prints it instead of the lines."""
    verbose: Verbose = 0
    """Say more: -v, -vv."""

    @cached_property
    def _seconds(self) -> dict[str, float]:
        """The time that each suite took, s."""
        return {}

    def __call__(self, terminal: Terminal) -> int:
        """Run the suites and show the verdicts."""
        from mot_sim.cli.evaluate import require_targets
        from mot_sim.experiments.stress.suites import SUITES, find_suites, measured, read_suites

        require_targets(self.json, self.markdown)
        self._require_files()
        suites = find_suites(self.suites, read_suites(self.file or SUITES))
        if self.list_suites:
            from mot_sim.experiments.stress.suites import bound_table

            terminal.show(bound_table(suites))
            return OK
        if self.measure:
            suites = [measured(suite) for suite in suites]
        before = self._baseline(suites)
        try:
            verdicts = self._run(terminal, suites)
        except KeyboardInterrupt:
            kept = "" if self.out is None else f"; finished trials stand in {self.out}"
            terminal.note(f"interrupted{kept}")
            return INTERRUPTED
        self._tell_ranks(terminal, suites)
        drifts = self._hold(terminal, suites, verdicts, before)
        if self.junit is not None:
            from mot_sim.experiments.stress.ci_reports import junit_xml

            terminal.save(junit_xml(verdicts, drifts, self._seconds), str(self.junit))
        if self.markdown is not None:
            from mot_sim.experiments.stress.ci_reports import markdown_summary

            terminal.save(markdown_summary(verdicts, drifts), self.markdown)
        code = self._conclude(terminal, verdicts)
        return code if all(each.passed for each in drifts) else BROKEN

    def _require_files(self) -> None:
        """Raise BadOutput for files that cannot be written, BadConfig for options that clash."""
        from mot_sim.files.writing import require_writable
        from tracker.errors import BadConfig

        for path in (self.junit, self.baseline):
            if path is not None:
                require_writable(path)
        if self.update_baseline and self.baseline is None:
            raise BadConfig("--update-baseline: which one? give --baseline FILE")
        if self.baseline is not None and self.seeds < 2:
            raise BadConfig(
                f"--baseline with --seeds {self.seeds}: no interval; give --seeds 2 or more"
            )
        for option_name in ("baseline", "junit", "markdown"):
            if self.measure and getattr(self, option_name) is not None:
                raise BadConfig(f"--measure judges nothing: leave out --{option_name}")

    def _baseline(self, suites: "Sequence[Suite]") -> "dict[str, Any] | None":
        """What was reached before, checked; None where a baseline is to be written, or none is."""
        from mot_sim.experiments.stress.baseline import read_baseline, require_baseline

        if self.baseline is None or self.update_baseline or not self.baseline.exists():
            return None
        content = read_baseline(self.baseline)
        names = [each.name for each in self.isolation.specs(self._names())]
        seeds = range(self.first_seed, self.first_seed + self.seeds)
        require_baseline(content, self.baseline, suites, names, seeds)
        return content

    def _hold(
        self,
        terminal: Terminal,
        suites: "Sequence[Suite]",
        verdicts: "Sequence[Verdict]",
        before: "dict[str, Any] | None",
    ) -> "list[BaselineVerdict]":
        """The scores beside those of the baseline; or the baseline is written."""
        from mot_sim.experiments.stress.baseline import against_baseline, write_baseline

        if self.baseline is None:
            return []
        if before is None:
            write_baseline(self.baseline, suites, verdicts, self.first_seed)
            terminal.note(f"written: {self.baseline}, the baseline of later runs")
            return []
        drifts = against_baseline(before, verdicts)
        for each in drifts:
            if not each.passed:
                where = f"{each.suite}, {each.tracker}"
                terminal.note(f"worse than the baseline: {where}: {each.metric} {each.told}")
        self._keep(suites, verdicts, len(suites), drifts)
        same = sum(each.passed for each in drifts)
        terminal.note(f"{same} of {len(drifts)} scores are as good as those of {self.baseline}")
        return drifts

    def _names(self) -> tuple[str, ...]:
        return tuple(name.strip() for name in self.trackers.split(","))

    def _tell_ranks(self, terminal: Terminal, suites: "Sequence[Suite]") -> None:
        """Whether the scenes of the suites rank trackers as KITTI does."""
        from mot_sim.experiments.validation.scene_ranks import rank_line

        for scene in dict.fromkeys(suite.scene for suite in suites):
            terminal.note(rank_line(scene))

    def _run(self, terminal: Terminal, suites: "Sequence[Suite]") -> "list[Verdict]":
        """Run them one after the other; lines come as suites are finished."""
        from mot_sim.experiments.stress.suites import stress

        names = self.isolation.specs(self._names())
        found: list[Verdict] = []
        start = perf_counter()
        for number, suite in enumerate(suites, 1):
            with terminal.progress(lines=True) as advance:
                verdicts = stress(
                    suite,
                    names,
                    self.out,
                    seeds=self.seeds,
                    first_seed=self.first_seed,
                    jobs=self.jobs,
                    progress=advance,
                )
            found += verdicts
            self._seconds[suite.name] = perf_counter() - start
            start = perf_counter()
            self._keep(suites, found, number)
            if STDOUT not in (self.json, self.markdown):
                for verdict in verdicts:
                    terminal.write(
                        f"{measured_line(verdict) if self.measure else verdict_line(verdict)}\n"
                    )
        return found

    def _keep(
        self,
        suites: "Sequence[Suite]",
        found: "Sequence[Verdict]",
        done: int,
        drifts: "Sequence[BaselineVerdict]" = (),
    ) -> None:
        """Keep the verdicts so far, for the report. done: number of suites."""
        from mot_sim.experiments.stress.baseline import drift_table
        from mot_sim.experiments.stress.suites import suite_table, verdict_table

        trials = len(self.trackers.split(",")) * self.seeds
        title = ", ".join(suite.name for suite in suites[:3]) + ", ..." * (len(suites) > 3)
        keep(
            self.out, "stress", f"stress: {title}",
            (
                verdict_table(found), *([drift_table(drifts)] if drifts else []),
                suite_table(suites),
            ),
            finished=done == len(suites), trials=(done * trials, len(suites) * trials),
        )  # fmt: skip

    def _conclude(self, terminal: Terminal, verdicts: "Sequence[Verdict]") -> int:
        """The errors, the JSON, the sum; the exit code."""
        from mot_sim.experiments.stress.suites import verdict_content
        from mot_sim.tables import few_seeds_note

        if self.json is not None:
            content = list(verdict_content(verdicts))
            terminal.save(jsonlib.dumps(content, indent=2) + "\n", self.json)
        errors = {
            f"{each.suite}, {each.tracker}: {each.failed} trials failed: {each.error}": None
            for each in verdicts
            if each.failed
        }
        for error in errors:
            terminal.note(error)
        if few := few_seeds_note(each.reached.count for each in verdicts):
            terminal.note(few)
        if self.measure:
            return BROKEN if errors else OK
        bad = sum(not each.passed for each in verdicts)
        terminal.note(f"{len(verdicts) - bad} of {len(verdicts)} bounds are kept")
        return BROKEN if bad else OK


def verdict_line(verdict: "Verdict") -> str:
    """A verdict as one line: pass or fail, where, what was reached, and the bound."""
    from mot_sim.experiments.stress.suites import score_word

    word = "pass" if verdict.passed else "FAIL"
    bound = f"{verdict.bound.word} {score_word(verdict.bound.metric, verdict.bound.value)}"
    failed = f"  ({verdict.failed} trials failed)" if verdict.failed else ""
    return f"{word}  {_reached(verdict)}  {bound}{failed}"


def measured_line(verdict: "Verdict") -> str:
    """What was reached, and the bound that follows from it."""
    from mot_sim.experiments.stress.suites import bound_from

    metric = verdict.bound.metric
    bound = bound_from(metric, verdict.reached)
    told = "too few seeds" if bound is None else f"{metric} = {bound.value:g}"
    return f"{_reached(verdict)}  bound: {told}"


def _reached(verdict: "Verdict") -> str:
    """Where, which score, its mean, and its interval."""
    from mot_sim.experiments.stress.suites import score_word

    reached, metric = verdict.reached, verdict.bound.metric
    mean = "none" if reached.mean is None else score_word(metric, reached.mean)
    interval = ""
    if reached.low is not None and reached.high is not None:
        interval = f"[{score_word(metric, reached.low)}, {score_word(metric, reached.high)}]"
    return f"{verdict.suite:15} {verdict.tracker:10} {metric:6} {mean:>6} {interval:16}"
