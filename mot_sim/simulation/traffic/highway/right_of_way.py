"""Who waits at which line: first come, first served at a crossing; give way at a merge."""

from functools import lru_cache

import numpy as np

from mot_sim.simulation.traffic.highway.car import STANDING_GAP_METRES, Car
from mot_sim.simulation.traffic.highway.layout import Layout, Path, Segment

ASKING_METRES = 28.0  # metres before the line from which a driver asks to cross
PATIENCE_TICKS = 100  # ticks that one who waits lets others go first: 5 s
YIELDING_PATIENCE_TICKS = 400  # the same, others that have priority: then one of them stops for it
DECISION_METRES = 18.0  # metres before a give-way line from which a driver may decide to go
SPARE_SECONDS = 1.5  # seconds between us and the next car where we merge
PULL_AWAY_ACCELERATION = 1.5  # m/s2 of a car that pulls away
MAX_LEGS = 8  # of its way that a driver with priority is seen ahead
MAX_RING_SHARE = 0.5  # of a ring and its entries that cars take up; when it is more, nobody enters


class RightOfWay:
    """Sets `held` of every car before a line. Whoever may go keeps that right."""

    def __init__(self, layout: Layout) -> None:
        self.layout = layout
        self.waiting: list[Car] = []
        self.going: dict[Car, int] = {}  # the leg of each that lies behind its line
        self.waits: dict[Car, int] = {}  # ticks
        self.ring = circulating(layout.paths) | layout.merges
        lanes = [layout.network.get_lane((*segment, 0)) for segment in self.ring]
        self.ring_metres = sum(float(lane.length) for lane in lanes)

    def update(self, cars: list[Car]) -> None:
        """Let cars go, in the order of their coming."""
        there = set(cars)
        self.going = {
            car: leg
            for car, leg in self.going.items()
            if car in there and not self._is_through(car, leg)
        }
        known = {*self.going, *self.waiting}
        self.waiting = [  # a car that nobody holds may have crossed its line without the right
            car for car in self.waiting if car in there and self._behind_line(car) is not None
        ]
        self.waiting += sorted(
            (car for car in cars if car not in known and self._asks(car)),
            key=lambda car: (car.to_line, car.number),
        )
        earlier: list[Car] = []
        for car in self.waiting:
            if self._may_go(car, earlier, cars):
                self.going[car] = car.leg + 1
            else:
                earlier.append(car)
        self.waiting = earlier
        self.waits = {car: self.waits.get(car, 0) + 1 for car in earlier}
        for car in cars:
            car.held = self._behind_line(car) is not None and car not in self.going
            car.before = None
        for car in self.going:
            self._zip(car, cars)

    def _behind_line(self, car: Car) -> Segment | None:
        """The next segment of a car's way, if a line lies before it."""
        after = car.path[car.leg + 1] if car.leg + 1 < len(car.path) else None
        has_line = after in self.layout.crossings or after in self.layout.merges
        return after if has_line else None

    def _asks(self, car: Car) -> bool:
        after = self._behind_line(car)
        return after is not None and car.to_line < (
            ASKING_METRES if after in self.layout.crossings else DECISION_METRES
        )

    def _may_go(self, car: Car, earlier: list[Car], cars: list[Car]) -> bool:
        after = self._behind_line(car)
        assert after is not None
        if any(other.path[other.leg] == car.path[car.leg] for other in earlier):
            return False  # the right would be of no use behind one who stands, and block others
        if after in self.layout.merges:
            return self._has_room(cars) and self._has_gap(car, after, cars)
        blocked = self.layout.crossings[after]
        taken = [other.path[leg] for other, leg in self.going.items()]
        for other in earlier:
            segment = other.path[other.leg + 1]
            is_first = after in self.layout.yields.get(segment, ())
            patience = YIELDING_PATIENCE_TICKS if is_first else PATIENCE_TICKS
            if self.waits.get(other, 0) > patience:
                taken.append(segment)
        if any(segment in blocked for segment in taken):
            return False
        return after not in self.layout.yields or not self._must_yield(car, after, cars)

    def _must_yield(self, car: Car, after: Segment, cars: list[Car]) -> bool:
        """Whether someone with priority, who does not wait, comes before we are across."""
        first, lane = self.layout.yields[after], car.road.network.get_lane((*after, 0))
        across = car.to_line + float(lane.length) + car.LENGTH
        time = _time_to_pass(across, car.speed, float(lane.speed_limit)) + SPARE_SECONDS
        return any(
            self._metres_to(other, first) < time * max(other.speed, 2.0)
            for other in cars
            if other is not car and other not in self.waits
        )

    def _metres_to(self, car: Car, segments: frozenset[Segment]) -> float:
        """Metres from a car's front to the beginning of one of the segments, the next of its way
        behind a line; infinite if that is another one."""
        apart = -car.along - 0.5 * car.LENGTH
        for segment in car.path[car.leg : car.leg + MAX_LEGS]:
            if segment in self.layout.crossings:
                return apart if segment in segments and apart > -car.LENGTH else np.inf
            apart += float(car.road.network.get_lane((*segment, 0)).length)
        return np.inf

    def _is_through(self, car: Car, leg: int) -> bool:
        """Whether the whole car has left the segment behind the line."""
        return car.leg > leg + 1 or (car.leg == leg + 1 and car.along > 0.5 * car.LENGTH + 0.5)

    def _zip(self, car: Car, cars: list[Car]) -> None:
        """Before this car and one on the ring merge, the later one follows the earlier already."""
        after = next((one for one in car.path if one in self.layout.merges), None)
        if after is None or car.path[car.leg] != after:
            return
        ours = float(car.lane.length) - car.along
        for other in cars:
            apart = self._to_node(other, after)
            if apart is None:
                continue
            first, second = (car, other) if apart > ours else (other, car)
            gap = abs(apart - ours) - 0.5 * (car.LENGTH + other.LENGTH)
            if second.before is None or gap < second.before[0]:
                second.before = gap, first.speed

    def _has_room(self, cars: list[Car]) -> bool:
        """Whether another car may enter the ring: a full one would wait for itself for ever."""
        inside = [car for car in cars if car.path[car.leg] in self.ring or car in self.going]
        taken = sum(car.LENGTH + STANDING_GAP_METRES for car in inside)
        return taken < MAX_RING_SHARE * self.ring_metres

    def _has_gap(self, car: Car, after: Segment, cars: list[Car]) -> bool:
        """Whether nobody on the ring reaches the merging point soon after us, or before us."""
        lane = car.road.network.get_lane((*after, 0))
        ours = car.to_line + float(lane.length)
        time = _time_to_pass(ours + 0.5 * car.LENGTH, car.speed, float(lane.speed_limit))
        for other in cars:
            apart = self._to_node(other, after)
            if apart is not None and apart / max(other.speed, 2.0) < time + SPARE_SECONDS:
                return False
        return True

    def _to_node(self, car: Car, after: Segment) -> float | None:
        """Metres to where a segment ends, for cars beyond every line whose way passes there."""
        if car.held or after in car.path[car.leg : car.leg + 2]:
            return None
        apart = -car.along
        for number, segment in enumerate(car.path[car.leg :]):
            if segment[0] == after[1] and number > 0:
                return apart
            if number > 0 and segment in self.layout.merges:
                return None
            apart += float(car.road.network.get_lane((*segment, 0)).length)
        return None


@lru_cache(maxsize=16)  # a town takes an eighth of a second
def circulating(paths: tuple[Path, ...]) -> frozenset[Segment]:
    """The segments of a ring: from the end of each of them a way leads back to its beginning."""
    segments = {segment for path in paths for segment in path}
    found = set()
    for first in segments:
        reached, new = {first[1]}, {first[1]}
        while new:
            new = {end for start, end in segments if start in new} - reached
            reached |= new
        if first[0] in reached:
            found.add(first)
    return frozenset(found)


def _time_to_pass(distance: float, speed: float, limit: float) -> float:
    """Seconds for a distance when pulling away up to a limit."""
    top = max(limit, speed, 0.1)
    until = (top**2 - speed**2) / (2.0 * PULL_AWAY_ACCELERATION)
    if until >= distance:
        return float(
            (np.sqrt(speed**2 + 2.0 * PULL_AWAY_ACCELERATION * distance) - speed)
            / PULL_AWAY_ACCELERATION
        )
    return (top - speed) / PULL_AWAY_ACCELERATION + (distance - until) / top
