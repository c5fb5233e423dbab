"""A van stands in our lane before an intersection: we pass it on the other side of the road."""

import numpy as np

from mot_sim.simulation.cars import Models, VehicleSampler
from mot_sim.simulation.scene import Scene
from mot_sim.simulation.traffic import Improvised, Roads, Route, Script, Scripted
from mot_sim.simulation.traffic.roads import rectangle
from mot_sim.simulation.traffic.scripted import SEDAN_SIZE
from scenes.junction import (
    ENDS_METRES,
    LANE_METRES,
    LINE_METRES,
    Closed,
    crossing_roads,
    flow,
    from_left,
    from_right,
    lane_offset,
    oncoming,
    passing,
    require_between,
    size_of,
    stop_and_go,
)

EGO_METRES = 100.0  # before the middle, where we begin
VAN_METRES = 42.0  # before the middle, the middle of the first van
BEHIND_METRES = 8.0  # from where we wait to the van's rear
PASSING_Y = -1.4  # of our middle beside the van
SWERVE_METRES = 10.0  # along the road from one lane to the other
SWERVE_RADIUS = 16.0  # metres
WAIT_METRES = LANE_METRES + LINE_METRES + 0.5 * SEDAN_SIZE[0]  # before the middle, at the line
APPROACH_SPEED = 8.0  # m/s
BAYS = (-95.0, -22.0)  # x between which cars are parked at both kerbs
BAY_METRES = 2.3
BEYOND_METRES = {"pavement": 2.6, "kerb": 0.15, "asphalt": 0.0}  # how far paint reaches around them
PITCH_METRES = 6.4  # from one parked car to the next


def intersection_double_parked(
    *,
    vans: int = 1,
    rate: float = 0.3,
    speed: float = 10.0,
    patience: float = 9.0,
    parked: float = 0.8,
    alike: float = 0.0,
    frames: int = 260,
) -> Scene:
    """One lane each way: vans in our lane hide who comes towards us and who crosses behind.

    Scripted: nobody reacts to our car.

    vans: that stand in our lane one behind the other, 1 or 2.
    rate: cars per second in each other lane, 0 to 0.5.
    speed: of these cars in m/s, 6 to 14.
    patience: seconds until we pass the vans, 9 to 30; as long again after them we cross.
    parked: share of the parking places at the kerbs that are taken, 0 to 1.
    alike: share of the car models that look the same, 0 to 1.
    frames: length of the run in frames, at 10 Hz.
    """
    name = "intersection_double_parked"
    require_between(
        name, vans=(float(vans), 1.0, 2.0), rate=(rate, 0.0, 0.5), speed=(speed, 6.0, 14.0),
        patience=(patience, 9.0, 30.0), parked=(parked, 0.0, 1.0),
    )  # fmt: skip

    def script(rng: np.random.Generator, models: Models) -> Scripted:
        first = patience + rng.uniform(-0.4, 0.4)
        second, seconds = first + 12.5 + rng.uniform(0.0, 2.0), 0.1 * frames
        length = models.van_size[0]
        rear = VAN_METRES + (vans - 0.5) * (length + 1.0)  # before the middle, of the last van
        wait = rear + BEHIND_METRES + 0.5 * SEDAN_SIZE[0]
        beside = Closed(
            (ENDS_METRES + VAN_METRES - 0.5 * length - 12.0, ENDS_METRES + wait + 2.0),
            (first + 0.5, first + 9.5),
        )
        crossed = Closed((ENDS_METRES - 6.0, ENDS_METRES + 6.0), (second + 0.5, second + 6.0))
        cars = flow(rng, models, oncoming(0), rate, speed, seconds, [beside])
        middle = ENDS_METRES - LANE_METRES - 0.5, ENDS_METRES + LANE_METRES + 0.5
        across = [crossed, *passing(cars, middle, LANE_METRES)]
        for way in (from_left(0), from_right(0)):
            cars += flow(rng, models, way, rate, speed, seconds, across)
        cars += [
            _standing(-VAN_METRES - number * (length + 1.0), 2.3, models.van_size, "Van")
            for number in range(vans)
        ]
        cars += _parked(rng, models, parked)
        way = _way(wait, VAN_METRES - 0.5 * length)
        line = way.length - ENDS_METRES - WAIT_METRES
        stops = [(EGO_METRES - wait, first), (line, second)]
        return Scripted(cars, Script(way, stop_and_go(APPROACH_SPEED, stops)))

    def traffic(models: Models) -> Improvised:
        return Improvised(lambda rng: script(rng, models))

    return Scene(name, traffic, frames, _roads(), vehicle_sampler=VehicleSampler(alike=alike))


def _way(wait: float, front: float) -> Route:
    """Round the vans; wait, front: metres before the middle of where we wait and of their end."""
    ours, out, back = lane_offset(0), -wait + 1.0, -front + 3.0
    points = [
        (-EGO_METRES, ours), (out, ours), (out + SWERVE_METRES, PASSING_Y), (back, PASSING_Y),
        (back + SWERVE_METRES, ours), (ENDS_METRES, ours),
    ]  # fmt: skip
    return Route(points, SWERVE_RADIUS)


def _standing(x: float, y: float, size: tuple[float, float, float], kind: str = "Car") -> Script:
    """A car that never moves; y < 0: it looks towards us."""
    ahead = 1.0 if y > 0.0 else -1.0
    return Script(Route([(x, y), (x + ahead, y)]), [(0.0, 0.0)], size=size, kind=kind)


def _parked(rng: np.random.Generator, models: Models, share: float) -> list[Script]:
    """Cars in the bays on both sides."""
    cars = []
    for x in np.arange(BAYS[0] + 4.0, BAYS[1] - 3.0, PITCH_METRES).tolist():
        for side in (-1.0, 1.0):
            size, is_taken = size_of(rng, models), rng.uniform() < share
            if is_taken:
                y = side * (LANE_METRES + 0.25 + 0.5 * size[2])
                cars.append(_standing(x + rng.uniform(-0.3, 0.3), y, size))
    return cars


def _roads() -> Roads:
    """The crossing, and bays at our kerbs."""
    found = []
    for surface in crossing_roads(1, 1).surfaces:
        beyond = BEYOND_METRES.get(surface.paint)
        if beyond is not None:
            x = BAYS[0] - beyond, BAYS[1] + beyond
            y = LANE_METRES - 0.1, LANE_METRES + BAY_METRES + beyond
            found += [
                rectangle(surface.paint, x, y),
                rectangle(surface.paint, x, (-y[1], -y[0])),
            ]
        found.append(surface)
    return Roads(tuple(found))
