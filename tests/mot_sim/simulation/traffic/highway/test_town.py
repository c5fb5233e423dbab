"""The town: who has priority, where our car goes by name, and that it gets there."""

import numpy as np
import pytest

from mot_sim.simulation.registry import find_scene
from mot_sim.simulation.scene import record_scene_traffic
from mot_sim.simulation.traffic.highway import ROADS, HighwayTraffic
from mot_sim.simulation.traffic.highway.car import TICK_SECONDS, Car
from mot_sim.simulation.traffic.highway.layout import Layout, Path, Segment
from mot_sim.simulation.traffic.highway.paint import painted
from mot_sim.simulation.traffic.highway.right_of_way import RightOfWay
from mot_sim.simulation.traffic.highway.road import CarRoad
from tracker.errors import BadConfig, UnknownName


@pytest.fixture(scope="module")
def layout() -> Layout:
    return ROADS["town"]()


def metres(layout: Layout, path: Path) -> float:
    return sum(float(layout.network.get_lane((*one, 0)).length) for one in path)


def before(road: CarRoad, number: int, segment: Segment, apart: float, speed: float) -> Car:
    """A car so many metres before the line of a crossing's segment."""
    paths = road.layout.paths
    way = next(row for row, path in enumerate(paths) if segment in path[1:])
    leg = paths[way].index(segment) - 1
    lane = road.network.get_lane((*paths[way][leg], 0))
    place = 0, float(lane.length) - 2.2 - apart
    road.vehicles.append(Car(road, number, (4.4, 1.45, 1.8), (way, leg), place, speed, 1.0))
    return road.vehicles[-1]


def test_routes_last_for_minutes_and_pass_many_junctions(layout: Layout) -> None:
    for path in layout.routes.values():
        assert path in layout.ego.paths
        assert metres(layout, path) > 1800.0
        assert sum(segment in layout.crossings for segment in path) >= 9


@pytest.mark.parametrize(("speed", "waits"), [(10.0, True), (0.0, False)])
def test_who_comes_from_a_side_street_waits_for_who_has_priority(
    layout: Layout, speed: float, waits: bool
) -> None:
    minor, major = ("church line3", "church leave2"), ("church line2", "church leave0")
    assert layout.yields[("church line3", "church leave0")] >= {major}
    road, rules = CarRoad(layout, np.random.default_rng(0)), RightOfWay(layout)
    ours = before(road, 0, ("church line3", "church leave0"), 10.0, 5.0)
    before(road, 1, major, 30.0 if speed else 200.0, speed)
    rules.update(road.vehicles)
    assert ours.held == waits
    assert minor not in layout.yields or major not in layout.yields[minor]


@pytest.mark.parametrize(("seconds", "stops"), [(8.0, False), (21.0, True)])
def test_who_has_priority_stops_only_for_one_who_has_waited_long(
    layout: Layout, seconds: float, stops: bool
) -> None:
    road, rules = CarRoad(layout, np.random.default_rng(0)), RightOfWay(layout)
    waits = before(road, 0, ("church line3", "church leave0"), 1.0, 0.0)
    before(road, 1, ("church line2", "church leave0"), 30.0, 10.0)  # does not ask yet
    for _ in range(round(seconds / TICK_SECONDS)):
        rules.update(road.vehicles)
    assert waits.held
    theirs = before(road, 2, ("church line2", "church leave0"), 15.0, 10.0)
    rules.update(road.vehicles)
    assert theirs.held == stops


def test_only_side_streets_have_lines_and_bends_have_dashes(layout: Layout) -> None:
    lines = [one.corners for one in painted(layout).surfaces if one.paint == "line"]
    middles = np.array([corners.mean(axis=0) for corners in lines])
    for node, is_minor in (("church line3", True), ("church line0", False)):
        index = next(one for one in layout.network.lanes_dict() if one[1] == node)
        lane = layout.network.get_lane(index)
        end = lane.position(float(lane.length) - 0.5, 0.0)
        assert (np.hypot(*(middles - end).T) < 1.0).any() == is_minor
    bent = next(
        lane for index, lane in layout.network.lanes_dict().items()
        if index[:2] not in layout.crossings and hasattr(lane, "radius") and lane.line_types[0] == 1
    )  # fmt: skip
    dash = bent.position(1.5, -0.5 * 3.5 + 0.12)
    assert np.hypot(*(middles - dash).T).min() < 0.05


def test_our_car_takes_the_route_that_it_is_given(layout: Layout) -> None:
    for name in ("loop", "shore"):
        traffic = HighwayTraffic("town", cars=0, arrivals=0.0, route=name)
        traffic.reset_live(np.random.default_rng(1))
        assert traffic._simulation is not None
        assert traffic._simulation.ego.path == layout.routes[name]


@pytest.mark.parametrize(
    ("knobs", "error", "told"),
    [
        ({"route": "lop"}, UnknownName, "'lop'; known: any, errands, loop, .* Did you mean 'loop'"),
        ({"cars": 900, "frames": 2}, BadConfig, "900 cars on the town: it holds"),
        ({"vans": 900, "frames": 2}, BadConfig, "900 parked vans: the kerbs hold"),
        ({"route": "loop", "parked": 1.5}, BadConfig, "it is a share"),
    ],
)
def test_wrong_knobs_are_told(knobs: dict, error: type[Exception], told: str) -> None:
    with pytest.raises(error, match=told):
        record_scene_traffic(find_scene("town", **knobs), 0)


def test_a_road_without_routes_says_so() -> None:
    with pytest.raises(UnknownName, match="route on the street"):
        HighwayTraffic("street", route="loop")


def test_our_car_gets_through_the_town_and_begins_anew() -> None:
    traffic = HighwayTraffic("town", cars=0, arrivals=0.0, continuous=True, crashes="label")
    traffic.reset_live(np.random.default_rng(2))
    for _ in range(3500):
        traffic.step()
        if traffic.ego_ways:
            break
    assert traffic.ego_ways == 1
