"""An unprotected left turn: we wait for a gap in what comes towards us, behind who waits there."""

import numpy as np

from mot_sim.simulation.cars import Models, VehicleSampler
from mot_sim.simulation.scene import Scene
from mot_sim.simulation.traffic import Improvised, Route, Script, Scripted
from scenes.junction import (
    ENDS_METRES,
    LANE_METRES,
    LINE_METRES,
    TRUCK_SIZE,
    Closed,
    ahead,
    crossing_roads,
    flow,
    from_left,
    from_right,
    lane_offset,
    oncoming,
    queue,
    require_between,
    size_of,
    stop_and_go,
)
from tracker.errors import BadConfig

EGO_METRES = 65.0  # before the middle, where we begin
WAIT_METRES = 7.0  # before the middle, where we wait
OPPOSITE_METRES = 6.5  # behind the middle, where those wait who come towards us and turn left
APPROACH_SPEED = 9.0  # m/s
TURN_RADIUS = 8.0  # metres
# Seconds from when we go and speeds then: the turn is driven at 32 degrees a second.
ONWARD = ((2.5, 4.5), (6.0, 4.5), (9.0, 10.0))


def intersection_left_turn(
    *,
    rate: float = 0.45,
    speed: float = 11.0,
    waiting: int = 3,
    truck: bool = False,
    patience: float = 13.0,
    alike: float = 0.0,
    frames: int = 220,
) -> Scene:
    """Two lanes each way: we turn left across both, and cars come towards us behind who waits.

    Scripted: nobody reacts to our car.

    rate: oncoming cars per second that go straight on, in the outer lane, 0 to 0.6.
    speed: of them in m/s, 6 to 16.
    waiting: cars that come towards us and wait to turn left, 0 to 4: they hide the others.
    truck: whether the first of them is a truck, which hides the lane beside it.
    patience: seconds until there is a gap for us, 11 to 30.
    alike: share of the car models that look the same, 0 to 1.
    frames: length of the run in frames, at 10 Hz.
    """
    name = "intersection_left_turn"
    require_between(
        name, rate=(rate, 0.0, 0.6), speed=(speed, 6.0, 16.0), waiting=(waiting, 0, 4),
        patience=(patience, 11.0, 30.0),
    )  # fmt: skip
    if truck and not waiting:
        raise BadConfig(f"{name}: truck=True with waiting=0: the truck is one of those who wait")

    def script(rng: np.random.Generator, models: Models) -> Scripted:
        go, seconds = patience + rng.uniform(-0.5, 0.5), 0.1 * frames
        cars = _others(
            rng, models, (rate, speed), _line_up(rng, models, waiting, truck), go, seconds
        )
        way = Route(
            [(-EGO_METRES, lane_offset(0)), (lane_offset(0),) * 2, (lane_offset(0), -ENDS_METRES)],
            TURN_RADIUS,
        )
        stop = EGO_METRES - WAIT_METRES, go
        return Scripted(cars, Script(way, stop_and_go(APPROACH_SPEED, [stop], ONWARD)))

    def traffic(models: Models) -> Improvised:
        return Improvised(lambda rng: script(rng, models))

    sampler = VehicleSampler(alike=alike)
    return Scene(name, traffic, frames, crossing_roads(2, 1), vehicle_sampler=sampler)


def _line_up(
    rng: np.random.Generator, models: Models, waiting: int, truck: bool
) -> list[tuple[float, float, float]]:
    """The sizes of those who wait opposite us."""
    sizes = [size_of(rng, models) for _ in range(waiting)]
    return [TRUCK_SIZE, *sizes[1:]] if truck else sizes


def _others(
    rng: np.random.Generator,
    models: Models,
    through: tuple[float, float],
    opposite: list[tuple[float, float, float]],
    go: float,
    seconds: float,
) -> list[Script]:
    """Everybody else; through: rate and speed of who goes straight on."""
    crossed = Closed((ENDS_METRES - 6.0, ENDS_METRES + 3.0), (go + 0.5, go + 6.5))
    line = ENDS_METRES - 2 * LANE_METRES - LINE_METRES
    cars = flow(rng, models, oncoming(1), *through, seconds, [crossed])
    cars += flow(rng, models, ahead(1), *through, seconds)
    cars += queue(oncoming(0), ENDS_METRES - OPPOSITE_METRES, opposite)
    for way in (from_left(0), from_right(0)):
        cars += queue(way, line, [size_of(rng, models) for _ in range(int(rng.integers(2, 5)))])
    return cars
