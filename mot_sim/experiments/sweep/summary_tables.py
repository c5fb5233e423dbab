"""A sweep's summary as tables: means with intervals, differences, and what failed."""

from collections import Counter
from collections.abc import Mapping, Sequence
from typing import Any

import pyarrow as pa

from mot_sim.experiments.sweep.paths import Level
from mot_sim.experiments.sweep.summary import Interval, SummaryRow
from mot_sim.tables.grid import COUNTS, RATES, Column, Table

SHOWN = ("HOTA", "AssA", "MOTA", "IDF1", "IDSW")
MOST_ERRORS = 10  # different ones that are listed
TITLES = {name: title for title, name in (RATES | COUNTS).items()}  # by TrackEval's name


def words(levels: Mapping[str, Level | None]) -> str:
    """A point as text: the axes that are set, by the last part of their names if that says it."""
    last = [axis.rpartition(".")[2] for axis in levels]
    names = last if len(set(last)) == len(last) else list(levels)
    return ", ".join(
        f"{name}={level:g}" if isinstance(level, float) else f"{name}={level}"
        for name, level in zip(names, levels.values(), strict=True)
        if level is not None
    )


def mean_table(lines: Sequence[SummaryRow], metrics: Sequence[str] = SHOWN) -> Table:
    """A row a point and tracker: mean ± half of the 95 % interval over the seeds."""
    rows = tuple(
        (
            words(line.levels), line.tracker,
            *(shown(line.metrics.get(name), name) for name in metrics),
            str(max((each.count for each in line.metrics.values()), default=0)),
            str(line.failed or ""),
        )
        for line in lines
    )  # fmt: skip
    title = "mean ± half of the 95 % interval over the seeds (Student's t); rates in %"
    return Table(_columns(metrics, "seeds", "failed"), rows, title)


def difference_table(lines: Sequence[SummaryRow], metrics: Sequence[str] = SHOWN) -> Table | None:
    """A row a point and tracker but the first: its differences to the first, paired by seed."""
    first = lines[0].tracker
    rows = tuple(
        (
            words(line.levels), line.tracker,
            *(shown(line.less.get(name), name, signed=True) for name in metrics),
            str(max((each.count for each in line.less.values()), default=0)),
        )
        for line in lines
        if line.less is not None
    )  # fmt: skip
    title = f"less {first}, seed by seed: mean ± half of the 95 % interval; rates in points"
    return Table(_columns(metrics, "pairs"), rows, title) if rows else None


def _columns(metrics: Sequence[str], *more: str) -> tuple[Column, ...]:
    titles = ("point", "tracker", *(TITLES.get(name, name) for name in metrics), *more)
    return tuple(Column(title) for title in titles)


def shown(interval: Interval | None, name: str, signed: bool = False) -> str:
    """A mean and half of its interval; rates in percent."""
    if interval is None or interval.mean is None:
        return ""
    is_rate = name in RATES.values()
    scale, digits = (100.0, 2) if is_rate else (1.0, 1)
    sign = "+" if signed else ""
    mean = f"{scale * interval.mean:{sign}.{digits}f}"
    if interval.high is None:
        return mean
    return f"{mean} ±{scale * (interval.high - interval.mean):.{digits}f}"


def failures(table: pa.Table) -> list[str]:
    """Each different error with its tracker and how often it came, the most frequent first."""
    rows = table.select(["tracker", "error"]).to_pylist()
    counted = Counter((row["tracker"], row["error"]) for row in rows if row["error"] is not None)
    lines = [
        f"{tracker}: {count} trial{'s' * (count != 1)} failed: {error}"
        for (tracker, error), count in counted.most_common(MOST_ERRORS)
    ]
    more = len(counted) - len(lines)
    return lines + [f"and {more} other errors: see the table's column error"] * (more > 0)


def summary_content(lines: Sequence[SummaryRow]) -> list[dict[str, Any]]:
    """The summary in plain values, ready for JSON."""
    return [
        {
            "levels": line.levels,
            "tracker": line.tracker,
            "failed": line.failed,
            "first_error": line.first_error,
            "metrics": {name: vars(each) for name, each in line.metrics.items()},
            "differences": None
            if line.less is None
            else {name: vars(each) for name, each in line.less.items()},
        }
        for line in lines
    ]
