"""Tables: one type for all that is shown, written or read back, with a writer for each format."""

from mot_sim.tables.columns import Cell, Column, Row, ShownColumn, show_value
from mot_sim.tables.interval import NO_INTERVAL, Interval, few_seeds_note
from mot_sim.tables.score_names import (
    COUNTS,
    RATES,
    SHARES,
    is_count,
    is_rate,
    limits_of,
    title_of,
)
from mot_sim.tables.spatial import consistency_table, criterion_table, error_table, spatial_table
from mot_sim.tables.table import (
    Table,
    mean_column,
    score_table,
    table_of,
    with_ends,
)

__all__ = [
    "COUNTS",
    "NO_INTERVAL",
    "RATES",
    "SHARES",
    "Cell",
    "Column",
    "Interval",
    "Row",
    "ShownColumn",
    "Table",
    "consistency_table",
    "criterion_table",
    "error_table",
    "few_seeds_note",
    "is_count",
    "is_rate",
    "limits_of",
    "mean_column",
    "score_table",
    "show_value",
    "spatial_table",
    "table_of",
    "title_of",
    "with_ends",
]
