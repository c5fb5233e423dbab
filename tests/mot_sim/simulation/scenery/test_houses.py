"""Houses and wires: they differ, and stay within what is kept free for them."""

import numpy as np
import pytest

from mot_sim.simulation.renderers import Material
from mot_sim.simulation.scenery.houses import STOREY_METRES, WindowStyle, house
from mot_sim.simulation.scenery.props import WIRE_HEIGHT_METRES, wire

FRAME = (220, 220, 210)


def panes(number: int, detail: int = 0) -> np.ndarray:
    """The triangles of panes of a house 12 m wide and 9 m deep."""
    solid = house(3, number, 12.0, 9.0, detail)
    return solid.corners[solid.materials == Material.PANE]


def test_windows_of_houses_differ() -> None:
    styles = {WindowStyle.of(0, number, FRAME)[:4] for number in range(18)}
    assert len(styles) > 15
    sizes = {tuple(np.ptp(panes(number)[0], axis=0).round(2)) for number in range(18)}
    assert len(sizes) > 5


@pytest.mark.parametrize("number", range(18))
def test_windows_do_not_overlap(number: int) -> None:
    style = WindowStyle.of(1, number, FRAME)
    for length in (2.0, 8.0, 9.7, 15.0):
        places = style.places(length)
        assert len(places) >= 1
        assert (np.diff(places) >= style.width + 0.3).all()
        if style.shutters is not None:
            assert (np.diff(places) >= 2.0 * style.width).all()
        if length >= 8.0:
            assert places[0] > 0.5 * style.width
            assert places[-1] < length - 0.5 * style.width


@pytest.mark.parametrize("number", range(18))
@pytest.mark.parametrize("detail", [0, 1, 2])
def test_a_house_stays_on_its_ground(number: int, detail: int) -> None:
    corners = house(2, number, 12.0, 9.0, detail).corners.reshape(-1, 3)
    below_eaves = corners[corners[:, 2] < 2.0 * STOREY_METRES]
    assert below_eaves[:, :2].min() > -0.2
    assert (below_eaves[:, :2].max(axis=0) < (12.2, 9.2)).all()
    assert corners[:, 2].min() == 0.0


def test_far_houses_have_fewer_triangles() -> None:
    counts = [len(house(2, 5, 12.0, 9.0, detail)) for detail in range(3)]
    assert counts[0] > counts[1] > counts[2] > 20


def test_wires_hang_between_their_ends() -> None:
    start, end = np.array([3.0, -1.0]), np.array([30.0, 5.0])
    corners = wire(start, end, 0).corners.reshape(-1, 3)
    assert np.abs(corners[:, 2].max() - WIRE_HEIGHT_METRES) < 0.03
    assert 5.5 < corners[:, 2].min() < WIRE_HEIGHT_METRES - 0.4
    assert (corners[:, :2].min(axis=0) > (2.9, -1.1)).all()
    assert (corners[:, :2].max(axis=0) < (30.1, 5.1)).all()
    assert len(wire(start, end, 1)) < len(wire(start, end, 0))
    assert len(wire(start, end, 2)) == 0
