"""What an agreement says, as tables and as plain numbers."""

from collections.abc import Mapping
from typing import Any

from mot_sim.experiments.validation.agreement import (
    COUNTED,
    MIN_BOOTSTRAP_DRIVES,
    TOLERANCES,
    Agreement,
    Lead,
)
from mot_sim.experiments.validation.sums import METRICS
from mot_sim.experiments.validation.validate import Validation
from mot_sim.tables import Column, Interval, Row, Table
from mot_sim.tables.columns import Kind

CORRELATION_DIGITS = 3


def scores_table(agreement: Agreement, title: str) -> Table:
    """A row a tracker: its real score in each metric, and made less real."""
    columns: list[Column] = [Column("tracker", "name")]
    for metric in METRICS:
        kind: Kind = "count" if metric == COUNTED else "rate"
        digits, name = 0 if metric == COUNTED else 2, f"{metric} made - real"
        columns += [
            Column(metric, kind, digits=digits),
            Column(name, kind, digits=digits, is_signed=True),
            Column(f"{name} low", kind),
            Column(f"{name} high", kind),
        ]
    real = {metric: agreement.real_scores(metric) for metric in METRICS}
    apart = {metric: agreement.differences(metric) for metric in METRICS}
    rows: list[Row] = []
    for place, name in enumerate(agreement.names):
        cells: list[str | float | None] = [name]
        for metric in METRICS:
            cells += [float(real[metric][place]), *apart[metric][place].cells]
        rows.append(tuple(cells))
    note = f"made - real: mean over {len(agreement.worlds)} seeds with its 95 % interval"
    return Table(tuple(columns), tuple(rows), title, name="rows", note=note)


def agreement_table(agreement: Agreement) -> Table:
    """A row a metric: how many rows are near, and how the ranks agree."""
    columns = (
        Column("metric", "name"),
        Column("near limit"),
        Column("rows within", "count"),
        Column("far limit"),
        Column("rows within it", "count"),
        Column("of", "count"),
        Column("farthest"),
        Column("Spearman", "value", digits=CORRELATION_DIGITS, shows_ends=True),
        Column("Spearman low", "value"),
        Column("Spearman high", "value"),
        Column("Kendall", "value", digits=CORRELATION_DIGITS),
        Column("real halves", "value", digits=CORRELATION_DIGITS),
    )
    rows: list[Row] = []
    for metric in METRICS:
        limits, farthest = TOLERANCES[metric], _farthest(agreement, metric)
        rows.append(
            (
                metric,
                _limit(metric, limits.near, limits.slack),
                int(agreement.within(metric).sum()),
                _limit(metric, limits.far, limits.slack),
                int(agreement.within(metric, far=True).sum()),
                len(agreement.names),
                farthest,
                *agreement.rank_interval(metric).cells,
                agreement.rank_correlation(metric, "kendall"),
                agreement.ceiling(metric),
            )
        )
    few = f"{agreement.drive_count} drives: too few to resample; {MIN_BOOTSTRAP_DRIVES} or more"
    note = (
        few
        if agreement.drive_count < MIN_BOOTSTRAP_DRIVES
        else (
            "Spearman: of real scores with made ones, in brackets the middle 95 % over resampled "
            "drives; real halves: of one half of the real drives with the other, the median."
        )
    )
    return Table(columns, tuple(rows), "How near, and how alike the ranks are", name="agreement",
                 note=note)  # fmt: skip


def lead_table(agreement: Agreement) -> Table | None:
    """A row a metric: who leads, and ours before the best guest; None without guests."""
    rows: list[Row] = []
    for metric in METRICS:
        both = agreement.leads(metric)
        if both is None:
            return None
        real, made = both
        scale = 1.0 if metric == COUNTED else 100.0
        leads = [scale * each.points for each in both]
        rows.append((metric, real.leader, made.leader, real.guest, made.guest, *leads,
                     leads[1] - leads[0]))  # fmt: skip
    columns = (
        Column("metric", "name"), Column("leader"), Column("leader, made"), Column("best guest"),
        Column("best guest, made"), Column("lead", "value", digits=2, is_signed=True),
        Column("lead, made", "value", digits=2, is_signed=True),
        Column("overstated by", "value", digits=2, is_signed=True),
    )  # fmt: skip
    return Table(
        columns, tuple(rows), "The best of ours before the best guest", name="leads",
        note="In points; switches: how many fewer.",
    )  # fmt: skip


