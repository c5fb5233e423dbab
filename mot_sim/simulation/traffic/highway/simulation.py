"""One run of live traffic: cars come, drive and leave; 20 Hz inside, 10 Hz outside."""

from dataclasses import dataclass, field
from functools import lru_cache
from math import sqrt

import numpy as np
from highway_env.road.road import LaneIndex
from jaxtyping import Float
from numpy import ndarray as Array

from mot_sim.simulation import random_numbers
from mot_sim.simulation.traffic.body_motion import BodyMotion
from mot_sim.simulation.traffic.highway.car import STANDING_GAP_METRES, TICK_SECONDS, Car, EgoCar
from mot_sim.simulation.traffic.highway.driver import Driver
from mot_sim.simulation.traffic.highway.layout import Kerb, Layout
from mot_sim.simulation.traffic.highway.right_of_way import RightOfWay
from mot_sim.simulation.traffic.highway.road import CarRoad
from mot_sim.simulation.traffic.scripted import SEDAN_SIZE
from mot_sim.simulation.traffic.traffic_state import STEP_SECONDS, TrafficState
from tracker.errors import BadConfig

SPARE_METRES = 5.0  # metres between the bumpers of the longest cars at time 0
PARKING_SPARE_METRES = 1.2  # between parked ones
PARKED_ASIDE_METRES = 0.3  # from the kerb's line to a parked car
# Length, height, width of common cars, from small to large.
CAR_SIZES = (
    (3.6, 1.5, 1.64), (4.0, 1.46, 1.74), (4.3, 1.45, 1.79), (4.6, 1.43, 1.83),
    (4.75, 1.48, 1.82), (4.5, 1.66, 1.85), (4.85, 1.75, 1.93),
)  # fmt: skip
VAN_SIZE = (5.4, 2.3, 2.0)
EGO_NUMBER = -1  # the ego car's number
MAX_QUEUE = 3  # cars that wait outside to come in; more are turned away
MIN_ENTRY_SPEED = 4.0  # m/s: who could only come in slower behind another waits
ENTRY_BRAKING = 2.0  # m/s2 that who comes in may have to brake
EGO_EAGERNESS = 0.95
EGO_RANGE = (0.7, 1.05)  # of our car's drivers where they differ
EAGERNESS_RANGE = (0.75, 1.05)  # wanted speeds as a part of the limits
TOWED_SECONDS = 20.0  # seconds after which who has crashed is gone, so that no jam lasts
HEADWAY_SECONDS = 1.2  # seconds, of cars that begin or come in behind another


@lru_cache(maxsize=512)  # who waits to come in is asked again in every step
def _drawn(seed: int, effect: str, number: int) -> float:
    """A number between 0 and 1 of a car, or of an arrival."""
    key = np.array([number + 1]), np.zeros(1, np.int64)
    return float(random_numbers.uniform(seed, effect, *key)[0, 0])


@dataclass(frozen=True, eq=False)
class Slot:
    """A place for one car at time 0."""

    lane_index: LaneIndex
    """highway-env's name of the lane: nodes from and to, number from the left."""
    along: float
    """Metres along it."""


def slots(layout: Layout, longest: float, seed: int) -> list[Slot]:
    """Places that are free at time 0, in an order drawn by the seed; the ego's is left out."""
    start = layout.ego
    ego_lane = (*start.paths[0][0], start.lane)
    ego = layout.network.get_lane(ego_lane).position(start.distance, 0.0)
    pitch = longest + SPARE_METRES
    found = []
    for segment in layout.fillable:
        for number in range(len(layout.network.graph[segment[0]][segment[1]])):
            index = (*segment, number)
            lane = layout.network.get_lane(index)
            # Nobody begins in the last metres before a line, where he could not stop any more.
            room = float(lane.length) - longest - 20.0
            for along in np.arange(longest, room, pitch).tolist():
                place = lane.position(along + 0.5 * SPARE_METRES, 0.0)
                if index == ego_lane and abs(along - start.distance) < 2.0 * pitch:
                    continue
                if np.hypot(*(place - ego)) < layout.reach:
                    found.append(Slot(index, along))
    rank = random_numbers.uniform(
        seed, "slot", np.arange(len(found)), np.zeros(len(found), np.int64), 2
    )
    moved = [
        Slot(slot.lane_index, slot.along + 0.8 * SPARE_METRES * float(share))
        for slot, share in zip(found, rank[:, 1], strict=True)
    ]
    return [moved[row] for row in np.argsort(rank[:, 0], kind="stable").tolist()]


