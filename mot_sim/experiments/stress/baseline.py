"""What trackers reached before: kept in a file, and held against what they reach now."""

import json
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from importlib.metadata import PackageNotFoundError, version
from math import isfinite
from pathlib import Path
from typing import Any

from mot_sim.experiments.stress.suites import Suite, Verdict, score_word
from mot_sim.experiments.sweep.summary import INTERVAL_NOTE
from mot_sim.files.documents import CONTENT_ERRORS, read_json
from mot_sim.files.fingerprint import digest
from mot_sim.files.writing import write_lines
from mot_sim.tables import Column, Interval, Table, with_ends
from tracker.errors import BadConfig, BadFile

BASELINE_FORMAT = 1
UPDATE = "--update-baseline measures anew"


@dataclass(frozen=True)
class BaselineVerdict:
    """A score now, and as it was before."""

    suite: str
    """The suite's name."""
    tracker: str
    """The tracker's name."""
    metric: str
    """TrackEval's name of the score."""
    is_upper: bool
    """Whether less of it is better."""
    reached: Interval
    """The mean over the seeds now, with its 95 % interval."""
    before: Interval
    """The same of the baseline."""

    @property
    def worse_by(self) -> float:
        """By how much the mean is worse than the mean before; below 0: better."""
        if self.reached.mean is None or self.before.mean is None:
            return float("inf")
        less = self.before.mean - self.reached.mean
        return -less if self.is_upper else less

    @property
    def passed(self) -> bool:
        """Whether the mean is not worse than before by more than half of the interval before."""
        return self.before.half is not None and self.worse_by <= self.before.half

    @property
    def told(self) -> str:
        """The score now and before in words."""
        mean, before = self.reached.mean, self.before
        if mean is None or before.mean is None or before.half is None:
            return "no score"
        now, then, half = (
            score_word(self.metric, each) for each in (mean, before.mean, before.half)
        )
        by = score_word(self.metric, abs(self.worse_by))
        how = f"{by} {'worse' if self.worse_by > 0.0 else 'better'}"
        return f"{now}, baseline {then} ± {half}: {how if self.worse_by else 'equal'}"


def write_baseline(
    path: Path, suites: Sequence[Suite], verdicts: Sequence[Verdict], first_seed: int
) -> None:
    """Keep what was reached: a mean with its interval a suite, tracker and metric.

    Raises BadConfig for trackers that failed, and for a single seed, which has no interval.
    """
    kept: dict[str, Any] = {suite.name: {"suite": _key(suite), "trackers": {}} for suite in suites}
    for each in verdicts:
        where = f"{each.suite}, {each.tracker}"
        if each.failed:
            raise BadConfig(f"{where}: {each.failed} trials failed: no baseline is written: {path}")
        if each.reached.half is None:
            raise BadConfig(f"{where}: no interval: a baseline needs --seeds 2 or more: {path}")
        metrics = kept[each.suite]["trackers"].setdefault(each.tracker, {})
        metrics[each.bound.metric] = asdict(each.reached)
    about = {"mot-sim baseline": BASELINE_FORMAT, "mot-sim": our_version()}
    content = {**about, "first_seed": first_seed, "suites": kept}
    write_lines(path, [json.dumps(content, indent=2)])


def read_baseline(path: Path) -> dict[str, Any]:
    """What a baseline holds. Raises BadFile for a file that is none, or of another version."""
    content = read_json(path, "no baseline can be read")
    if not isinstance(content, dict) or not isinstance(content.get("suites"), dict):
        raise BadFile(f"{path}: no baseline of mot-sim stress; {UPDATE}")
    form, made_by = content.get("mot-sim baseline"), content.get("mot-sim")
    if form != BASELINE_FORMAT:
        raise BadFile(f"{path}: a baseline of format {form!r:.20}, not {BASELINE_FORMAT}; {UPDATE}")
    if made_by != our_version():
        raise BadFile(
            f"{path}: a baseline of mot-sim {made_by!r:.40}, this is {our_version()}: scenes and "
            f"noise may differ; {UPDATE}"
        )
    return content


