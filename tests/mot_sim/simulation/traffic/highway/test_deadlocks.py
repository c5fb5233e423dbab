"""Who waits for one another gets away again."""

import numpy as np

from mot_sim.simulation.traffic.highway import ROADS
from mot_sim.simulation.traffic.highway.car import Car
from mot_sim.simulation.traffic.highway.layout import Layout, Segment
from mot_sim.simulation.traffic.highway.road import CarRoad

TICK = 0.05
SIZE = (4.4, 1.45, 1.8)


def put(
    road: CarRoad, number: int, segments: tuple[Segment, ...], along: float, lane: int = 0,
    aside: float = 0.0,
) -> Car:  # fmt: skip
    """A car that stands on the first of these segments of its way."""
    layout: Layout = road.layout
    way, leg = next(
        (way, leg)
        for way, path in enumerate(layout.paths)
        for leg in range(len(path))
        if path[leg : leg + len(segments)] == segments
    )
    one = Car(road, number, SIZE, (way, leg), (lane, along), 0.0, 1.0)
    one.position = one.lane.position(along, aside)
    one._note_place()
    road.vehicles.append(one)
    return one


def drive(road: CarRoad, seconds: float) -> None:
    """Let all drive."""
    for _ in range(round(seconds / TICK)):
        road.act()
        road.step(TICK)


def test_two_that_face_each_other_at_the_end_of_a_bend_get_past_each_other() -> None:
    """One has turned into the street in which the other waits at its line, each to its right."""
    road = CarRoad(ROADS["town"](), np.random.default_rng(0))
    turns = (("park line3", "park leave0"), ("park leave0", "park-church 1"))
    turned = put(road, 0, turns, 17.0, aside=-0.22)
    waits = put(road, 1, (("church-park 6", "park line0"),), 39.3, aside=-0.15)
    waits.crashed = True  # it stays where it is
    road.forget()
    assert road.neighbour_vehicles(turned)[0] is waits
    drive(road, 4.0)
    assert turned.path[turned.leg] == turns[0]
    drive(road, 6.0)
    assert turned.path[turned.leg] != turns[0]
    assert not turned.crashed


def test_a_car_that_stands_facing_us_in_our_own_lane_is_waited_for() -> None:
    road = CarRoad(ROADS["town"](), np.random.default_rng(0))
    street = (("park leave0", "park-church 1"),)
    comes = put(road, 0, street, 5.0)
    stands = put(road, 1, street, 16.0)
    stands.heading += np.pi
    stands.held = True
    stands.crashed = True  # it stays where it is
    drive(road, 15.0)
    assert comes.along < stands.along - 4.4
    assert not comes.crashed


def test_who_stands_at_the_end_of_a_lane_leaves_it_when_there_is_a_gap() -> None:
    """Three want to change at once, so near to one another that each was in another's way."""
    road = CarRoad(ROADS["merge"](), np.random.default_rng(0))
    taper = next(
        path[leg] for path in road.layout.paths for leg in range(len(path))
        if path[leg] == ("gore", "taper")
    )  # fmt: skip
    cars = [
        put(road, number, (taper,), along, lane=2)
        for number, along in enumerate((215.8, 209.12, 202.42))
    ]
    cars[1].target_lane_index = (*taper, 1)
    assert road.is_closing(cars[0], (*taper, 2))
    drive(road, 60.0)
    assert all(one.path[one.leg] != taper or one.has_left for one in cars)
    assert not any(one.crashed for one in cars)