def choose_slots(layout: Layout, count: int, longest: float, seed: int, name: str) -> list[Slot]:
    """So many places. Raises BadConfig for more than the road holds."""
    free = slots(layout, longest, seed)
    if count > len(free):
        raise BadConfig(
            f"{count} cars on the {name}: it holds {len(free)} of {longest:.3g} m beside ours at "
            "time 0; ask for fewer, or let more arrive"
        )
    return free[:count]


@dataclass(frozen=True, eq=False)
class Parked:
    """Cars that never move, beside the road."""

    poses: Float[Array, "n 3"]
    """x, y (metres) and heading (radians) in world of each parked car."""
    size: Float[Array, "n 3"]
    """Length, height, width of each, metres."""


def park(
    layout: Layout,
    share: float,
    vans: int,
    sizes: Float[Array, "m 3"],
    van: tuple[float, float, float],
    seed: int,
) -> Parked:
    """Parked cars on a share of all kerb places, and vans on those nearest to the origin.

    The origin is the middle of a junction: there vans hide the most.
    """
    pitch = float(max(sizes[:, 0].max(), van[0])) + PARKING_SPARE_METRES
    places, part = [], []
    for kerb in layout.kerbs:
        new = _places(kerb, pitch)
        places += new
        part += [kerb.share] * len(new)
    by_distance = np.argsort([np.hypot(*place[:2]) for place in places], kind="stable")
    if vans > len(places):
        raise BadConfig(f"{vans} parked vans: the kerbs hold {len(places)}; ask for fewer")
    count = len(places)
    chance = random_numbers.uniform(seed, "parked", np.arange(count), np.zeros(count, np.int64), 3)
    is_van = np.zeros(count, dtype=bool)
    is_van[by_distance[:vans]] = True
    poses, size = [], []
    for number, (x, y, heading) in enumerate(places):
        if not is_van[number] and chance[number, 0] >= share * part[number]:
            continue
        one = np.array(van) if is_van[number] else sizes[int(chance[number, 1] * len(sizes))]
        aside = PARKED_ASIDE_METRES + 0.5 * float(one[2])
        along = (float(chance[number, 2]) - 0.5) * 0.6 * PARKING_SPARE_METRES
        c, s = np.cos(heading), np.sin(heading)
        poses.append((x + c * along - s * aside, y + s * along + c * aside, heading))
        size.append(one)
    return Parked(np.array(poses).reshape(-1, 3), np.array(size).reshape(-1, 3))


def _places(kerb: Kerb, pitch: float) -> list[tuple[float, float, float]]:
    """Points on the kerb's line before the middles of its places, with the heading."""
    c, s = np.cos(kerb.heading), np.sin(kerb.heading)
    along = np.arange(0.5 * pitch, kerb.length - 0.5 * pitch + 1e-9, pitch).tolist()
    return [(kerb.start[0] + c * a, kerb.start[1] + s * a, kerb.heading) for a in along]


@dataclass(eq=False)
class Demand:
    """How much traffic there is on which road."""

    road: str = "intersection"
    """Name of the road, one of ROADS."""
    cars: int = 12
    """Cars that drive at time 0, >= 0, ours not counted; at most what the road holds. More: denser
    traffic."""
    arrivals: float = 0.5
    """Cars per second that come in later, >= 0, over all entries; more: denser traffic. At most
    three wait to come in, the others turn away."""
    parked: float = 0.4
    """Share of the kerb places where cars park, 0 to 1; more: more occlusion."""
    vans: int = 0
    """Parked vans, >= 0, on the kerb places nearest to the middle; more: more occlusion there."""
    sizes: Float[Array, "m 3"] = field(default_factory=lambda: np.array(CAR_SIZES))
    """Length, height, width that each car is drawn from, metres; > 0, at most 8 m long and 2.2 m
    wide."""
    van_size: tuple[float, float, float] = VAN_SIZE
    """Length, height, width of the parked vans, metres; within the same limits."""
    ego_size: tuple[float, float, float] = SEDAN_SIZE
    """Length, height, width of our car, metres; within the same limits."""
    route: str = "any"
    """Name of our car's way, of the routes that the road has; `any`: one is drawn by the seed."""
    wander: float = 0.0
    """How much drivers drift in their lanes and vary their speeds, >= 0: 0 as the model, 1 as
    people do."""
    bumps: float = 0.0
    """How much our car's body pitches and rolls on its springs and on slopes, >= 0: 0 not at all,
    1 as KITTI's car."""
    continuous: bool = False
    """Whether our car begins a new way, at an entry, where its road ends; without, the run ends
    there."""


