"""Errors from above: what is drawn, and that hard input draws too."""

from pathlib import Path

import numpy as np
import pytest

from mot_sim.plotting.birds_eye import MAX_DRAWN, birds_eye_figure, distance_figure
from mot_sim.plotting.charts import save_figure


def cars(count: int) -> tuple[np.ndarray, np.ndarray]:
    """Cars straight ahead, believed a tenth of their distance too near."""
    places = np.column_stack([np.zeros(count), np.linspace(5.0, 60.0, count)])
    return places, 0.9 * places


def test_a_line_leads_from_every_car_to_its_belief() -> None:
    places, found = cars(240)
    above, _ = birds_eye_figure(places, found, "a title").axes
    (lines,) = above.collections
    segments = np.array(lines.get_segments())
    np.testing.assert_allclose(segments[:, 0], places)
    np.testing.assert_allclose(segments[:, 1], found)
    np.testing.assert_allclose(lines.get_array(), 0.1 * places[:, 1])


def test_errors_over_distance_stand_beside_what_was_stated() -> None:
    places, found = cars(240)
    (over,) = distance_figure(places, found, np.full(240, 2.0), "a title").axes
    names = [each.get_text() for each in over.get_legend().get_texts()]
    assert names == ["80 % of the rows", "median", "stated: 1 sigma"]
    median = next(line for line in over.lines if line.get_label() == "median")
    np.testing.assert_allclose(median.get_ydata(), -0.1 * median.get_xdata(), atol=0.3)


def test_of_many_rows_some_are_drawn() -> None:
    above = birds_eye_figure(*cars(2 * MAX_DRAWN + 1)).axes[0]
    assert len(above.collections[0].get_segments()) <= MAX_DRAWN
    assert "one row in 3" in above.get_title(loc="left")


def test_rows_that_are_not_known_are_left_out() -> None:
    places, found = cars(20)
    found[:5] = np.nan
    assert len(birds_eye_figure(places, found).axes[0].collections[0].get_segments()) == 15


@pytest.mark.parametrize("count", [0, 1])
def test_next_to_nothing_is_drawn_and_saved(tmp_path: Path, count: int) -> None:
    for number, figure in enumerate(
        (birds_eye_figure(*cars(count)), distance_figure(*cars(count)))
    ):
        path = save_figure(figure, tmp_path / f"{number}.png")
        assert path.read_bytes()[:4] == b"\x89PNG"
