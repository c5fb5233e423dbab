"""What came of a result, in a few sentences: the summary on top of the page."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Literal

from mot_sim.experiments.result_file import Result
from mot_sim.experiments.sweep.curves import axes_in, metrics_in
from mot_sim.report.page.tables import shown_columns
from mot_sim.tables import Cell, Table, is_rate, show_value

Tone = Literal["good", "bad", "plain"]
MAX_NAMED = 6  # verdicts of one kind that are named one by one
Row = dict[str, Cell]


@dataclass(frozen=True)
class Sentence:
    """One sentence of the summary on top of the page."""

    text: str
    """What is said."""
    tone: Tone = "plain"
    """Whether it is good or bad news, or neither: good, bad or plain."""


def verdicts_of(result: Result) -> list[Sentence]:
    """The sentences of a result: how complete it is, then what it says."""
    if result.made.form_only:  # nothing follows from its numbers
        return [Sentence("It shows the form of the tables; what was measured is no result.", "bad")]
    said = list(_progress(result))
    if any(table.rows for table in result.tables):
        said += VERDICTS.get(result.kind, _counts)(result)
    failures = result.table("failures")
    if failures is not None and failures.has("tracker", "trials"):
        for tracker, trials in _summed(failures, "tracker", "trials").items():
            said.append(Sentence(f"{tracker}: {trials:g} trials failed.", "bad"))
    return said


def _progress(result: Result) -> Iterator[Sentence]:
    """How far it is, where it is not finished."""
    if result.made.trials is not None:
        done, wanted = result.made.trials
        if done < wanted:
            rest = "what is there is shown" if done else "there is nothing to show yet"
            yield Sentence(f"{done:,} of {wanted:,} trials are finished; {rest}.", "bad")
            return
        all_of = f"All {wanted:,} trials are" if wanted != 1 else "The one trial is"
        yield Sentence(f"{all_of} finished.", "good")
    elif not result.made.finished:
        yield Sentence("It was not finished; what is there is shown.", "bad")


def _sweep(result: Result) -> Iterator[Sentence]:
    """The best and the worst of each tracker, and how often it is above or below the first."""
    table = result.table("means")
    if table is None or not table.has("tracker") or not metrics_in(table):
        return
    metric = metrics_in(table)[0]
    for tracker, rows in _by(table, "tracker").items():
        there = [row for row in rows if isinstance(row[metric], float | int)]
        if not there:
            continue
        ordered = sorted(there, key=lambda row: float(row[metric] or 0.0))
        ends = [f"{_mean(table, row, metric)} at {_point(table, row)}" for row in ordered]
        if len(ends) == 1:
            yield Sentence(f"{tracker}: {metric} {ends[0]}.")
        else:
            yield Sentence(f"{tracker}: {metric} from {ends[0]} to {ends[-1]}.")
    less = result.table("differences")
    if less is not None and less.has(f"{metric} high"):
        for tracker, rows in _by(less, "tracker").items():
            below = sum(_number(row[f"{metric} high"], 0.0) < 0.0 for row in rows)
            above = sum(_number(row[f"{metric} low"], 0.0) > 0.0 for row in rows)
            yield Sentence(
                f"{less.title}: {tracker} is below at {below} and above at {above} of "
                f"{len(rows)} points ({metric}, by 95 % intervals)."
            )


def _stress(result: Result) -> Iterator[Sentence]:
    """How many bounds are kept, and which are not; how many scores are as good as before."""
    yield from _drifts(result)
    table = result.table("verdicts")
    if table is None or not table.has("suite", "tracker", "metric", "verdict"):
        return
    rows = [row for row in table.as_records() if row["verdict"] is not None]
    if not rows:
        yield Sentence("Measured only: no bounds were asked for.")
        return
    bad = [row for row in rows if row["verdict"] != "pass"]
    told = f"{len(rows) - len(bad)} of {len(rows)} bounds are kept."
    yield Sentence(told, "bad" if bad else "good")
    for row in bad[:MAX_NAMED]:
        part = is_rate(str(row["metric"]))
        reached = _mean(table, row, "reached", part) or "nothing"
        bound = f"{row.get('must be') or ''} {show_value(row.get('bound'), is_part=part)}"
        yield Sentence(
            f"{row['suite']}, {row['tracker']}: {row['metric']} is {reached}, must be {bound}.",
            "bad",
        )
    if len(bad) > MAX_NAMED:
        yield Sentence(f"{len(bad) - MAX_NAMED} more are not kept: see the table.", "bad")


def _drifts(result: Result) -> Iterator[Sentence]:
    """The scores that are worse than the baseline."""
    table = result.table("drifts")
    if table is None or not table.has("suite", "tracker", "metric", "baseline", "verdict"):
        return
    rows = table.as_records()
    bad = [row for row in rows if row["verdict"] != "as good"]
    told = f"{len(rows) - len(bad)} of {len(rows)} scores are as good as the baseline."
    yield Sentence(told, "bad" if bad else "good")
    for row in bad[:MAX_NAMED]:
        part = is_rate(str(row["metric"]))
        now, before = (_mean(table, row, name, part) for name in ("reached", "baseline"))
        yield Sentence(
            f"{row['suite']}, {row['tracker']}: {row['metric']} is {now or 'nothing'}, the "
            f"baseline {before}.",
            "bad",
        )
    if len(bad) > MAX_NAMED:
        yield Sentence(f"{len(bad) - MAX_NAMED} more are worse: see the table.", "bad")


def _break(result: Result) -> Iterator[Sentence]:
    """Where each tracker breaks."""
    table = result.table("points")
    if table is None or not table.has("tracker", "level"):
        return
    yield Sentence(f"{table.title}:")
    for row in table.as_records():
        level = _mean(table, row, "level")
        told = level or f"none up to {show_value(row.get('farthest tried'))}"
        yield Sentence(f"{row['tracker']}: {told}.")


def _compare(result: Result) -> Iterator[Sentence]:
    """The order by HOTA, and who failed."""
    table = result.table("scores")
    if table is None or not table.has("tracker"):
        return
    metric = next((name for name in ("HOTA", "MOTA") if table.has(name)), None)
    if metric is not None:
        there = [row for row in table.as_records() if isinstance(row[metric], float | int)]
        there.sort(key=lambda row: -_number(row[metric], 0.0))
        said = [f"{row['tracker']} {show_value(row[metric], is_part=True)}" for row in there]
        yield Sentence(f"By {metric}: {', '.join(said)}.")
    failed = result.table("failures")
    for row in failed.as_records() if failed is not None else ():
        yield Sentence(f"{row.get('tracker')} failed: {row.get('reason')}", "bad")


def _tables(result: Result) -> Iterator[Sentence]:
    """Which tables there are."""
    for table in result.tables:
        metric = next((name for name in ("HOTA", "MOTA") if table.has(name)), None)
        rows = [
            row for row in table.as_records() if metric and isinstance(row[metric], float | int)
        ]
        best = ""
        if metric and rows:
            most = max(rows, key=lambda row: _number(row[metric], 0.0))
            best = f", most {metric}: {most[table.names[0]]} {_mean(table, most, metric)}"
        yield Sentence(f"{table.title.partition(';')[0]}: {len(table.rows)} rows{best}.")


def _tune(result: Result) -> Iterator[Sentence]:
    """The weights, and what they are worth."""
    table, worth = result.table("weights"), result.table("worth")
    if table is not None and table.has("cost", "weight"):
        said = [f"{row['cost']} {show_value(row['weight'])}" for row in table.as_records()]
        yield Sentence(f"Weights: {', '.join(said)}.")
    if worth is not None and len(worth.columns) == 2:
        for name, value in worth.rows:
            metric = worth.columns[1]
            yield Sentence(f"{metric.name} by {name}: {metric.show(value)}.")


def _counts(result: Result) -> Iterator[Sentence]:
    """Of tables that nobody knows here: the row with the most in every column of whole numbers."""
    for table in result.tables[:2]:
        names = [each.column.name for each in shown_columns(table) if not each.is_number]
        whole = [
            name
            for name in table.names
            if any(isinstance(value, int) for value in table.column(name))
            and all(isinstance(value, int) or value is None for value in table.column(name))
        ]
        if not (names and whole and table.rows):
            continue
        rows = table.as_records()
        most = max(rows, key=lambda row: _number(row[whole[-1]], 0.0))
        where = ", ".join(show_value(most[name]) for name in names if most[name] is not None)
        told = f"{table.title}: {len(rows)} rows; most {whole[-1]}: {where}, "
        yield Sentence(f"{told}{show_value(most[whole[-1]])}.")


def _run(result: Result) -> Iterator[Sentence]:
    """Of results in 3D how far off cuboids are and how honest; of others, the largest counts."""
    criteria, errors = result.table("criteria"), result.table("spatial_errors")
    if criteria is None or errors is None or not (criteria.rows and errors.rows):
        yield from _counts(result) if result.table("sequences") is None else _tracked(result)
        return
    if criteria.has("match", "MOTA3D"):
        said = [
            f"{row['match']}: {_mean(criteria, row, 'MOTA3D')}" for row in criteria.as_records()
        ]
        yield Sentence(f"MOTA in 3D, %: {', '.join(said)}.")
    every = errors.as_records()[0]

    def told(name: str) -> str:
        return _mean(errors, every, name) or "unknown"

    if errors.has("centre_median", "within_2m", "heading_over_30", "heading_over_90"):
        yield Sentence(
            f"Centres: {told('centre_median')} m off in the median, {told('within_2m')} % within "
            f"2 m. Headings: {told('heading_over_30')} % more than 30° off, "
            f"{told('heading_over_90')} % more than 90°."
        )
    stated = result.table("consistency")
    if stated is not None and stated.has("stated", "in 2 sigma", "ideal 2"):
        said = [
            f"{row['stated']} {_mean(stated, row, 'in 2 sigma')} (ideal "
            f"{_mean(stated, row, 'ideal 2')})"
            for row in stated.as_records()
        ]
        yield Sentence(f"Inside the stated 2 sigma, %: {', '.join(said)}.")


def _tracked(result: Result) -> Iterator[Sentence]:
    """How much went through a tracker, over all drives."""
    table = result.table("sequences")
    if table is None or not table.has("frames", "detections", "rows", "ids"):
        return
    drives = len(table.rows)
    frames, detections, rows, ids = (
        sum(_number(value, 0.0) for value in table.column(name))
        for name in ("frames", "detections", "rows", "ids")
    )
    yield Sentence(
        f"{drives} drive{'s' * (drives != 1)}, {frames:,.0f} frames: {detections:,.0f} detections "
        f"gave {rows:,.0f} rows of {ids:,.0f} ids."
    )


def _diagnosis(result: Result) -> Iterator[Sentence]:
    """What most switches happen around, and what they hang on."""
    for name, words, value in (("events", "around", "switches"), ("causes", "hangs on", "share")):
        table = result.table(name)
        if table is None or not table.has(words, value):
            continue
        rows = [row for row in table.as_records() if _number(row[value], 0.0) > 0.0]
        rows.sort(key=lambda row: -_number(row[value], 0.0))
        kinds = {str(row[words]) for row in rows}
        said = [
            f"{row[words]} {_mean(table, row, value)}"
            for row in rows
            if row[words] != "all" and not _is_bin(str(row[words]), kinds)
        ]
        unit = ", %" if table.typed(value).kind == "rate" else ""
        told = ", ".join(said[:MAX_NAMED]) or "none"
        yield Sentence(f"{table.title} ({value}{unit}): {told}.")


def _is_bin(name: str, kinds: set[str]) -> bool:
    """Whether a row divides another one further: `occlusion, up to 0.5 s`."""
    kind, comma, _ = name.partition(", ")
    return bool(comma) and kind in kinds


VERDICTS: dict[str, Callable[[Result], Iterator[Sentence]]] = {
    "sweep": _sweep,
    "stress": _stress,
    "breaking-point": _break,
    "compare": _compare,
    "tables": _tables,
    "tune": _tune,
    "diagnosis": _diagnosis,
    "run": _run,
}


def _by(table: Table, column: str) -> dict[str, list[Row]]:
    """The rows by the value of a column, in order."""
    found: dict[str, list[Row]] = {}
    for row in table.as_records():
        found.setdefault(str(row[column]), []).append(row)
    return found


def _summed(table: Table, column: str, number: str) -> dict[str, float]:
    """The sum of a column of numbers by the value of another."""
    groups = _by(table, column)
    return {name: sum(_number(row[number], 0.0) for row in rows) for name, rows in groups.items()}


def _number(value: Cell, otherwise: float) -> float:
    return float(value) if isinstance(value, float | int) else otherwise


def _mean(table: Table, row: Row, name: str, part: bool | None = None) -> str:
    """A value of a row with its interval; part: whether in percent, None: as its name says."""
    is_part = table.typed(name).kind == "rate" if part is None else part
    return show_value(row.get(name), row.get(f"{name} low"), row.get(f"{name} high"), is_part)


def _point(table: Table, row: Row) -> str:
    told = ", ".join(
        f"{name.rpartition('.')[2]}={show_value(row[name])}"
        for name in axes_in(table)
        if row[name] is not None
    )
    return told or "the scene's own levels"