class Simulation:
    """A run from one seed. Numbers of cars: -1 is ours, then the parked ones, then as they come."""

    def __init__(self, layout: Layout, demand: Demand, seed: int) -> None:
        self.layout, self.demand, self.seed = layout, demand, seed
        self.road = CarRoad(layout, np.random.default_rng(seed))
        self.rules = RightOfWay(layout)
        self.parked = park(layout, demand.parked, demand.vans, demand.sizes, demand.van_size, seed)
        self.count = len(self.parked.poses)  # of the numbers that are taken
        self.ego_ways = 0  # new ways that our car has begun
        self.steps = 0
        self.queue: list[tuple[int, int]] = []  # number and way of those who wait to come in
        self.arrived = 0
        self.next_arrival = self._pause()
        self.body = BodyMotion(seed, demand.bumps) if demand.bumps > 0.0 else None
        self.ego = self._place_ego()
        self.tilt = None if self.body is None else self.body.step(self.ego.pose)
        self.road.vehicles = [self.ego]
        self._fill()
        self.rules.update(self.road.vehicles)

    def _draw(self, effect: str, number: int) -> float:
        return _drawn(self.seed, effect, number)

    def _place_ego(self) -> EgoCar:
        start = self.layout.ego
        path = start.paths[int(self._draw("ego way", EGO_NUMBER) * len(start.paths))]
        path = self.layout.routes.get(self.demand.route, path)
        way = self.layout.paths.index(path)
        limit = self.layout.network.get_lane((*path[0], start.lane)).speed_limit
        place = (start.lane, start.distance)
        speed = 0.8 * float(limit)
        return self._new_ego(way, place, speed)

    def _new_ego(self, way: int, place: tuple[int, float], speed: float) -> EgoCar:
        driver = self._driver(EGO_NUMBER)
        eagerness = EGO_EAGERNESS
        if driver is not None:
            eagerness = float(np.interp(self._draw("eagerness", EGO_NUMBER), (0, 1), EGO_RANGE))
        size = self.demand.ego_size
        return EgoCar(self.road, EGO_NUMBER, size, (way, 0), place, speed, eagerness, driver)

    def _driver(self, number: int) -> Driver | None:
        """Who drives a car; None: the model alone."""
        wander = self.demand.wander
        return Driver(self.seed, number, wander) if wander > 0.0 else None

    def _size(self, number: int) -> tuple[float, float, float]:
        row = int(self._draw("size", number) * len(self.demand.sizes))
        length, height, width = self.demand.sizes[row].tolist()
        return length, height, width

    def _new_car(self, number: int, way: tuple[int, int], place: tuple[int, float]) -> Car:
        eagerness = float(np.interp(self._draw("eagerness", number), (0.0, 1.0), EAGERNESS_RANGE))
        driver = self._driver(number)
        return Car(self.road, number, self._size(number), way, place, 0.0, eagerness, driver)

    def _fill(self) -> None:
        """Put the first cars on the road, with speeds at which nobody has to brake hard."""
        longest = float(max(self.demand.sizes[:, 0].max(), self.demand.ego_size[0]))
        name = self.demand.road
        for slot in choose_slots(self.layout, self.demand.cars, longest, self.seed, name):
            ways = [
                (number, path.index(slot.lane_index[:2]))
                for number, path in enumerate(self.layout.paths)
                if slot.lane_index[:2] in path
            ]
            way = ways[int(self._draw("way", self.count) * len(ways))]
            car = self._new_car(self.count, way, (slot.lane_index[2], slot.along))
            self.road.vehicles.append(car)
            self.count += 1
        self.road.forget()
        for car in self.road.vehicles:
            car.speed = self._fitting_speed(car)

    def _fitting_speed(self, car: Car) -> float:
        """The wanted speed, less behind a car, and before a line such that it can stop there."""
        front, _ = self.road.neighbour_vehicles(car)
        speed = car.speed_limit()
        if front is not None:
            gap = self.road.distance(car, front) - 0.5 * (car.LENGTH + front.LENGTH)
            speed = min(speed, max(gap - car.DISTANCE_WANTED, 0.0) / HEADWAY_SECONDS)
        if car.leg + 1 < len(car.path):
            speed = min(speed, float(np.sqrt(4.0 * max(car.to_line - 2.0, 0.0))))
        return speed

    def _pause(self) -> float:
        """Seconds until the next car comes, from an exponential distribution."""
        if self.demand.arrivals <= 0.0:
            return np.inf
        return -float(np.log(self._draw("arrival", self.arrived))) / self.demand.arrivals

    def step(self) -> None:
        """0.1 s of traffic."""
        for _ in range(round(STEP_SECONDS / TICK_SECONDS)):
            self.rules.update(self.road.vehicles)
            self.road.act()
            self.road.step(TICK_SECONDS)
        self.steps += 1
        self.road.vehicles = [
            car for car in self.road.vehicles if car is self.ego or self._stays(car)
        ]
        if self.demand.continuous and (self.ego.is_past_end or not self._stays(self.ego)):
            self._renew_ego()
        if self.body is not None:
            self.tilt = self.body.step(self.ego.pose)
        self._arrive()

    def _renew_ego(self) -> None:
        """Let our car begin a new way, at the first entry with room; without one, later."""
        paths, told_speed = self.layout.paths, self.ego.told_speed
        drawn = random_numbers.uniform(
            self.seed, "new ego way", np.zeros(1, np.int64), np.array([self.ego_ways])
        )
        first = int(float(drawn[0, 0]) * len(paths))
        self.road.vehicles.remove(self.ego)
        for way in (*range(first, len(paths)), *range(first)):
            for index in self.road.beside((*paths[way][0], 0)):
                place = (index[2], 0.0)
                car = self._new_ego(way, place, 0.0)
                car.speed = self._entry_speed(car)
                if car.speed > MIN_ENTRY_SPEED:
                    car.told_speed = told_speed
                    self.ego_ways += 1
                    self.ego = car
                    self.road.vehicles.append(car)
                    return
        self.road.vehicles.append(self.ego)

    @property
    def has_ended(self) -> bool:
        """Whether our car is behind the end of its road, and stays there."""
        return self.ego.is_past_end and not self.demand.continuous

    def _stays(self, car: Car) -> bool:
        """Whether a car is still on its way, and not a wreck that is towed away by now."""
        return not car.has_left and car.crashed_for * TICK_SECONDS < TOWED_SECONDS

    def _arrive(self) -> None:
        """Cars that come in now, by simulated time."""
        entries = len(self.layout.paths)
        while self.next_arrival <= self.steps * STEP_SECONDS:
            if len(self.queue) < MAX_QUEUE:
                way = int(self._draw("arriving way", self.arrived) * entries)
                self.queue.append((self.count, way))
                self.count += 1
            self.arrived += 1
            self.next_arrival += self._pause()
        waiting = []
        for number, way in self.queue:
            if not self._let_in(number, way):
                waiting.append((number, way))
        self.queue = waiting

    def _let_in(self, number: int, way: int) -> bool:
        """Put a car at the beginning of its way if there is room on one of the lanes."""
        lanes = self.road.beside((*self.layout.paths[way][0], 0))
        first, length = int(self._draw("lane", number) * len(lanes)), self._size(number)[0]
        for index in lanes[first:] + lanes[:first]:
            if self._free_speed(index, length) <= MIN_ENTRY_SPEED:
                continue
            car = self._new_car(number, (way, 0), (index[2], 0.0))
            car.speed = self._entry_speed(car)
            if car.speed > MIN_ENTRY_SPEED:
                self.road.vehicles.append(car)
                return True
        return False

    def _entry_speed(self, car: Car) -> float:
        """How fast a car may come in at the beginning of its lane, behind who is on it."""
        return min(car.speed_limit(), self._free_speed(car.lane_index, car.LENGTH))

    def _free_speed(self, lane_index: LaneIndex, length: float) -> float:
        """The same for a car of some length, m, whatever the limit."""
        most = np.inf
        for other in self.road.vehicles:
            if lane_index in (other.lane_index, other.target_lane_index):
                gap = other.along - 0.5 * (length + other.LENGTH) - STANDING_GAP_METRES
                safe = sqrt(other.speed**2 + 2.0 * ENTRY_BRAKING * max(gap, 0.0))
                most = min(most, safe, max(gap, 0.0) / HEADWAY_SECONDS)
        return most

    @property
    def has_crashed(self) -> bool:
        """Whether anybody has hit anybody."""
        return any(car.crashed for car in self.road.vehicles)

    def state(self) -> TrafficState:
        """The cars now, parked ones first."""
        cars = sorted(
            (car for car in self.road.vehicles if car is not self.ego), key=lambda car: car.number
        )
        still = len(self.parked.poses)
        moving = np.array([car.pose for car in cars]).reshape(-1, 3)
        poses = np.concatenate((self.parked.poses, moving))
        sizes = np.array([car.size for car in cars]).reshape(-1, 3)
        speeds = np.array([car.speed for car in cars], dtype=float)
        return TrafficState(
            time=self.steps * STEP_SECONDS,
            ids=np.array([*range(still), *(car.number for car in cars)], dtype=np.int64),
            x=poses[:, 0],
            y=poses[:, 1],
            heading=poses[:, 2],
            speed=np.concatenate((np.zeros(still), speeds)),
            size=np.concatenate((self.parked.size, sizes)),
            ego=self.ego.pose,
            ego_size=np.array(self.demand.ego_size),
            crashed=np.array([False] * still + [car.crashed for car in cars], dtype=bool),
            tilt=self.tilt,
        )
