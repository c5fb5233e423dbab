"""The street that bends: where its middle leads, and how our car drives it."""

from itertools import pairwise

import numpy as np
import pytest

from mot_sim.simulation.registry import find_scene
from mot_sim.simulation.scene import record_scene_traffic
from mot_sim.simulation.traffic.highway import ROADS
from mot_sim.simulation.traffic.highway.layout import LANE_WIDTH_METRES
from mot_sim.simulation.traffic.highway.streets import BENDS, turned_back
from mot_sim.simulation.traffic.scripted import Route


def test_the_way_back_ends_where_the_way_there_begins() -> None:
    there = Route([(0.0, 0.0), (60.0, 0.0), (90.0, 40.0), (150.0, 40.0)], 20.0).pieces
    back = turned_back(there)
    np.testing.assert_allclose(back[-1, 1:3] + back[-1, 5] * np.array([-1.0, 0.0]), 0.0, atol=1e-9)
    again = turned_back(back) - there
    np.testing.assert_allclose(again[:, [0, 1, 2, 4, 5]], 0.0, atol=1e-9)


def test_both_ways_of_the_bent_street_join_piece_by_piece() -> None:
    layout = ROADS["bent_street"]()
    for path in layout.paths:
        lanes = [layout.network.get_lane((*segment, 0)) for segment in path]
        for before, after in pairwise(lanes):
            ends, begins = before.position(before.length, 0.0), after.position(0.0, 0.0)
            np.testing.assert_allclose(ends, begins, atol=1e-9)
            turn = float(before.heading_at(before.length) - after.heading_at(0.0))
            assert np.cos(turn) == pytest.approx(1.0)
    there, back = layout.paths
    first, last = (layout.network.get_lane((*one, 0)) for one in (there[0], back[-1]))
    apart = first.position(0.0, 0.0) - last.position(last.length, 0.0)
    assert np.hypot(*apart) == pytest.approx(LANE_WIDTH_METRES)
    turned = np.pi + sum(np.radians(degrees) for _, degrees, _ in BENDS)
    assert layout.network.get_lane((*back[0], 0)).heading_at(0.0) == pytest.approx(turned)


def test_our_car_turns_with_the_bends_and_slows_down_before_them() -> None:
    scene = find_scene("street", bends=True, cars=0, arrivals=0.0, wander=0.0, frames=150)
    egos = record_scene_traffic(scene, 0).ego
    speed = 10.0 * np.hypot(*np.diff(egos[:, :2], axis=0).T)
    rate = 10.0 * np.degrees(np.abs(np.diff(egos[:, 2])))
    assert 15.0 < rate.max() < 25.0
    assert speed[rate > 15.0].max() < 7.0
    assert speed.max() > 10.0


def test_without_bends_the_street_is_straight() -> None:
    scene = find_scene("street", bends=False, cars=0, arrivals=0.0, wander=0.0, frames=40)
    assert np.ptp(record_scene_traffic(scene, 0).ego[:, 2]) == pytest.approx(0.0, abs=1e-6)
