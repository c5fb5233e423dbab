"""The tables of scores in 3D: by what makes a match, by sequence, and the errors behind them."""

from collections.abc import Mapping

import numpy as np

from mot_sim.metrics.clear import Number
from mot_sim.metrics.consistency import chances_by_range
from mot_sim.metrics.cuboid_errors import CuboidErrors
from mot_sim.metrics.spatial import SpatialScores
from mot_sim.tables.columns import Cell, Column, Kind
from mot_sim.tables.table import Table

DIGITS = 2  # behind the point, of metres
# Titles and kinds of columns, by the names of scores.
Titles = Mapping[str, tuple[str, Kind]]
CRITERION_COLUMNS: Titles = {
    "sAMOTA": ("sAMOTA", "rate"), "AMOTA": ("AMOTA", "rate"), "AMOTP": ("AMOTP", "value"),
    "MOTA": ("MOTA", "rate"), "MOTP": ("MOTP", "value"), "CLR_Re": ("recall", "rate"),
    "CLR_Pr": ("precision", "rate"), "CLR_TP": ("TP", "count"), "CLR_FP": ("FP", "count"),
    "CLR_FN": ("FN", "count"), "IDSW": ("IDS", "count"), "Frag": ("Frag", "count"),
    "MTR": ("MT %", "rate"), "PTR": ("PT %", "rate"), "MLR": ("ML %", "rate"),
    "MOTA3D": ("MOTA, all", "rate"),
}  # fmt: skip
ERROR_COLUMNS: Titles = {
    "matched_rows": ("rows", "count"), "centre_median": ("centre, m", "value"),
    "centre_p90": ("90 %, m", "value"), "within_2m": ("in 2 m", "rate"),
    "radial_median": ("radial, m", "value"), "lateral_median": ("lateral, m", "value"),
    "heading_over_30": ("heading > 30°", "rate"), "heading_over_90": ("> 90°", "rate"),
    "length_error": ("length, m", "value"), "height_error": ("height, m", "value"),
    "width_error": ("width, m", "value"), "iou_3d": ("3D IoU", "value"),
}  # fmt: skip
MOTION_COLUMNS: Titles = {
    "heading_over_90_moving": ("> 90°, moving", "rate"),
    "parked_over_1mps": ("parked > 1 m/s", "rate"), "speed_error": ("speed, m/s", "value"),
}  # fmt: skip
ERROR_TABLE_COLUMNS: Titles = {
    **ERROR_COLUMNS,
    **{name: MOTION_COLUMNS[name] for name in ("speed_error", "parked_over_1mps")},
}
NOTE_CRITERIA = (
    "MOTA to ML %: the level of recall with the greatest MOTA, as AB3DMOT shows it. MOTA, all: of "
    "all tracks; what meets a neutral label in the image is no false positive. MOTP, AMOTP: 3D "
    "IoU; MOTP of distances in metres."
)
NOTE_ERRORS = (
    "Rows that meet a label in the image (IoU 1/2): medians; heading and in 2 m: shares. Moving, "
    "parked: faster than 1 m/s or not. Oncoming, turned: by more than 30° off our way. Speed: of "
    "moving cars."
)


def criterion_table(scores: SpatialScores, title: str = "") -> Table:
    """AB3DMOT's scores, a row for each criterion."""
    numbers, rows = scores.numbers(), []
    for criterion in scores.criteria:
        by_distance = criterion.measure == "distance"
        cells = {name: numbers[f"{name}@{criterion.name}"] for name in CRITERION_COLUMNS}
        if by_distance:  # levels not reached would count as no error at all
            cells["AMOTP"] = np.nan
        what = f"{criterion.threshold:g} m" if by_distance else f"3D IoU {criterion.name}"
        rows.append((what, *_cells(cells, CRITERION_COLUMNS)))
    columns = _columns("match", CRITERION_COLUMNS)
    return Table(columns, tuple(rows), title, name="criteria", note=NOTE_CRITERIA)


def spatial_table(
    scores: Mapping[str, SpatialScores], first: str = "sequence", title: str = "", sums: int = 0
) -> Table:
    """A row for each of the scores: sAMOTA, MOTA and HOTA in 3D, and the errors of all rows."""
    columns: dict[str, tuple[str, Kind]] = {}
    for criterion in next(iter(scores.values())).criteria:
        what = criterion.name
        columns |= {
            f"sAMOTA@{what}": (f"sAMOTA {what}", "rate"), f"MOTA3D@{what}": (f"MOTA {what}", "rate")
        }  # fmt: skip
    columns |= {"HOTA3D": ("HOTA 3D", "rate"), **ERROR_COLUMNS, **MOTION_COLUMNS}
    rows = tuple((name, *_cells(each.numbers(), columns)) for name, each in scores.items())
    return Table(_columns(first, columns), rows, title, sums, "spatial")


def error_table(errors: CuboidErrors, title: str = "") -> Table:
    """The errors of all rows, by what the car does and by its distance."""
    groups = [(name, errors.select(rows)) for name, rows in errors.groups().items()]
    rows = tuple(
        (name, *_cells(part.numbers(), ERROR_TABLE_COLUMNS))
        for name, part in (*groups, *errors.by_distance())
    )
    columns = _columns("cars", ERROR_TABLE_COLUMNS)
    return Table(columns, rows, title, name="spatial_errors", note=NOTE_ERRORS)


def consistency_table(errors: CuboidErrors, title: str = "") -> Table | None:
    """How honest the stated uncertainties are; None where the output states none."""
    rows = tuple(
        (name, part.rows, part.inside_1_sigma, part.ideal(1.0), part.inside_2_sigma,
         part.ideal(2.0), part.nees, part.components)
        for name, part in errors.stated.consistency.items() if part.rows
    )  # fmt: skip
    if not rows:
        return None
    columns = (
        Column("stated", "name"), Column("rows", "count"), Column("in 1 sigma", "rate"),
        Column("ideal 1", "rate"), Column("in 2 sigma", "rate"), Column("ideal 2", "rate"),
        Column("NEES", "value", digits=DIGITS), Column("ideal NEES", "count"),
    )  # fmt: skip
    return Table(columns, rows, title, name="consistency", note=_heading_note(errors))


def _heading_note(errors: CuboidErrors) -> str:
    """What is said of the headings, by how sure the output was of them."""
    ranges = chances_by_range(errors.stated.heading_known, errors.heading_right)
    told = [
        f"{each.low:g}-{each.high:g}: {100 * each.came_true:.0f} % of {each.rows:,}"
        for each in ranges
        if each.rows
    ]
    return f"Heading not backwards, by its stated probability: {'; '.join(told)}." if told else ""


def _columns(first: str, columns: Titles) -> tuple[Column, ...]:
    named = (
        Column(title, kind, name, DIGITS if kind == "value" else None)
        for name, (title, kind) in columns.items()
    )
    return (Column(first, "name"), *named)


def _cells(numbers: Mapping[str, Number], columns: Titles) -> tuple[Cell, ...]:
    """The scores of some columns; None where nothing is known."""
    cells: list[Cell] = []
    for name, (_, kind) in columns.items():
        value = numbers[name]
        is_known = not np.isnan(value)
        cells.append((int(value) if kind == "count" else float(value)) if is_known else None)
    return tuple(cells)
