"""How like recorded drives scenes are, as tables and as plain numbers."""

from collections.abc import Mapping, Sequence
from dataclasses import asdict
from itertools import chain
from math import isfinite
from typing import Any

import numpy as np

from mot_sim.experiments.validation.likeness import Likeness, ReferenceDrives, cumulated
from mot_sim.simulation.drive_statistics import DRIVE_STATISTICS, MeasuredDrive
from mot_sim.tables import Column, Row, Table

CURVE_POINTS = 25  # of a cumulated distribution
ENDS = (0.01, 0.99)  # of all values, between which it is shown


def likeness_table(found: Mapping[str, Likeness], reference: ReferenceDrives) -> Table:
    """A row a scene: how much of it is outside the range of the recorded drives, in sum."""
    columns = (
        Column("scene", "name"),
        Column("outside, sum", "value", "outside", 2),
        Column("statistics outside", "count"),
        Column("of", "count"),
        Column("mean gap", "value", "gap", 3),
        Column("unknown", "text"),
    )
    rows = tuple(
        (
            name,
            each.outside,
            each.count_outside,
            len(each.rows) - len(each.unknown),
            each.gap,
            ", ".join(each.unknown),
        )
        for name, each in found.items()
    )
    usual = float(np.nanmean(list(reference.usual_gap.values())))
    note = (
        "outside: how far a statistic lies outside the range of "
        f"{len(reference.drives)} drives of {reference.name}, in lengths of that range; gap: "
        "largest difference of the cumulated distributions, 0 to 1; between one of these drives "
        f"and the others it is {usual:.3f}"
    )
    return Table(columns, rows, f"Scenes beside {reference.name}", name="likeness", note=note)


def statistics_table(found: Mapping[str, Likeness], reference: ReferenceDrives) -> Table:
    """A row a scene and statistic, beside the median and the range of the recorded drives."""
    columns = (
        Column("scene", "name"),
        Column("statistic", "name"),
        Column("of the scene", "value", "value"),
        Column(f"{reference.name} [range]", "value", "median", shows_ends=True),
        Column("least", "value", "median low"),
        Column("most", "value", "median high"),
        Column("outside", "value", digits=2),
        Column("gap", "value", digits=2),
        Column("usual gap", "value", digits=2),
    )
    rows = tuple(
        (scene, DRIVE_STATISTICS[name].title, *map(_known, asdict(row).values()))
        for scene, each in found.items()
        for name, row in each.rows.items()
    )
    return Table(columns, rows, f"Statistics beside {reference.name}", name="statistics")


def distributions_table(
    scenes: Mapping[str, Sequence[MeasuredDrive]], reference: ReferenceDrives
) -> Table:
    """Cumulated distributions at CURVE_POINTS values: of the recorded drives, and of each scene.

    The interval of the recorded drives is the least and the largest share of one of them.
    """
    columns = (
        Column("statistic", "name"),
        Column("of", "name"),
        Column("value", "value"),
        Column("share", "value"),
        Column("share low", "value"),
        Column("share high", "value"),
    )
    rows: list[Row] = []
    for name, known in reference.samples.items():
        statistic = DRIVE_STATISTICS[name]
        if not known or known[0].dtype == bool:
            continue
        made = {scene: statistic.shown(drives) for scene, drives in scenes.items()}
        least, most = np.quantile(np.concatenate([*known, *chain(*made.values())]), ENDS)
        places = np.linspace(float(least), float(most), CURVE_POINTS)
        of_drives = np.array([cumulated([each], places) for each in known])
        curves = (of_drives.mean(axis=0), of_drives.min(axis=0), of_drives.max(axis=0))
        for value, *shares in zip(places, *curves, strict=True):
            rows.append((statistic.title, reference.name, value, *shares))
        for scene, samples in made.items():
            for value, share in zip(places, cumulated(samples, places), strict=True):
                rows.append((statistic.title, scene, value, _known(share), None, None))
    title = f"Cumulated distributions beside {reference.name}"
    return Table(columns, tuple(rows), title, name="distributions")


def likeness_content(found: Likeness) -> dict[str, Any]:
    """Everything of a scene, None for what was never to be seen."""
    return {
        "outside": found.outside,
        "count_outside": found.count_outside,
        "gap": _known(found.gap),
        "statistics": {
            name: {key: _known(value) for key, value in asdict(row).items()}
            for name, row in found.rows.items()
        },
    }


def _known(value: float) -> float | None:
    return value if isfinite(value) else None
