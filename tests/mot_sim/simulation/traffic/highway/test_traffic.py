"""Live traffic: same seed same cars, exact times, sizes kept, nobody through anybody."""

import subprocess
import sys
from itertools import pairwise

import numpy as np
import pytest
from highway_env.vehicle.behavior import IDMVehicle
from highway_env.vehicle.controller import ControlledVehicle
from highway_env.vehicle.kinematics import Vehicle

from mot_sim.simulation.scene import Scene, record_scene_traffic
from mot_sim.simulation.traffic import (
    RecordedTraffic,
    Replay,
    TrafficState,
    collisions,
    record_traffic,
)
from mot_sim.simulation.traffic.highway import ROADS, HighwayTraffic
from tracker.errors import BadConfig, UnknownName

SIZES = np.array([(3.5, 1.4, 1.6), (4.9, 1.7, 1.95)])


def rng(seed: int = 0) -> np.random.Generator:
    return np.random.default_rng(seed)


def drive(traffic: HighwayTraffic, steps: int, seed: int = 0) -> list[TrafficState]:
    return [traffic.reset(rng(seed)), *(traffic.step() for _ in range(steps))]


def small(road: str, cars: int = 6) -> HighwayTraffic:
    return HighwayTraffic(road, cars=cars, arrivals=0.4, parked=0.3, sizes=SIZES, crashes="label")


@pytest.mark.parametrize("road", ROADS)
def test_the_same_seed_gives_the_same_bytes_and_another_seed_others(road: str) -> None:
    first = record_traffic(small(road), rng(1), 2.0).checksum
    assert record_traffic(small(road), rng(1), 2.0).checksum == first
    assert record_traffic(small(road), rng(2), 2.0).checksum != first


@pytest.mark.parametrize("road", ROADS)
def test_worlds_are_sound(road: str) -> None:
    states = drive(small(road), 60)
    size_of: dict[int, tuple[float, ...]] = {}
    for step, state in enumerate(states):
        assert state.time == step * 0.1
        assert (np.diff(state.ids) > 0).all()
        for number, size in zip(state.ids.tolist(), state.size.tolist(), strict=True):
            assert size_of.setdefault(number, tuple(size)) == tuple(size)
        assert (state.speed >= -1e-12).all()
        assert not len(collisions(state))
    assert set(size_of.values()) <= set(map(tuple, SIZES.tolist()))


@pytest.mark.parametrize("road", ROADS)
def test_a_car_moves_as_fast_as_it_says(road: str) -> None:
    states = drive(small(road), 40)
    for before, now in pairwise(states):
        known, a, b = np.intersect1d(before.ids, now.ids, return_indices=True)
        moved = np.hypot(now.x[b] - before.x[a], now.y[b] - before.y[a])
        mean = 0.5 * (before.speed[a] + now.speed[b])
        np.testing.assert_allclose(moved, 0.1 * mean, atol=0.03)
        assert len(known)


def test_cars_keep_to_the_right_hand_lane_of_a_street() -> None:
    for state in drive(small("street"), 60):
        moving = state.speed > 0.1
        side = np.where(np.cos(state.heading) > 0, state.y, -state.y)
        np.testing.assert_allclose(side[moving], 1.75, atol=0.05)
        assert (side[state.speed == 0.0] > 1.7).all()


@pytest.mark.slow
def test_turning_cars_stay_near_the_middle_of_their_lanes() -> None:
    traffic = small("roundabout", cars=8)
    aside = [0.0]
    traffic.reset(rng(4))
    for _ in range(150):
        traffic.step()
        assert traffic._simulation is not None
        aside += [abs(car.aside) for car in traffic._simulation.road.vehicles]
    assert max(aside) < 0.6


@pytest.mark.slow
def test_cars_get_through_the_junctions() -> None:
    for road in ("intersection", "roundabout"):
        traffic = HighwayTraffic(road, cars=8, arrivals=0.2, parked=0.0, crashes="label")
        states = drive(traffic, 250)
        assert len(np.setdiff1d(states[0].ids, states[-1].ids)) >= 4
        assert np.hypot(*states[-1].ego[:2]) > 30.0


