"""The roads themselves: ways without gaps, on the right, and a search equal to highway-env's."""

from copy import copy
from typing import Any

import numpy as np
import pytest
from highway_env.road.road import Road
from highway_env.vehicle.kinematics import Vehicle

from mot_sim.simulation.traffic.highway import ROADS, HighwayTraffic
from mot_sim.simulation.traffic.highway.car import TICK_SECONDS, Car
from mot_sim.simulation.traffic.highway.lane_table import LaneTable
from mot_sim.simulation.traffic.highway.road import CarRoad
from tracker.geometry import wrap_angle


@pytest.mark.parametrize("road", ROADS)
def test_every_way_goes_on_where_its_last_lane_ended(road: str) -> None:
    layout = ROADS[road]()
    roads = CarRoad(layout, np.random.default_rng(0))
    for path in layout.paths:
        index = (*path[0], 0)
        for segment in path[1:]:
            lane, (after, joins) = layout.network.get_lane(index), roads.onward(index, segment)
            assert joins != lane.forbidden  # the lane behind the ramp ends
            if not joins:
                break
            begin = layout.network.get_lane(after)
            gap = begin.position(0.0, 0.0) - lane.position(lane.length, 0.0)
            turn = wrap_angle(begin.heading_at(0.0) - lane.heading_at(lane.length))
            np.testing.assert_allclose(gap, 0.0, atol=1e-9)
            assert abs(turn) < (0.12 if "ramp" in index else 1e-9)
            index = after


@pytest.mark.parametrize("road", ["intersection", "roundabout", "street"])
def test_lanes_lie_to_the_right_of_the_middle_of_the_road(road: str) -> None:
    layout = ROADS[road]()
    for segment in layout.fillable:
        lane = layout.network.get_lane((*segment, 0))
        heading = lane.heading_at(0.0)
        right = np.array([-np.sin(heading), np.cos(heading)])
        assert lane.position(0.0, 0.0) @ right == pytest.approx(1.75)


def test_ways_of_the_intersection_that_cross_exclude_each_other() -> None:
    crossings = ROADS["intersection"]().crossings
    straight, opposite = ("line2", "leave0"), ("line0", "leave2")
    assert opposite not in crossings[straight]
    assert ("line1", "leave3") in crossings[straight]
    assert ("line0", "leave1") in crossings[straight]  # turns left across it
    assert ("line0", "leave3") not in crossings[straight]  # turns right, on the other side
    assert all(one in crossings[other] for one in crossings for other in crossings[one])


@pytest.mark.parametrize("road", ["highway", "intersection", "roundabout"])
def test_points_are_projected_on_a_lane_as_highway_env_does(road: str) -> None:
    points = np.random.default_rng(0).uniform(-60, 60, (20, 2))
    named = ROADS[road]().network.lanes_dict()
    table, lanes = LaneTable(named), list(named.values())
    rows = np.arange(len(lanes))
    found = np.stack(table.project(rows, points), axis=2)
    for row, lane in enumerate(lanes):
        expected = np.array([lane.local_coordinates(point) for point in points])
        np.testing.assert_allclose(found[row], expected, atol=1e-9)
        own = np.transpose(table.own_places(np.full(20, row), points))
        np.testing.assert_array_equal(own, expected)  # each by itself, to the last bit
    on_it = {
        name: [
            (number, pytest.approx(lane.local_coordinates(point)[0]))
            for number, point in enumerate(points)
            if lane.on_lane(point, margin=1.0)
        ]
        for name, lane in named.items()
    }
    for some in (points, points[:0]):
        found_on = table.who_is_on(table.may_hold(some), some)
        assert found_on == ({name: who for name, who in on_it.items() if who} if len(some) else {})


@pytest.mark.parametrize("road", ["highway", "intersection"])
def test_cars_move_as_highway_envs_do(road: str) -> None:
    """The bicycle of all cars at once is `Vehicle.step` of each, to the last bit."""
    traffic = HighwayTraffic(road, cars=12, wander=1.0, crashes="label")
    traffic.reset_live(np.random.default_rng(3))
    for _ in range(20):
        traffic.step()
    assert traffic._simulation is not None
    cars = traffic._simulation.road.vehicles
    traffic._simulation.road.act()
    alone = []
    for car in cars:
        one = copy(car)
        one.position, one.action = car.position.copy(), dict(car.action)
        one.on_state_update = lambda: None  # type: ignore[method-assign]
        Vehicle.step(one, TICK_SECONDS)
        alone.append((*one.position, one.heading, one.speed))
    traffic._simulation.road.step(TICK_SECONDS)
    moved = [(*car.position, car.heading, car.speed) for car in cars]
    np.testing.assert_array_equal(moved, alone)
    places = [car.lane.local_coordinates(car.position) for car in cars]
    np.testing.assert_array_equal([(car.along, car.aside) for car in cars], places)


def run(steps: int) -> list[np.ndarray]:
    traffic = HighwayTraffic("highway", cars=14, arrivals=0.5, crashes="label")
    states = [traffic.reset(np.random.default_rng(3))]
    states += [traffic.step() for _ in range(steps)]
    return [np.column_stack((state.ids, state.x, state.y, state.heading)) for state in states]


@pytest.mark.slow
def test_the_fast_search_gives_the_trajectories_of_highway_envs_own(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    fast, asked = run(50), []

    def slow(road: CarRoad, vehicle: Any, lane_index: Any = None) -> Any:
        asked.append(vehicle)
        return Road.neighbour_vehicles(road, vehicle, lane_index)

    monkeypatch.setattr(CarRoad, "neighbour_vehicles", slow)
    for one, other in zip(fast, run(50), strict=True):
        np.testing.assert_array_equal(one, other)
    assert len(asked) > 1000


def test_a_car_is_as_long_as_it_is_told_and_its_diagonal_follows() -> None:
    road = CarRoad(ROADS["street"](), np.random.default_rng(0))
    car = Car(road, 1, (4.0, 1.5, 3.0), (0, 0), (0, 30.0), 5.0, 1.0)
    assert car.diagonal == 5.0
    assert (car.LENGTH, car.WIDTH) == (4.0, 3.0)
    assert np.ptp(car.polygon()[:, 0]) == pytest.approx(4.0)
