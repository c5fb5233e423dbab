"""Who may go: nobody behind one who stands, nobody into a ring that is half full."""

import numpy as np

from mot_sim.simulation.traffic.highway import ROADS
from mot_sim.simulation.traffic.highway.car import Car
from mot_sim.simulation.traffic.highway.layout import Layout
from mot_sim.simulation.traffic.highway.right_of_way import RightOfWay, circulating
from mot_sim.simulation.traffic.highway.road import CarRoad


def way(layout: Layout, *nodes: str) -> int:
    """The number of the path that passes these nodes."""
    passed = [[segment[0] for segment in path] + [path[-1][1]] for path in layout.paths]
    return next(number for number, path in enumerate(passed) if set(nodes) <= set(path))


def car(road: CarRoad, number: int, way: int, along: float, leg: int = 0) -> Car:
    one = Car(road, number, (4.4, 1.45, 1.8), (way, leg), (0, along), 0.0, 1.0)
    road.vehicles.append(one)
    return one


def test_nobody_gets_the_right_of_way_behind_a_car_that_stands() -> None:
    layout = ROADS["intersection"]()
    road, rules = CarRoad(layout, np.random.default_rng(0)), RightOfWay(layout)
    across = car(road, 0, way(layout, "from1", "to3"), 1.0, leg=1)
    left = car(road, 1, way(layout, "from2", "to3"), 115.0)
    behind = car(road, 2, way(layout, "from2", "to1"), 108.0)
    rules.going = {across: 1}
    rules.update(road.vehicles)
    assert rules.waiting == [left, behind]
    assert left.held
    assert behind.held
    rules.update([left, behind])  # the crossing is free
    assert list(rules.going) == [left, behind]


def test_nobody_enters_a_ring_that_is_half_full() -> None:
    layout = ROADS["roundabout"]()
    road, rules = CarRoad(layout, np.random.default_rng(0)), RightOfWay(layout)
    assert circulating(layout.paths) == {one for one in rules.ring if one not in layout.merges}
    assert circulating(ROADS["street"]().paths) == set()
    inside = [
        car(road, number, path, 1.0, leg=1)
        for number, path in enumerate(np.arange(20) % len(layout.paths))
    ]
    needed = int(0.5 * rules.ring_metres / (4.4 + 2.0)) + 1
    assert rules._has_room(inside[: needed - 1])
    assert not rules._has_room(inside[:needed])


def test_a_car_that_crosses_its_line_without_the_right_waits_no_longer() -> None:
    """Nobody holds a car that somebody else steers."""
    layout = ROADS["intersection"]()
    road, rules = CarRoad(layout, np.random.default_rng(0)), RightOfWay(layout)
    across = car(road, 0, way(layout, "from1", "to3"), 1.0, leg=1)
    ours = car(road, 1, way(layout, "from2", "to3"), 115.0)
    rules.going = {across: 1}
    rules.update(road.vehicles)
    assert rules.waiting == [ours]
    ours.leg = len(ours.path) - 1
    rules.update(road.vehicles)
    assert rules.waiting == []
