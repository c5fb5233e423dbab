"""A four-way crossing by script: waiting behind a car, cross traffic, one car hidden by a van.

The junction is where our road (along x) meets the cross road (along y, two lanes each way).
Traffic keeps to the right: x forward, y right, so we drive at y > 0 and cars that come from
the left drive at the smaller x. Nobody touches anybody (a test).
"""

from mot_sim.simulation.cars import Models
from mot_sim.simulation.scene import Scene
from mot_sim.simulation.traffic import Roads, Route, Script, Scripted
from mot_sim.simulation.traffic.roads import rectangle, stripe, zebra

LANE_METRES = 3.5  # metres
OUR_LANE_Y = 0.5 * LANE_METRES
ONCOMING_LANE_Y = -0.5 * LANE_METRES
FROM_LEFT_X = 48.25  # lanes of the cross road
FROM_LEFT_INNER_X = 51.75
FROM_RIGHT_INNER_X = 55.25
FROM_RIGHT_X = 58.75
NEAR_KERB_X = 46.5  # edges of the cross road
FAR_KERB_X = 60.5
PARKED_Y = 5.0  # y of the parking bay
ROAD_ENDS_X = (-60.0, 200.0)  # x of our road
CROSS_ROAD_ENDS_Y = (-90.0, 90.0)  # y of the cross road

VAN_SIZE = (5.4, 2.3, 2.0)  # length, height, width
SMALL_SIZE = (3.7, 1.5, 1.65)
ESTATE_SIZE = (4.7, 1.5, 1.82)
SUV_SIZE = (4.6, 1.75, 1.9)

EGO = Script(
    Route([(2.0, OUR_LANE_Y), (160.0, OUR_LANE_Y)]),
    speeds=[(0.0, 8.0), (1.5, 8.0), (5.5, 0.0), (9.6, 0.0), (14.0, 6.0)],
)


def across(
    lane: float, to_right: bool, start: float, speed: float, size: tuple[float, float, float]
) -> Script:
    """A car that crosses our road in one lane; start: its y at time 0."""
    first, last = CROSS_ROAD_ENDS_Y if to_right else CROSS_ROAD_ENDS_Y[::-1]
    return Script(
        Route([(lane, first), (lane, last)]),
        [(0.0, speed)],
        start=abs(start - first),
        size=size,
        kind="Van" if size == VAN_SIZE else "Car",
    )


CARS = (
    # Leads us to the stop line, waits for the cross traffic, and goes on.
    Script(
        Route([(19.5, OUR_LANE_Y), (160.0, OUR_LANE_Y)]),
        speeds=[(0.0, 8.0), (1.0, 8.0), (4.0, 0.0), (9.0, 0.0), (14.0, 8.0)],
    ),
    # The van hides the faster small car beside it for more than a second.
    across(FROM_LEFT_X, True, -18.0, 6.0, VAN_SIZE),
    across(FROM_LEFT_INNER_X, True, -25.5, 10.0, SMALL_SIZE),
    across(FROM_LEFT_X, True, -33.0, 6.5, ESTATE_SIZE),
    across(FROM_RIGHT_INNER_X, False, 30.0, 9.0, SUV_SIZE),
    across(FROM_RIGHT_X, False, 40.0, 9.0, (4.3, 1.45, 1.8)),
    # Comes towards us and turns left in front of us, into the inner lane.
    Script(
        Route(
            [
                (95.0, ONCOMING_LANE_Y),
                (FROM_LEFT_INNER_X, ONCOMING_LANE_Y),
                (FROM_LEFT_INNER_X, CROSS_ROAD_ENDS_Y[1]),
            ],
            6.5,
        ),
        speeds=[(0.0, 6.5), (4.0, 5.0), (7.0, 6.0), (10.0, 9.0)],
        size=SMALL_SIZE,
    ),
    # Two more come towards us behind that one, go straight on and pass us.
    Script(
        Route([(118.0, ONCOMING_LANE_Y), (ROAD_ENDS_X[0], ONCOMING_LANE_Y)]),
        speeds=[(0.0, 7.0), (5.0, 6.5), (8.0, 8.0)],
        size=ESTATE_SIZE,
    ),
    Script(
        Route([(141.0, ONCOMING_LANE_Y), (ROAD_ENDS_X[0], ONCOMING_LANE_Y)]),
        speeds=[(0.0, 7.0), (5.0, 6.5), (8.0, 8.0)],
        size=SUV_SIZE,
    ),
    # Parked at the kerb: we stop beside it.
    Script(Route([(28.5, PARKED_Y), (35.0, PARKED_Y)]), [(0.0, 0.0)], size=SUV_SIZE),
)


