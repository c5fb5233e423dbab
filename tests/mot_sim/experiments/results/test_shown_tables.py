"""Shown tables as plain values: means with their intervals become three columns."""

import numpy as np
import pytest

from mot_sim.experiments.results.shown_tables import ends, result_table
from mot_sim.tables.grid import Column, Table


def test_a_mean_and_half_of_its_interval_become_fractions() -> None:
    columns = (Column(""), Column("MOTA"), Column("MOTA - all"), Column("IDSW"), Column("drives"))
    rows = (
        ("all", "88.00 ±2.00", "", "3.5 ±0.5", 50),
        ("3D-2D", "80.00", "-8.00 ±1.00", "9.0 ±2.0", np.int64(50)),
    )
    table = result_table("III.1", Table(columns, rows, "Table III"))
    assert table.columns == ("row", *ends("MOTA"), *ends("MOTA - all"), *ends("IDSW"), "drives")
    assert table.rows[0][:4] == (
        "all",
        pytest.approx(0.88),
        pytest.approx(0.86),
        pytest.approx(0.9),
    )
    assert table.rows[0][4:7] == (None, None, None)
    assert table.rows[1][1:4] == (pytest.approx(0.8), None, None)
    assert table.rows[1][4:7] == pytest.approx((-0.08, -0.09, -0.07))
    assert table.rows[1][7:] == (9.0, 7.0, 11.0, 50)
    assert type(table.rows[1][-1]) is int


def test_other_values_stay_as_they_are() -> None:
    columns = (Column("tracker"), Column("MOTA", "rate"), Column("IDSW", "count"))
    table = result_table("scores", Table(columns, (("ours", 0.9, 3), ("* theirs", None, None))))
    assert table.columns == ("tracker", "MOTA", "IDSW")
    assert table.rows == (("ours", 0.9, 3), ("* theirs", None, None))


def test_no_rows_give_no_rows() -> None:
    assert result_table("t", Table((Column("a"),), ())).rows == ()
