"""A table of means as curves: which axes have some, which lines they hold, in which order."""

from pathlib import Path

import pyarrow as pa
import pytest

from mot_sim.experiments.sweep.curves import axes_in, curve_charts, metrics_in, save_curves
from mot_sim.experiments.sweep.summary import mean_table, summary
from mot_sim.tables import Cell, Table
from tests.mot_sim.report.page.made import sweep_result
from tracker.errors import BadConfig


def table(axes: tuple[str, ...], rows: list[tuple[Cell, ...]]) -> Table:
    """Means of HOTA: levels, tracker, value."""
    columns = (*axes, "tracker", "HOTA", "HOTA low", "HOTA high")
    full = tuple((*row, row[-1], row[-1]) for row in rows)
    return Table.of("means", "", columns, full)


def test_axes_and_metrics_are_read_off_the_columns() -> None:
    made = sweep_result().tables[0]
    assert axes_in(made) == ("detector.jitter", "tracker.lifecycle.max_gap")
    assert metrics_in(made) == ("HOTA", "IDSW")


def test_one_axis_at_a_time_gives_a_chart_an_axis_in_percent() -> None:
    jitter, gap = curve_charts(sweep_result().tables[0], "HOTA")
    assert (jitter.x_title, gap.x_title) == ("detector.jitter", "tracker.lifecycle.max_gap")
    assert [each.name for each in jitter.series] == ["default", "paper"]
    assert jitter.series[0].x == (0.0, 1.0, 2.0)
    assert jitter.series[0].y == pytest.approx((90.0, 80.0, 70.0))
    assert jitter.series[1].low == pytest.approx((83.0, 73.0, 63.0))
    assert jitter.y_range == gap.y_range
    assert jitter.y_range is not None
    assert jitter.y_range[0] < 43.0
    assert jitter.y_range[1] > 92.0
    assert "default from 90.0 at 0.0 to 70.0 at 2.0" in jitter.about


def test_counts_are_no_percentages() -> None:
    chart = curve_charts(sweep_result().tables[0], "IDSW")[0]
    assert chart.series[0].y == pytest.approx((2.0, 3.0, 4.0))
    assert chart.y_title == "IDSW, mean of a run"


def test_levels_are_sorted_whatever_the_order_of_the_rows() -> None:
    (chart,) = curve_charts(table(("noise",), [(2.0, "a", 0.5), (0, "a", 0.9)]), "HOTA")
    assert chart.series[0].x == (0, 2.0)
    assert chart.kind == "lines"


def test_a_grid_gives_a_line_a_level_of_the_other_axis() -> None:
    rows: list[tuple[Cell, ...]] = [
        (x, y, "a", 0.9 - 0.1 * x) for x in (0.0, 1.0) for y in (0.0, 0.5)
    ]
    first, second = curve_charts(table(("p.x", "p.y"), rows), "HOTA")
    assert [each.name for each in first.series] == ["a, y=0", "a, y=0.5"]
    assert [each.dash for each in first.series] == [0, 1]
    assert second.x_title == "p.y"


def test_a_grid_of_too_many_lines_shows_those_at_the_first_levels() -> None:
    rows: list[tuple[Cell, ...]] = [
        (x, y, "a", 0.5) for x in (0.0, 1.0) for y in range(9)
    ]  # fmt: skip
    first, second = curve_charts(table(("p.x", "p.y"), rows), "HOTA")
    assert [each.name for each in first.series] == ["a"]
    assert first.title == "HOTA over p.x; y=0"
    assert len(second.series) == 2


def test_drawn_levels_are_points() -> None:
    rows: list[tuple[Cell, ...]] = [(0.1 * k, 1.0 - 0.07 * k, "a", 0.5) for k in range(5)]
    chart = curve_charts(table(("p.x", "p.y"), rows), "HOTA")[0]
    assert chart.kind == "points"
    assert len(chart.series) == 1
    assert len(chart.series[0].x) == 5


def test_words_are_rows_and_one_level_is_no_curve() -> None:
    rows: list[tuple[Cell, ...]] = [("fog", 1, "a", 0.5), ("clear", 1, "a", 0.7)]
    (chart,) = curve_charts(table(("weather", "gap"), rows), "HOTA")
    assert (chart.kind, chart.words) == ("rows", ("fog", "clear"))


def test_levels_where_every_seed_failed_are_left_out() -> None:
    rows: list[tuple[Cell, ...]] = [(0.0, "a", 0.5), (1.0, "a", None), (2.0, "a", 0.4)]
    (chart,) = curve_charts(table(("noise",), rows), "HOTA")
    assert chart.series[0].x == (0.0, 2.0)


@pytest.mark.parametrize("ending", [".png", ".svg", ".pdf"])
def test_a_real_sweep_becomes_a_picture(
    tmp_path: Path, swept: tuple[Path, pa.Table], ending: str
) -> None:
    path = save_curves(mean_table(summary(swept[1])), tmp_path / f"curves{ending}")
    assert path.stat().st_size > 5_000


def test_a_table_without_a_curve_is_refused(tmp_path: Path) -> None:
    with pytest.raises(BadConfig, match="no curves"):
        save_curves(table(("noise",), [(1.0, "a", 0.5)]), tmp_path / "a.png")
