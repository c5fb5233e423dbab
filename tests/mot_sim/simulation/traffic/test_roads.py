"""What the ground is painted with."""

import numpy as np

from mot_sim.simulation.traffic.roads import PAINTS, rectangle, stripe, zebra
from tracker.geometry import polygon_area


def area(surfaces) -> float:
    return float(polygon_area(np.array([surface.corners for surface in surfaces])).sum())


def test_a_rectangle_has_its_corners() -> None:
    corners = rectangle("asphalt", (1.0, 3.0), (5.0, 6.0)).corners
    assert corners.tolist() == [[1, 5], [3, 5], [3, 6], [1, 6]]


def test_a_solid_line_is_one_stripe_and_a_dashed_one_many() -> None:
    solid = stripe((0.0, 0.0), (0.0, 10.0), width=0.2)
    assert len(solid) == 1
    np.testing.assert_allclose(area(solid), 2.0)
    dashed = stripe((0.0, 0.0), (10.0, 0.0), width=0.2, dash=(3.0, 1.0))
    assert len(dashed) == 3
    np.testing.assert_allclose(area(dashed), 0.2 * (3 + 3 + 2))


def test_a_zebra_has_bars_of_half_a_metre() -> None:
    bars = zebra((0.0, 3.0), (-2.0, 2.0))
    assert len(bars) == 4
    np.testing.assert_allclose(area(bars), 4 * 3.0 * 0.5)
    assert {bar.paint for bar in bars} <= set(PAINTS)
