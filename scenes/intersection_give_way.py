"""We come to a road that has priority, and turn across what drives there, or cross it."""

import numpy as np

from mot_sim.simulation.cars import Models, VehicleSampler
from mot_sim.simulation.scene import Scene
from mot_sim.simulation.traffic import Improvised, Route, Script, Scripted
from mot_sim.simulation.traffic.scripted import SEDAN_SIZE
from scenes.junction import (
    ENDS_METRES,
    LANE_METRES,
    LINE_METRES,
    PULLING_AWAY,
    Closed,
    crossing_roads,
    flow,
    from_left,
    from_right,
    lane_offset,
    require_between,
    stop_and_go,
)
from tracker.errors import UnknownName

LANES = 2
EGO_METRES = 60.0  # before the middle, where we begin
WAIT_METRES = LANES * LANE_METRES + LINE_METRES + 0.5 * SEDAN_SIZE[0]  # before the middle
APPROACH_SPEED = 9.0  # m/s
CROSSED_METRES = 7.0  # to each side of the middle, where crossing cars would meet us
TURN_SECONDS = 6.0  # from when we go until the turn is done, less what it takes to speed up
# What we may do, and the radius of it in metres and the speed at which it is driven, 32 degrees a
# second; of a way without a turn there is none.
TURNS = {"left": (8.0, 4.5), "right": (6.0, 3.4), "straight": None}


def intersection_give_way(
    *,
    turn: str = "left",
    rate: float = 0.4,
    speed: float = 10.0,
    patience: float = 12.0,
    alike: float = 0.0,
    frames: int = 220,
) -> Scene:
    """Our road ends at one with two lanes each way, whose cars go first and hide one another.

    Scripted: nobody reacts to our car.

    turn: left (across traffic from the left, into that from the right), right, or straight.
    rate: cars per second in each lane of the cross road, 0 to 0.5.
    speed: of these cars in m/s, 6 to 14.
    patience: seconds until there is a gap for us, 10 to 30.
    alike: share of the car models that look the same, 0 to 1.
    frames: length of the run in frames, at 10 Hz.
    """
    name = "intersection_give_way"
    if turn not in TURNS:
        raise UnknownName.of(f"turn of {name}:", turn, TURNS)
    require_between(
        name, rate=(rate, 0.0, 0.5), speed=(speed, 6.0, 14.0), patience=(patience, 10.0, 30.0)
    )

    def script(rng: np.random.Generator, models: Models) -> Scripted:
        go = patience + rng.uniform(-0.5, 0.5)
        way, onward = _way(turn), _onward(turn, speed)
        cars = []
        for lane in range(LANES):
            for side, route in (("left", from_left(lane)), ("right", from_right(lane))):
                closed = _closed(turn, side, lane, go, go + onward[-1][0])
                cars += flow(rng, models, route, rate, speed, 0.1 * frames, closed)
        stop = EGO_METRES - WAIT_METRES, go
        return Scripted(cars, Script(way, stop_and_go(APPROACH_SPEED, [stop], onward)))

    def traffic(models: Models) -> Improvised:
        return Improvised(lambda rng: script(rng, models))

    sampler = VehicleSampler(alike=alike)
    return Scene(name, traffic, frames, crossing_roads(1, LANES), vehicle_sampler=sampler)


def _way(turn: str) -> Route:
    """Where we drive."""
    start, found = (-EGO_METRES, lane_offset(0)), TURNS[turn]
    if found is None:
        return Route([start, (ENDS_METRES, lane_offset(0))])
    x, end = (lane_offset(0), -ENDS_METRES) if turn == "left" else (-lane_offset(1), ENDS_METRES)
    return Route([start, (x, lane_offset(0)), (x, end)], found[0])


def _onward(turn: str, speed: float) -> list[tuple[float, float]]:
    """Seconds from when we go, and our speeds then."""
    found = TURNS[turn]
    if found is None:
        return [(speed / PULLING_AWAY, speed)]
    slow = found[1]
    end = TURN_SECONDS + (speed - slow) / PULLING_AWAY
    return [(slow / PULLING_AWAY, slow), (TURN_SECONDS, slow), (end, speed)]


def _closed(turn: str, side: str, lane: int, go: float, fast: float) -> list[Closed]:
    """What a lane of the cross road keeps free for us; fast: when we are as fast as its cars."""
    crossed = (ENDS_METRES - CROSSED_METRES, ENDS_METRES + CROSSED_METRES)
    joined = (crossed[0], ENDS_METRES + 45.0)  # who comes later stays behind us
    if (turn, side, lane) in (("left", "right", 0), ("right", "left", 1)):
        return [Closed(joined, (go, fast))]
    is_free = (turn == "right") or (turn == "left" and side == "right")
    return [] if is_free else [Closed(crossed, (go + 0.5, go + 7.0))]