@pytest.mark.slow
def test_cars_come_by_simulated_time() -> None:
    traffic = HighwayTraffic("street", cars=0, arrivals=0.5, parked=0.0, crashes="label")
    count = np.unique(np.concatenate([state.ids for state in drive(traffic, 300)]))
    assert 8 <= len(count) <= 22  # 15 expected in 30 s


def test_a_road_without_cars_has_only_ours() -> None:
    states = drive(HighwayTraffic("intersection", cars=0, arrivals=0.0, parked=0.0), 10)
    assert all(len(state) == 0 and state.size.shape == (0, 3) for state in states)
    assert states[-1].ego[0] > states[0].ego[0] + 5.0


def test_a_replay_equals_the_live_traffic() -> None:
    replay = Replay(record_traffic(small("intersection"), rng(), 1.0))
    live, again = drive(small("intersection"), 10), [replay.reset(rng())]
    again += [replay.step() for _ in range(10)]
    assert RecordedTraffic.of(live).checksum == RecordedTraffic.of(again).checksum
    assert [state.time for state in live] == [state.time for state in again]


def test_a_run_ends_where_our_cars_road_does_and_a_longer_scene_is_told(
    caplog: pytest.LogCaptureFixture,
) -> None:
    traffic = HighwayTraffic("street", 0, 0.0, 0.0, clean_seconds=0.0)
    scene = Scene("street", lambda models: traffic, 600)
    states = record_scene_traffic(scene, 0).states
    assert 300 < len(states) < 600
    assert states[-1].ego[0] <= 500.0 < states[-1].ego[0] + 1.2
    assert f"ends after {len(states)} frames; 600 were asked for" in caplog.text


def test_our_car_leaves_the_road_at_its_end_or_begins_a_new_way() -> None:
    ends, goes_on = (
        HighwayTraffic("street", 0, 0.0, 0.0, continuous=continuous) for continuous in (False, True)
    )
    for traffic in (ends, goes_on):
        traffic.reset_live(rng())
        for _ in range(160):
            traffic.command("faster")
            state = traffic.step()
            if traffic.has_ended:
                break
    assert ends.has_ended
    assert not ends.driving().on_road
    assert (goes_on.has_ended, goes_on.ego_ways) == (False, 1)
    assert goes_on.driving().on_road
    assert abs(state.ego[1]) == 1.75


def test_parked_vans_stand_nearest_to_the_junction() -> None:
    state = HighwayTraffic("intersection", cars=0, arrivals=0.0, parked=1.0, vans=2).reset(rng())
    from_middle = np.hypot(state.x, state.y)
    is_van = state.size[:, 0] == 5.4
    assert is_van.sum() == 2
    assert from_middle[is_van].max() < from_middle[~is_van].min() + 1.0
    assert not len(collisions(state))


def test_no_other_environment_changes_the_drivers(monkeypatch: pytest.MonkeyPatch) -> None:
    before = record_traffic(small("merge"), rng(), 2.0).checksum
    # What IntersectionEnv and others set on the classes, and worse.
    for name in ("DISTANCE_WANTED", "COMFORT_ACC_MAX", "TIME_WANTED", "DELTA", "ACC_MAX"):
        monkeypatch.setattr(IDMVehicle, name, 7.0)
    monkeypatch.setattr(IDMVehicle, "COMFORT_ACC_MIN", -3.0)
    for name in ("TAU_HEADING", "KP_LATERAL", "KP_HEADING", "MAX_STEERING_ANGLE"):
        monkeypatch.setattr(ControlledVehicle, name, 0.3)
    for name in ("LENGTH", "WIDTH", "MAX_SPEED"):
        monkeypatch.setattr(Vehicle, name, 3.0)
    assert record_traffic(small("merge"), rng(), 2.0).checksum == before


def test_two_traffics_side_by_side_do_not_know_each_other() -> None:
    alone = drive(small("street"), 10)
    one, other = small("street"), small("intersection")
    states = [one.reset(rng())]
    other.reset(rng(5))
    for _ in range(10):
        other.step()
        states.append(one.step())
    assert RecordedTraffic.of(states).checksum == RecordedTraffic.of(alone).checksum


