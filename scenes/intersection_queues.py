"""Queues at lights: cars that cross and cars that wait hide those behind them."""

import numpy as np

from mot_sim.simulation.cars import Models, VehicleSampler
from mot_sim.simulation.scene import Scene
from mot_sim.simulation.traffic import Improvised, Scripted
from mot_sim.simulation.traffic.scripted import SEDAN_SIZE
from scenes.junction import (
    ENDS_METRES,
    LANE_METRES,
    LINE_METRES,
    Size,
    ahead,
    crossing_roads,
    flow,
    from_left,
    from_right,
    oncoming,
    queue,
    require_between,
    size_of,
    stopping,
)
from tracker.errors import BadConfig

LANES = 2
LINE = ENDS_METRES - LANES * LANE_METRES - LINE_METRES  # metres along every way to its line
CLEAR_SECONDS = 4.5  # from when the last cars cross until the others go


def intersection_queues(
    *,
    queued: int = 5,
    place: int = 1,
    red: float = 9.0,
    rate: float = 0.4,
    speed: float = 10.0,
    alike: float = 0.0,
    frames: int = 220,
) -> Scene:
    """Two lanes each way at lights: others cross, then they queue, and the queues go.

    Scripted: nobody reacts to our car.

    queued: cars that wait in each lane of our road, 1 to 8.
    place: how many of them are before us in our lane, 0 to 3, fewer than queued.
    red: seconds until the lights change, 3 to 60.
    rate: cars per second that cross in each lane, 0 to 0.6.
    speed: of all cars in m/s, 6 to 14.
    alike: share of the car models that look the same, 0 to 1.
    frames: length of the run in frames, at 10 Hz.
    """
    name = "intersection_queues"
    require_between(
        name, queued=(queued, 1, 8), place=(place, 0, 3), red=(red, 3.0, 60.0),
        rate=(rate, 0.0, 0.6), speed=(speed, 6.0, 14.0),
    )  # fmt: skip
    if place >= queued:
        raise BadConfig(
            f"{name}: place={place} with queued={queued}: we are one of those who wait; give fewer "
            "before us, or more in the queue"
        )

    def script(rng: np.random.Generator, models: Models) -> Scripted:
        cars, go = [], red + CLEAR_SECONDS
        for lane in range(LANES):
            for way in (from_left(lane), from_right(lane)):
                crossing = flow(rng, models, way, rate, speed, 0.1 * frames)
                cars += stopping(crossing, LINE, red)
        for way in (oncoming(0), oncoming(1), ahead(1)):
            cars += queue(way, LINE, _sizes(rng, models, queued), go, speed)
        ours = queue(ahead(0), LINE, _sizes(rng, models, queued, place), go, speed)
        ego = ours.pop(place)
        return Scripted([*cars, *ours], ego)

    def traffic(models: Models) -> Improvised:
        return Improvised(lambda rng: script(rng, models))

    sampler = VehicleSampler(alike=alike)
    return Scene(name, traffic, frames, crossing_roads(LANES, LANES), vehicle_sampler=sampler)


def _sizes(
    rng: np.random.Generator, models: Models, count: int, place: int | None = None
) -> list[Size]:
    """The sizes of the cars of a queue; place: of ours in it."""
    sizes = [size_of(rng, models) for _ in range(count)]
    if place is not None:
        sizes[place] = SEDAN_SIZE
    return sizes