def _roads() -> Roads:
    """Pavements, asphalt, lane marks, stop lines and zebra crossings."""
    edge, side = LANE_METRES, 2.5  # of our road, and how wide a pavement is
    bay = (8.0, 40.0)  # x of the parking bay
    stop_near, stop_far = NEAR_KERB_X - 4.5, FAR_KERB_X + 4.5
    arms = (ROAD_ENDS_X[0], stop_near), (stop_far, ROAD_ENDS_X[1])
    blocks = (ROAD_ENDS_X[0], NEAR_KERB_X), (FAR_KERB_X, ROAD_ENDS_X[1])
    surfaces = [
        rectangle("pavement", ROAD_ENDS_X, (-edge - side, edge + side + 2.6)),
        rectangle("pavement", (NEAR_KERB_X - side, FAR_KERB_X + side), CROSS_ROAD_ENDS_Y),
        *(rectangle("kerb", block, (-edge - 0.2, edge + 0.2)) for block in blocks),
        rectangle("kerb", (bay[0] - 0.2, bay[1] + 0.2), (edge, edge + 2.8)),
        rectangle("kerb", (NEAR_KERB_X - 0.2, FAR_KERB_X + 0.2), CROSS_ROAD_ENDS_Y),
        rectangle("asphalt", ROAD_ENDS_X, (-edge, edge)),
        rectangle("asphalt", bay, (edge, edge + 2.6)),
        rectangle("asphalt", (NEAR_KERB_X, FAR_KERB_X), CROSS_ROAD_ENDS_Y),
    ]
    for arm in arms:
        surfaces += stripe((arm[0], 0.0), (arm[1], 0.0), dash=(3.0, 3.0))
    surfaces += stripe((bay[0], edge), (bay[1], edge), dash=(1.0, 1.0))
    for first, last in ((CROSS_ROAD_ENDS_Y[0], -edge - 4.5), (edge + 4.5, CROSS_ROAD_ENDS_Y[1])):
        middle = 0.5 * (NEAR_KERB_X + FAR_KERB_X)
        surfaces += stripe((middle - 0.15, first), (middle - 0.15, last), 0.12)
        surfaces += stripe((middle + 0.15, first), (middle + 0.15, last), 0.12)
        for lane in (NEAR_KERB_X + LANE_METRES, FAR_KERB_X - LANE_METRES):
            surfaces += stripe((lane, first), (lane, last), dash=(3.0, 4.5))
    surfaces += zebra((NEAR_KERB_X - 3.6, NEAR_KERB_X - 0.8), (-edge, edge))
    surfaces += zebra((FAR_KERB_X + 0.8, FAR_KERB_X + 3.6), (-edge, edge))
    surfaces += stripe((stop_near, 0.0), (stop_near, edge), 0.4)
    surfaces += stripe((stop_far, -edge), (stop_far, 0.0), 0.4)
    surfaces += stripe(
        (NEAR_KERB_X, -edge - 4.5), (0.5 * (NEAR_KERB_X + FAR_KERB_X), -edge - 4.5), 0.4
    )
    surfaces += stripe(
        (0.5 * (NEAR_KERB_X + FAR_KERB_X), edge + 4.5), (FAR_KERB_X, edge + 4.5), 0.4
    )
    return Roads(tuple(surfaces))


def _traffic(models: Models) -> Scripted:
    """The same for every seed; cars have the sizes of the script."""
    return Scripted(CARS, EGO)


def crossing(*, frames: int = 140) -> Scene:
    """Four arms, cross traffic by script; the seed chooses nothing but the paints.

    frames: length of the run in frames, at 10 Hz.
    """
    return Scene("crossing", _traffic, frames, _roads())
