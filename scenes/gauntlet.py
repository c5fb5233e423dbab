"""An occlusion gauntlet: cars cross before us, behind a row of parked vans with gaps.

Our road (along x) ends at a car park's exit; the cross road (along y) has two lanes each way.
Between us and it stands the row of vans. All cars of a lane have one speed, so nobody touches.
"""

import numpy as np

from mot_sim.simulation.cars import Models, VehicleSampler
from mot_sim.simulation.scene import Scene
from mot_sim.simulation.traffic import Improvised, Roads, Route, Script, Scripted
from mot_sim.simulation.traffic.roads import rectangle, stripe
from tracker.errors import BadConfig

LANE_METRES = 3.5  # metres
LANES_X = (36.0, 39.5, 43.0, 46.5)  # x of the lanes; the first two lead to the right
VAN_ROW_X = 29.0  # x of the vans
CROSS_ROAD_ENDS_Y = (-140.0, 140.0)  # y of the cross road
CAR_PARK_METRES = 36.0  # metres to each side that the car park reaches


def gauntlet(
    *,
    rate: float = 0.35,
    speed: float = 9.0,
    vans: int = 5,
    gap: float = 3.0,
    alike: float = 0.0,
    frames: int = 200,
) -> Scene:
    """Cars cross behind parked vans.

    rate: cars per second in each lane, 0 to 0.6.
    speed: speed of the slowest lane in m/s, 4 to 20; the other lanes are faster.
    vans: vans in the row, 0 to 8.
    gap: metres between two vans, 0.5 to 10.
    alike: share of the car models that look the same, 0 to 1.
    frames: length of the run in frames, at 10 Hz.
    """
    if not 0.0 <= rate <= 0.6:
        raise BadConfig(f"rate of the gauntlet is {rate:g}: give 0 to 0.6 cars a second and lane")
    if not 4.0 <= speed <= 20.0:
        raise BadConfig(f"speed of the gauntlet is {speed:g}: give 4 to 20 m/s")
    if not 0 <= vans <= 8 or not 0.5 <= gap <= 10.0:
        raise BadConfig(f"{vans} vans with gaps of {gap:g} m: give 0 to 8, and 0.5 to 10 m")

    def traffic(models: Models) -> Improvised:
        return Improvised(lambda rng: _script(rng, models, rate, speed, vans, gap, 0.1 * frames))

    return Scene("gauntlet", traffic, frames, _roads(), vehicle_sampler=VehicleSampler(alike=alike))


def _script(
    rng: np.random.Generator,
    models: Models,
    rate: float,
    speed: float,
    vans: int,
    gap: float,
    seconds: float,
) -> Scripted:
    """The row of vans, and cars in every lane as they come; we roll towards them slowly."""
    row = models.van_size[0] + gap
    start = -0.5 * row * (vans - 1) + rng.uniform(-1.0, 1.0)
    cars = [
        Script(_standing(start + row * number), [(0.0, 0.0)], size=models.van_size, kind="Van")
        for number in range(vans)
    ]
    for lane, x in enumerate(LANES_X):
        first, last = CROSS_ROAD_ENDS_Y if lane < 2 else CROSS_ROAD_ENDS_Y[::-1]
        pace = speed * (1.0 + 0.25 * (lane % 2)) * rng.uniform(0.95, 1.05)
        # Places along the lane at time 0, some of them before its beginning: those come later.
        place, before = CROSS_ROAD_ENDS_Y[1] - CROSS_ROAD_ENDS_Y[0], 0.0
        while rate > 0.0 and place > -pace * seconds:
            length, height, width = models.size[rng.integers(len(models.size))].tolist()
            place -= 0.5 * (before + length) + 3.0 + rng.exponential(pace / rate)
            before = length
            way = Route([(x, first), (x, last)])
            begin, size = max(-place / pace, 0.0), (length, height, width)
            cars.append(Script(way, [(0.0, pace)], start=place, size=size, begin=begin))
    speeds = [(0.0, 1.5), (6.0, 0.0), (10.0, 0.0), (12.0, 0.8)]
    ego = Script(Route([(0.0, 0.0), (60.0, 0.0)]), speeds)
    return Scripted(cars, ego)


def _standing(y: float) -> Route:
    """Where a van of the row stands."""
    return Route([(VAN_ROW_X, y), (VAN_ROW_X, 500.0)])


def _roads() -> Roads:
    """A lane that ends at a car park, and a cross road with four lanes behind the vans' row."""
    near, far = LANES_X[0] - 0.5 * LANE_METRES, LANES_X[-1] + 0.5 * LANE_METRES
    surfaces = [
        rectangle("pavement", (near - 2.5, far + 2.5), CROSS_ROAD_ENDS_Y),
        rectangle("kerb", (near - 0.2, far + 0.2), CROSS_ROAD_ENDS_Y),
        rectangle("asphalt", (near, far), CROSS_ROAD_ENDS_Y),
        rectangle("asphalt", (-40.0, near - 2.5), (-4.5, 4.5)),
        rectangle("asphalt", (VAN_ROW_X - 3.0, near - 2.5), (-CAR_PARK_METRES, CAR_PARK_METRES)),
    ]
    middle = 0.5 * (LANES_X[1] + LANES_X[2])
    surfaces += stripe(
        (middle - 0.15, CROSS_ROAD_ENDS_Y[0]), (middle - 0.15, CROSS_ROAD_ENDS_Y[1]), 0.12
    )
    surfaces += stripe(
        (middle + 0.15, CROSS_ROAD_ENDS_Y[0]), (middle + 0.15, CROSS_ROAD_ENDS_Y[1]), 0.12
    )
    for x in (LANES_X[0] + 0.5 * LANE_METRES, LANES_X[2] + 0.5 * LANE_METRES):
        surfaces += stripe((x, CROSS_ROAD_ENDS_Y[0]), (x, CROSS_ROAD_ENDS_Y[1]), dash=(3.0, 4.5))
    for x in (near + 0.15, far - 0.15):
        surfaces += stripe((x, CROSS_ROAD_ENDS_Y[0]), (x, CROSS_ROAD_ENDS_Y[1]))
    return Roads(tuple(surfaces))