def require_baseline(
    content: dict[str, Any],
    path: Path,
    suites: Sequence[Suite],
    trackers: Sequence[str],
    seeds: range,
) -> None:
    """Raise BadFile where a baseline is of other suites, trackers or seeds."""
    for suite in suites:
        kept = content["suites"].get(suite.name)
        if not isinstance(kept, dict) or not isinstance(kept.get("trackers"), dict):
            known = ", ".join(content["suites"]) or "none"
            raise BadFile(f"{path}: it has no suite {suite.name}, only {known}; {UPDATE}")
        if kept.get("suite") != _key(suite):
            raise BadFile(
                f"{path}: suite {suite.name} was another (scene, frames or settings); {UPDATE}"
            )
        for tracker in trackers:
            metrics = kept["trackers"].get(tracker)
            if not isinstance(metrics, dict):
                known = ", ".join(kept["trackers"]) or "none"
                raise BadFile(
                    f"{path}: suite {suite.name} has no tracker {tracker}, only {known}; {UPDATE}"
                )
            for bound in suite.bounds:
                before = _before(metrics.get(bound.metric), f"{path}: {suite.name}, {tracker}")
                if (content.get("first_seed"), before.count) != (seeds.start, len(seeds)):
                    raise BadFile(
                        f"{path}: its runs are {before.count} from seed "
                        f"{content.get('first_seed')}, these are {len(seeds)} from seed "
                        f"{seeds.start}: give the same --seeds and --first-seed; {UPDATE}"
                    )


def against_baseline(content: dict[str, Any], verdicts: Sequence[Verdict]) -> list[BaselineVerdict]:
    """Every score beside what it was; content: checked by `require_baseline`."""
    found = []
    for each in verdicts:
        metrics = content["suites"][each.suite]["trackers"][each.tracker]
        before = _before(metrics[each.bound.metric], each.suite)
        metric = each.bound.metric
        reached = each.reached
        if each.failed:
            reached = Interval(None, None, None, 0)
        found.append(
            BaselineVerdict(each.suite, each.tracker, metric, each.bound.is_upper, reached, before)
        )
    return found


def drift_table(drifts: Sequence[BaselineVerdict]) -> Table:
    """A row a suite, tracker and metric: the score now beside that of the baseline."""
    columns = (
        Column.named("suite", "name"), Column.named("tracker", "name"), "metric",
        *with_ends("baseline"), *with_ends("reached"), "worse by", "verdict",
    )  # fmt: skip
    rows = [
        (
            each.suite, each.tracker, each.metric, *each.before.cells[:3], *each.reached.cells[:3],
            each.worse_by if isfinite(each.worse_by) else None,
            "as good" if each.passed else "WORSE",
        )
        for each in drifts
    ]  # fmt: skip
    return Table.of("drifts", "Beside the baseline", columns, rows, INTERVAL_NOTE)


def our_version() -> str:
    """Of mot-sim, as it is installed."""
    try:
        return version("mot-sim")
    except PackageNotFoundError:
        return "not installed"


def _key(suite: Suite) -> str:
    """A hash of what decides what a suite measures; its bounds may change."""
    return digest([suite.scene, suite.frames, dict(suite.settings)])


def _before(kept: Any, where: str) -> Interval:
    """The interval that a baseline holds. Raises BadFile."""
    try:
        mean, low, high = (float(kept[name]) for name in ("mean", "low", "high"))
        return Interval(mean, low, high, int(kept["count"]))
    except CONTENT_ERRORS as error:
        raise BadFile(f"{where}: no mean with its interval: {error!r:.80}; {UPDATE}") from None


__all__ = [
    "BaselineVerdict",
    "against_baseline",
    "drift_table",
    "read_baseline",
    "require_baseline",
    "write_baseline",
]
