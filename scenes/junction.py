"""What scripted junctions share: two roads that cross, flows and queues on them, and the paint.

The roads cross at the origin; traffic keeps to the right. We come from smaller x: our lanes have
y > 0, oncoming ones y < 0; on the cross road, cars from the left have x < 0, cars from the right
x > 0. Lanes are counted from the middle of a road, from 0.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from mot_sim.simulation.cars import Models
from mot_sim.simulation.traffic import Roads, Route, Script
from mot_sim.simulation.traffic.roads import rectangle, stripe
from tracker.errors import BadConfig

LANE_METRES = 3.5
ENDS_METRES = 140.0  # from the origin to where cars come and go: farther than labels reach
LINE_METRES = 3.0  # from the edge of the cross road to the fronts of cars that wait
QUEUE_GAP_METRES = 2.5  # between bumpers of cars that stand
BRAKING = 2.5  # m/s2 of cars that come to a queue
PULLING_AWAY = 1.8  # m/s2
REACTION_SECONDS = 0.9  # until the next car of a queue pulls away
TRUCK_SIZE = (7.2, 2.9, 2.2)  # length, height, width
Size = tuple[float, float, float]


@dataclass(frozen=True)
class Closed:
    """A part of a lane that its cars keep off for some time, because ours is there."""

    along: tuple[float, float]
    """Metres along the lane's route, where it begins and ends."""
    seconds: tuple[float, float]
    """The time."""

    def is_met(self, place: float, speed: float, length: float) -> bool:
        """Whether a car that keeps its speed is in it then; place: of its middle at time 0."""
        enters = (self.along[0] - 0.5 * length - place) / speed
        leaves = (self.along[1] + 0.5 * length - place) / speed
        return leaves > self.seconds[0] and enters < self.seconds[1]


def require_between(scene: str, **given: tuple[float, float, float]) -> None:
    """Raise BadConfig for a knob outside its range; given: value, least and most of each."""
    for knob, (value, least, most) in given.items():
        if not least <= value <= most:
            raise BadConfig(f"{knob} of {scene} is {value:g}: give {least:g} to {most:g}")


def lane_offset(lane: int) -> float:
    """Metres from the middle of the road to the middle of a lane."""
    return (lane + 0.5) * LANE_METRES


def oncoming(lane: int) -> Route:
    """The way of cars that come towards us; they pass the middle after ENDS_METRES."""
    return Route([(ENDS_METRES, -lane_offset(lane)), (-ENDS_METRES, -lane_offset(lane))])


def ahead(lane: int) -> Route:
    """The way of cars that drive as we do."""
    return Route([(-ENDS_METRES, lane_offset(lane)), (ENDS_METRES, lane_offset(lane))])


def from_left(lane: int) -> Route:
    """The way of cars that cross from the left."""
    return Route([(-lane_offset(lane), -ENDS_METRES), (-lane_offset(lane), ENDS_METRES)])


def from_right(lane: int) -> Route:
    """The way of cars that cross from the right."""
    return Route([(lane_offset(lane), ENDS_METRES), (lane_offset(lane), -ENDS_METRES)])


def size_of(rng: np.random.Generator, models: Models) -> Size:
    """The size of one of the models."""
    length, height, width = models.size[rng.integers(len(models.size))].tolist()
    return length, height, width


def flow(
    rng: np.random.Generator,
    models: Models,
    way: Route,
    rate: float,
    speed: float,
    seconds: float,
    closed: Sequence[Closed] = (),
) -> list[Script]:
    """Cars of one speed as they come, but those that would be in a closed part.

    rate: cars per second.
    """
    cars = []
    place, before = way.length, 0.0
    while rate > 0.0 and place > -speed * seconds:
        size = size_of(rng, models)
        place -= 0.5 * (before + size[0]) + 3.0 + rng.exponential(speed / rate)
        before = size[0]
        if any(one.is_met(place, speed, size[0]) for one in closed):
            continue
        begin = max(-place / speed, 0.0)
        cars.append(Script(way, [(0.0, speed)], start=place, size=size, begin=begin))
    return cars


def passing(cars: Sequence[Script], along: tuple[float, float], kept: float) -> list[Closed]:
    """What lies across the way of cars of one speed, closed while they are on a part of theirs.

    along: of their way, metres. kept: metres to each side of the middle of the road across.
    """
    found = []
    for car in cars:
        enters, leaves = (
            (place - car.start) / car.speeds[0][1]
            for place in (along[0] - 0.5 * car.size[0], along[1] + 0.5 * car.size[0])
        )
        found.append(Closed((ENDS_METRES - kept, ENDS_METRES + kept), (enters, leaves)))
    return found