def agreement_content(agreement: Agreement) -> dict[str, Any]:
    """Plain numbers, ready for JSON."""
    content: dict[str, Any] = {"trackers": {}, "metrics": {}}
    for place, name in enumerate(agreement.names):
        content["trackers"][name] = {
            metric: {
                "real": float(agreement.real_scores(metric)[place]),
                "made": agreement.made_scores(metric)[place].tolist(),
                "is_near": bool(agreement.within(metric)[place]),
            }
            for metric in METRICS
        }
    for metric in METRICS:
        spearman, leads = agreement.rank_interval(metric), agreement.leads(metric)
        content["metrics"][metric] = {
            "near": int(agreement.within(metric).sum()),
            "far": int(agreement.within(metric, far=True).sum()),
            "spearman": _plain(spearman),
            "kendall": agreement.rank_correlation(metric, "kendall"),
            "real_halves": agreement.ceiling(metric),
            "lead": None if leads is None else [_lead(each) for each in leads],
        }
    return content


def scenes_table(scenes: Mapping[str, Agreement]) -> Table:
    """A row a scene: how its ranks agree with the real ones, and who leads."""
    columns = [Column("scene", "name")]
    for metric in METRICS:
        columns += [
            Column(f"{metric} ranks", "value", digits=2, shows_ends=True),
            Column(f"{metric} ranks low", "value"), Column(f"{metric} ranks high", "value"),
        ]  # fmt: skip
    columns += [
        Column("leader by HOTA"), Column("HOTA lead", "value", digits=2, is_signed=True),
        Column("MOTA lead", "value", digits=2, is_signed=True),
    ]  # fmt: skip
    rows: list[Row] = []
    for name, agreement in scenes.items():
        cells: list[str | float | None] = [name]
        for metric in METRICS:
            cells += agreement.rank_interval(metric).cells
        by_hota, by_mota = agreement.leads("HOTA"), agreement.leads("MOTA")
        made = agreement.made_scores("HOTA").mean(axis=1)
        cells.append(agreement.names[int(made.argmax())])
        cells += [None if each is None else 100.0 * each[1].points for each in (by_hota, by_mota)]
        rows.append(tuple(cells))
    return Table(
        tuple(columns), tuple(rows), "Scenes: Spearman's correlation of their ranks with the real",
        name="scenes", note="lead: the best of ours before the best guest, in points.",
    )  # fmt: skip


def _farthest(agreement: Agreement, metric: str) -> str:
    """The row that is farthest off, with how far."""
    real, made = agreement.real_scores(metric), agreement.made_scores(metric).mean(axis=1)
    apart = made - real
    place = int(abs(apart).argmax())
    said = f"{apart[place]:+.0f}" if metric == COUNTED else f"{100 * apart[place]:+.2f}"
    return f"{agreement.names[place]} {said}"


def _limit(metric: str, share: float, slack: float) -> str:
    """A limit in words."""
    if metric == COUNTED:
        return f"{100 * share:g} % or {slack:g}"
    return f"{100 * share:g} points"


def _plain(interval: Interval) -> dict[str, float | None]:
    return {"value": interval.mean, "low": interval.low, "high": interval.high}


def _lead(lead: Lead) -> dict[str, str | float]:
    return {"leader": lead.leader, "ours": lead.ours, "guest": lead.guest, "points": lead.points}


def validation_tables(found: Validation, title: str) -> list[Table]:
    """All that was found: rows, agreement, leads, scenes, and what failed."""
    tables: list[Table | None] = []
    if found.reenacted is not None:
        mine = found.reenacted
        tables += [scores_table(mine, title), agreement_table(mine), lead_table(mine)]
    if found.scenes:
        tables.append(scenes_table(found.scenes))
    if found.failures:
        rows = [(name, each.reason) for name, each in found.failures.items()]
        columns = (Column.named("tracker", "name"), "reason")
        tables.append(Table.of("failures", "Trackers that failed", columns, rows))
    return [each for each in tables if each is not None]


def validation_content(found: Validation) -> dict[str, Any]:
    """The same as plain numbers, ready for JSON."""
    mine = found.reenacted
    return {
        "re-enacted": None if mine is None else agreement_content(mine),
        "scenes": {name: agreement_content(each) for name, each in found.scenes.items()},
        "failures": {name: each.reason for name, each in found.failures.items()},
    }
