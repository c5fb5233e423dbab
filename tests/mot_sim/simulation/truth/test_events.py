"""What happens to cars over time."""

import numpy as np

from mot_sim.simulation.traffic import TrafficState
from mot_sim.simulation.truth import EVENTS, Events, find_events
from mot_sim.simulation.truth.events import hidings
from tests.mot_sim.simulation.truth.states import state_of, truth_of


def rows(events: Events) -> list[tuple]:
    columns = (events.frames, events.kinds, events.ids, events.others)
    return list(zip(*(column.tolist() for column in columns), strict=True))


def drive(*frames: list[tuple[float, float, float]]) -> list[TrafficState]:
    return [state_of(*cars, time=0.1 * frame) for frame, cars in enumerate(frames)]


def found(states: list[TrafficState]) -> list[tuple]:
    return rows(find_events(truth_of(*states), states))


def test_a_car_enters_and_leaves() -> None:
    ahead, behind = [(20.0, 0.0, 0.0)], [(-20.0, 0.0, 0.0)]
    assert found(drive(behind, ahead, ahead, behind, ahead)) == [
        (1, "enter", 0, -2),
        (3, "leave", 0, -2),
        (4, "enter", 0, -2),
    ]


def test_a_car_that_passes_behind_another_is_hidden_and_crosses_it() -> None:
    def frame(y: float) -> list[tuple[float, float, float]]:
        return [(12.0, 0.0, 0.0), (26.0, y, np.pi / 2)]

    events = found(drive(*(frame(y) for y in (-9.0, -4.0, -0.5, 0.5, 4.0, 9.0))))
    assert (2, "occlusion begins", 1, -2) in events
    assert (4, "occlusion ends", 1, -2) in events
    assert [row for row in events if row[1] == "crossing"] == [(3, "crossing", 0, 1)]
    assert not [row for row in events if row[1] == "leave"]


def test_cars_that_drive_into_each_other_collide_once() -> None:
    apart, touching = [(20.0, 0.0, 0.0), (26.0, 0.0, 0.0)], [(20.0, 0.0, 0.0), (23.0, 0.0, 0.0)]
    events = found(drive(apart, touching, touching, apart))
    assert [row for row in events if row[1] == "collision"] == [(1, "collision", 1, 0)]


def test_a_car_that_drives_into_us_collides_with_the_ego_car() -> None:
    events = found(drive([(9.0, 0.0, np.pi)], [(3.0, 0.0, np.pi)]))
    assert (1, "collision", 0, -1) in events


def test_a_flicker_between_the_bounds_is_one_occlusion() -> None:
    assert hidings([1.0, 0.39, 0.45, 0.38, 0.49, 0.6], list(range(6)), 7) == [
        (1, "occlusion begins", 7, -2),
        (5, "occlusion ends", 7, -2),
    ]


def test_nobody_has_no_events_and_every_kind_is_known() -> None:
    states = drive([], [])
    assert found(states) == []
    assert set(EVENTS) >= {kind for _, kind, _, _ in found(drive([(9.0, 0.0, 0.0)]))}
