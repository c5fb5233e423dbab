"""The scripted intersections: nobody touches anybody, and each holds what it is for."""

from typing import Any

import numpy as np
import pytest

from mot_sim.simulation.cars import VehicleSampler
from mot_sim.simulation.registry import find_scene
from mot_sim.simulation.scene import Rollout, record_scene_traffic
from mot_sim.simulation.traffic import collisions
from mot_sim.simulation.traffic.recording import RecordedTraffic
from mot_sim.simulation.truth import annotate
from scenes.junction import Closed, flow, from_left, queue, stop_and_go, stopping
from tracker.errors import BadConfig, UnknownName

DENSE: dict[str, dict[str, Any]] = {
    "intersection_left_turn": {"rate": 0.6, "speed": 16.0, "waiting": 4, "truck": True},
    "intersection_queues": {"queued": 8, "place": 3, "red": 4.0, "rate": 0.6, "speed": 14.0},
    "intersection_double_parked": {"vans": 2, "rate": 0.5, "speed": 6.0, "parked": 1.0},
    "intersection_give_way": {"turn": "right", "rate": 0.5, "speed": 14.0},
}


def traffic_of(name: str, seed: int = 0, **knobs: float | str | bool) -> RecordedTraffic:
    return record_scene_traffic(find_scene(name, **knobs), seed)


@pytest.mark.parametrize("name", sorted(DENSE))
def test_nobody_touches_anybody_in_the_densest_traffic(name: str) -> None:
    traffic = traffic_of(name, 7, **DENSE[name])
    for index in range(0, len(traffic), 3):
        state = traffic.state(index)
        assert len(collisions(state)) == 0, f"{name} at {state.time:g} s"


@pytest.mark.parametrize(("turn", "degrees"), [("left", -90.0), ("right", 90.0), ("straight", 0.0)])
def test_we_wait_and_turn_across_traffic(turn: str, degrees: float) -> None:
    ego = traffic_of("intersection_give_way", 2, turn=turn).ego
    stands = np.hypot(*np.diff(ego[:, :2], axis=0).T) < 1e-9
    assert stands.sum() > 10
    assert np.degrees(ego[-1, 2]) == pytest.approx(degrees, abs=1.0)
    assert np.degrees(np.abs(np.diff(ego[:, 2])).max() / 0.1) < 35.0


def seen_behind(name: str, **knobs: float | bool) -> float:
    """The mean visible fraction of who comes towards us in the outer lane, before we turn."""
    rollout = Rollout.of(find_scene(name, houses=0.0, trees=0.0, furniture=0.0, **knobs), 1)
    states = rollout.traffic_states[80:120:8]
    truth = annotate(states, rollout.scene_meshes, rollout.scenery_in).truth
    rows = []
    for number, state in enumerate(states):
        through = state.ids[(np.abs(state.y + 5.25) < 0.1) & (state.x > 7.0)]
        is_there = (truth.tracks.frames == number) & np.isin(truth.tracks.ids, through)
        rows += np.flatnonzero(is_there).tolist()
    return float(truth.visible[rows].mean())


def test_a_truck_hides_the_lane_beside_it() -> None:
    free = seen_behind("intersection_left_turn", waiting=0)
    truck = seen_behind("intersection_left_turn", waiting=1, truck=True)
    assert truck < free - 0.15


def test_houses_at_the_corners_hide_who_crosses() -> None:
    shown = []
    for setback in (2.8, 15.0):
        knobs = {"setback": setback, "frames": 46, "houses": 0.0, "trees": 0.0, "furniture": 0.0}
        scene = find_scene("intersection_blind_corner", **knobs)
        assert len(scene.roads.plots) == 4
        rollout = Rollout.of(scene, 1)
        state = rollout.traffic_states[45]
        truth = annotate([state], rollout.scene_meshes, rollout.scenery_in).truth
        crossing = state.ids[(np.abs(state.x) < 7.0) & (np.abs(state.y) > 8.0)]
        shown.append(truth.visible[np.isin(truth.tracks.ids, crossing)])
    assert shown[0].max() < 0.2
    assert shown[1].max() > 0.9


@pytest.mark.parametrize(
    ("name", "knobs", "words"),
    [
        ("intersection_left_turn", {"truck": True, "waiting": 0}, "the truck is one of those"),
        ("intersection_left_turn", {"patience": 3.0}, "patience of .* is 3: give 11 to 30"),
        ("intersection_queues", {"place": 2, "queued": 2}, "place=2 with queued=2"),
        ("intersection_double_parked", {"vans": 0}, "vans of .* is 0: give 1 to 2"),
        ("intersection_blind_corner", {"setback": 0.5}, "setback of .*: give 2.8 to 15"),
        ("intersection_blind_corner", {"cars": 900}, "900 cars on the intersection"),
    ],
)
def test_knobs_that_cannot_be_or_contradict_each_other_are_refused(
    name: str, knobs: dict, words: str
) -> None:
    with pytest.raises(BadConfig, match=words):
        traffic_of(name, **knobs)


def test_an_unknown_turn_is_named_with_the_nearest() -> None:
    with pytest.raises(UnknownName, match=r"unknown turn .*'lefft'.*Did you mean 'left'"):
        find_scene("intersection_give_way", turn="lefft")
    with pytest.raises(UnknownName, match="Did you mean 'intersection_left_turn'"):
        find_scene("intersection_left_turns")


def test_a_closed_part_keeps_cars_away_while_it_is_closed() -> None:
    closed = Closed((100.0, 110.0), (5.0, 8.0))
    assert closed.is_met(60.0, 10.0, 4.0)  # from 3.8 s to 5.2 s it is there
    assert not closed.is_met(70.0, 10.0, 4.0)  # it leaves after 4.2 s
    assert not closed.is_met(10.0, 10.0, 4.0)  # it comes after 8.8 s


def test_a_flow_stops_before_the_line_without_touching() -> None:
    models = VehicleSampler(models=2).models_of(0)
    cars = flow(np.random.default_rng(0), models, from_left(0), 0.5, 10.0, 30.0)
    later = stopping(cars, 120.0, 4.0)
    ends = np.array([car.distance(60.0) + 0.5 * car.size[0] for car in later])
    waits = ends[ends < 200.0]
    assert len(waits) > 3
    assert waits[0] == pytest.approx(120.0)
    assert (np.diff(waits) < -3.0).all()


def test_stops_are_where_and_as_long_as_they_were_asked_for() -> None:
    car = queue(from_left(0), 100.0, [(4.0, 1.5, 1.8)], go=2.0, speed=9.0)[0]
    assert (car.speed(1.9), car.speed(8.0)) == (0.0, 9.0)
    speeds = stop_and_go(8.0, [(40.0, 9.0), (100.0, 22.0)])
    times, values = zip(*speeds, strict=True)
    driven = np.interp(np.arange(0.0, 9.0, 0.001), times, values).sum() * 0.001
    assert driven == pytest.approx(40.0, abs=0.02)
    assert np.interp(21.9, times, values) == 0.0
    with pytest.raises(BadConfig, match="a stop after 10 m until 9 s"):
        stop_and_go(8.0, [(10.0, 9.0)])