def test_a_run_with_a_crash_is_drawn_anew_or_labelled(monkeypatch: pytest.MonkeyPatch) -> None:
    labelled = HighwayTraffic("highway", cars=20, crashes="label")
    labelled.reset(rng())
    assert labelled._simulation is not None
    first, second = labelled._simulation.road.vehicles[1:3]
    first.position = second.position.copy()
    state = labelled.step()
    assert state.crashed is not None
    assert {first.number, second.number} <= set(state.ids[state.crashed].tolist())
    assert all(car.speed < 30.0 for car in (first, second))

    tries: list[int] = []
    simulation = type(labelled._simulation)
    monkeypatch.setattr(
        simulation,
        "has_crashed",
        property(lambda run: not tries.append(run.seed) and len(tries) < 3),
    )
    clean = HighwayTraffic("street", cars=2, parked=0.0, clean_seconds=0.2)
    clean.reset(rng())
    assert len(set(tries)) == 3
    again = list(tries)
    tries.clear()
    clean.reset(rng())
    assert tries == again


def test_traffic_that_always_crashes_gives_up(monkeypatch: pytest.MonkeyPatch) -> None:
    traffic = HighwayTraffic("street", cars=1, parked=0.0, clean_seconds=0.1)
    simulation = HighwayTraffic("street", cars=0, parked=0.0, clean_seconds=0.0)
    simulation.reset(rng())
    monkeypatch.setattr(type(simulation._simulation), "has_crashed", True)
    with pytest.raises(BadConfig, match=r"crashed within 0\.1 s in all of 20 attempts"):
        traffic.reset(rng())


@pytest.mark.parametrize(
    ("changes", "told"),
    [
        ({"road": "roundabuot"}, "unknown road 'roundabuot'.*Did you mean 'roundabout'"),
        ({"crashes": "lable"}, "Did you mean 'label'"),
        ({"cars": -1}, "cars of the traffic is -1: give 0 or more"),
        ({"arrivals": -0.5}, "arrivals of the traffic is -0.5"),
        ({"arrivals": float("nan")}, "arrivals of the traffic is nan"),
        ({"vans": -2}, "vans of the traffic is -2"),
        ({"parked": 1.5}, "parked is 1.5: it is a share"),
        ({"sizes": np.zeros((0, 3))}, "give one or more"),
        ({"sizes": np.array([(4.0, 1.5, -1.8)])}, "positive"),
        ({"sizes": np.array([(18.0, 4.0, 2.5)])}, "at most 8 m long"),
    ],
)
def test_bad_parameters_are_told(changes: dict[str, object], told: str) -> None:
    with pytest.raises((BadConfig, UnknownName), match=told):
        HighwayTraffic(**changes)  # type: ignore[arg-type]


def test_more_cars_than_the_road_holds_are_told() -> None:
    with pytest.raises(BadConfig, match=r"500 cars on the intersection: it holds \d+ of 4.85 m"):
        HighwayTraffic("intersection", cars=500).reset(rng())
    with pytest.raises(BadConfig, match="3 parked vans: the kerbs hold 0"):
        HighwayTraffic("highway", vans=3).reset(rng())


def test_a_step_before_reset_is_told() -> None:
    with pytest.raises(BadConfig, match="call reset"):
        HighwayTraffic("street").step()


PROCESS = """
import numpy as np
from mot_sim.simulation.traffic import record_traffic
from mot_sim.simulation.traffic.highway import HighwayTraffic
traffic = HighwayTraffic("roundabout", cars=8, crashes="label")
print(record_traffic(traffic, np.random.default_rng(5), 3.0).checksum)
"""


@pytest.mark.slow
def test_two_processes_give_the_same_bytes() -> None:
    command = [sys.executable, "-c", PROCESS]
    runs = [
        subprocess.run(command, capture_output=True, text=True, check=True, timeout=120).stdout
        for _ in range(2)
    ]
    assert runs[0] == runs[1]
    assert len(runs[0].strip()) == 64


@pytest.mark.slow
@pytest.mark.parametrize("road", ROADS)
def test_nobody_drives_through_anybody_in_dense_traffic(road: str) -> None:
    traffic = HighwayTraffic(road, cars=16, arrivals=0.7, clean_seconds=12.0)
    for seed in range(2):
        for state in drive(traffic, 120, seed):
            assert not len(collisions(state))
            assert state.crashed is not None
            assert not state.crashed.any()
