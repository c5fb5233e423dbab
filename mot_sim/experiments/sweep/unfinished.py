"""A sweep's folder that was left half finished: how far it is, and the table of what is there."""

import json
from collections.abc import Mapping
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

import pyarrow as pa

from mot_sim.experiments.result_file import FAULTS
from mot_sim.experiments.sweep.design import Design
from mot_sim.experiments.sweep.points import Range
from mot_sim.experiments.sweep.running import SweepPlan
from mot_sim.experiments.sweep.store import SWEEP_FILE, SweepFolder
from mot_sim.experiments.sweep.tracker_specs import TrackerSpec
from mot_sim.files.fingerprint import FORMAT, digest
from mot_sim.files.text import read_text
from tracker.errors import BadFile, TrackingError


@dataclass(frozen=True, eq=False)
class PartialSweep:
    """What a folder holds of a sweep. table: of the finished trials; None of none.

    done, wanted: trials. description, code, versions: as `sweep.json` has them.
    """

    table: pa.Table | None
    done: int
    wanted: int
    description: Mapping[str, Any]
    code: str
    versions: dict[str, str]


def read_partial(folder: Path) -> PartialSweep:
    """Of the design in `sweep.json`, whatever is finished in `trials/`.

    Raises BadFile for a damaged `sweep.json`, for another format, and for a design that this
    mot-sim cannot understand (a tracker of somebody's own that is not to be found here).
    """
    file = folder / SWEEP_FILE
    try:
        about = json.loads(read_text(file))
        form, code = about["format"], str(about["code"])
        versions = {str(name): str(each) for name, each in about["versions"].items()}
        description = dict(about["design"])
    except FAULTS as error:
        raise BadFile(f"{file}: no sweep of ours: {error!r:.120}") from None
    if form != FORMAT:
        raise BadFile(f"{file}: a sweep of format {form!r:.20}, this mot-sim reads {FORMAT}")
    try:
        plan = SweepPlan(_design(description), folder)
    except (TrackingError, *FAULTS) as error:
        raise BadFile(
            f"{file}: its design cannot be understood here: {str(error)[:200]}; run its command "
            "again where it was made, then report"
        ) from None
    keys = _keys(plan, code)
    found = SweepFolder(folder).finished(keys)
    rows = [
        {
            "point": trial.number, **{axis: trial.point.get(axis) for axis in plan.design.axes},
            "seed": trial.seed, "tracker": trial.contender.name, **found[key].scores,
            "error": found[key].error,
        }
        for trial, key in zip(plan.trials, keys, strict=True)
        if key in found
    ]  # fmt: skip
    table = None
    if rows:
        names = dict.fromkeys(name for row in rows for name in row)
        table = pa.Table.from_pylist([{name: row.get(name) for name in names} for row in rows])
        told = json.dumps({"design": description})
        table = table.replace_schema_metadata({"mot-sim sweep": told})
    return PartialSweep(table, len(rows), len(plan.trials), description, code, versions)


def _design(description: Mapping[str, Any]) -> Design:
    """The design that a description is of."""
    known = {each.name for each in fields(Design)}
    given = {name: value for name, value in description.items() if name in known}
    given["axes"] = {
        axis: Range(levels["low"], levels["high"], levels["log"])
        if isinstance(levels, Mapping)
        else tuple(levels)
        for axis, levels in description["axes"].items()
    }
    given["trackers"] = tuple(
        TrackerSpec(
            name, each["made_by"], {key: each[key] for key in each if key != "made_by"}
        )
        for name, each in description["trackers"].items()
    )  # fmt: skip
    return Design(**given)


def _keys(plan: SweepPlan, code: str) -> list[str]:
    """The keys of all trials, which other code may have made; see `SweepPlan`."""
    same = [code, plan.design.rules]
    seen = [digest(each.description()) for each in plan.design.conditions]
    does: dict[int, str] = {}  # a tracker is the same object for all seeds of a point
    for trial in plan.trials:
        if id(trial.contender) not in does:
            does[id(trial.contender)] = digest(trial.contender.description())
    return [
        digest([same, seen[trial.number], does[id(trial.contender)], trial.seed])
        for trial in plan.trials
    ]