def queue(
    way: Route, front: float, sizes: Sequence[Size], go: float | None = None, speed: float = 10.0
) -> list[Script]:
    """Cars that stand one behind the other; front: metres along the way to the first one's front.

    go: when the first one pulls away, up to the speed; None: all stand for ever.
    """
    cars, place = [], front
    for number, size in enumerate(sizes):
        speeds = [(0.0, 0.0)]
        if go is not None:
            begin = go + REACTION_SECONDS * number
            speeds += [(begin, 0.0), (begin + speed / PULLING_AWAY, speed)]
        kind = "Van" if size == TRUCK_SIZE else "Car"
        cars.append(Script(way, speeds, start=place - 0.5 * size[0], size=size, kind=kind))
        place -= size[0] + QUEUE_GAP_METRES
    return cars


def stopping(cars: Sequence[Script], front: float, seconds: float) -> list[Script]:
    """The same flow, of which those brake who would pass a line after some time.

    cars: of one lane, the first ones first. front: metres along the way to the line.
    """
    found, place = [], front
    for car in cars:
        speed = car.speeds[0][1]
        middle = place - 0.5 * car.size[0]
        braking = (middle - car.start - 0.5 * speed**2 / BRAKING) / speed
        if place == front and braking < seconds:
            found.append(car)  # it is across, or can no longer stop
            continue
        speeds = [(0.0, speed), (braking, speed), (braking + speed / BRAKING, 0.0)]
        found.append(Script(car.route, speeds, start=car.start, size=car.size, begin=car.begin))
        place -= car.size[0] + QUEUE_GAP_METRES
    return found


def stop_and_go(
    speed: float,
    stops: Sequence[tuple[float, float]],
    onward: Sequence[tuple[float, float]] | None = None,
) -> list[tuple[float, float]]:
    """Speeds of a car that comes to a stop some times, each at metres from where it begins and
    until a time; onward: seconds after the last of these times and speeds then.

    Raises BadConfig for a stop that it leaves before it stands, or comes too late to brake for.
    """
    at, time = 0.0, 0.0
    speeds = [(0.0, speed)]
    for metres, until in stops:
        if at > 0.0:  # pull away from the stop before
            time += speed / PULLING_AWAY
            at += 0.5 * speed**2 / PULLING_AWAY
            speeds.append((time, speed))
        cruise = (metres - at - 0.5 * speed**2 / BRAKING) / speed
        stands = time + cruise + speed / BRAKING
        if cruise <= 0.0 or stands >= until:
            raise BadConfig(
                f"a stop after {metres:g} m until {until:g} s: at {speed:g} m/s a car stands there "
                f"at {stands:.1f} s"
            )
        speeds += [(time + cruise, speed), (stands, 0.0), (until, 0.0)]
        at, time = metres, until
    onward = onward or [(speed / PULLING_AWAY, speed)]
    return speeds + [(time + seconds, then) for seconds, then in onward]


def crossing_roads(ours: int, cross: int) -> Roads:
    """The ground of a road of ours and a cross road, with so many lanes each way."""
    edge, side, end = ours * LANE_METRES, cross * LANE_METRES, ENDS_METRES + 60.0
    both, line = (-end, end), side + LINE_METRES - 0.6
    surfaces = [
        rectangle("pavement", both, (-edge - 2.6, edge + 2.6)),
        rectangle("pavement", (-side - 2.6, side + 2.6), both),
        rectangle("kerb", both, (-edge - 0.15, edge + 0.15)),
        rectangle("kerb", (-side - 0.15, side + 0.15), both),
        rectangle("asphalt", both, (-edge, edge)),
        rectangle("asphalt", (-side, side), both),
    ]
    far = edge + LINE_METRES - 0.6
    for sign in (-1.0, 1.0):
        surfaces += stripe((sign * line, 0.0), (sign * end, 0.0), dash=(3.0, 3.0))
        surfaces += stripe((0.0, sign * far), (0.0, sign * end), dash=(3.0, 3.0))
        for lane in range(1, ours):
            for y in (-lane * LANE_METRES, lane * LANE_METRES):
                surfaces += stripe((sign * line, y), (sign * end, y), dash=(3.0, 4.5))
        for lane in range(1, cross):
            for x in (-lane * LANE_METRES, lane * LANE_METRES):
                surfaces += stripe((x, sign * far), (x, sign * end), dash=(3.0, 4.5))
    surfaces += stripe((-line, 0.0), (-line, edge), 0.4)
    surfaces += stripe((line, -edge), (line, 0.0), 0.4)
    surfaces += stripe((-side, -far), (0.0, -far), 0.4)
    surfaces += stripe((0.0, far), (side, far), 0.4)
    return Roads(tuple(surfaces))
