"""The road with its cars: a fast search of neighbours, and highway-env's step without impacts."""

from bisect import bisect_left
from typing import Any

import numpy as np
from highway_env.road.road import LaneIndex, Road

from mot_sim.simulation.traffic.highway.lane_table import OVERHANG_METRES
from mot_sim.simulation.traffic.highway.layout import Layout, Segment
from mot_sim.simulation.traffic.traffic_state import colliding_pairs

MAX_BEHIND_METRES = 120.0  # metres: lanes that begin farther behind this one are not looked at
MAX_JOINT_METRES = 1.0  # metres between the ends of lanes that lead into one another


class CarRoad(Road):
    """highway-env's road, whose cars look along their own ways.

    A neighbour is on a lane by highway-env's rule (`AbstractLane.on_lane`); the lanes searched
    are those of the car's own way, where highway-env takes all that branch off. Instead of every
    car for every question, all cars are projected on a lane at once, once a tick.
    """

    def __init__(self, layout: Layout, rng: np.random.Generator) -> None:
        super().__init__(layout.network, [], [], rng, neighbour_vehicles_connected_lanes=True)
        self.layout = layout
        self._beside: dict[Segment, list[LaneIndex]] = {}
        self._onward: dict[tuple[LaneIndex, Segment], tuple[LaneIndex, bool]] = {}
        self._around: dict[tuple[LaneIndex, int, int], list[tuple[LaneIndex, float]]] = {}
        self._limits: dict[tuple[LaneIndex, int, int], list[tuple[float, float]]] = {}
        self._seen: dict[LaneIndex, list[tuple[int, float]]] = {}
        self._placed: dict[tuple[LaneIndex, int, int], tuple[list[float], list[int]]] = {}
        self._local: dict[tuple[LaneIndex, Any], tuple[float, float]] = {}
        self.lanes = layout.network.lanes_dict()
        self.table = layout.table
        # Of each lane, how far aside and how far along somebody is still on it.
        ends = (self.table.length + OVERHANG_METRES).tolist()
        both = zip(self.table.reach.tolist(), ends, strict=True)
        self._bounds = dict(zip(self.table.names, both, strict=True))
        self.changing: list[Any] = []  # cars on their way to another lane

    def act(self) -> None:
        """Let every car decide, and turn the wheels so that it slips as it wants to."""
        self.forget()
        super().act()
        turning = [car for car in self.vehicles if car.slip is not None]
        slips = np.array([car.slip for car in turning])
        angles = np.arctan(2.0 * np.tan(np.arcsin(slips))).tolist()
        for car, angle in zip(turning, angles, strict=True):
            most = car.MAX_STEERING_ANGLE
            car.action["steering"] = max(min(angle, most), -most)

    def step(self, dt: float) -> None:
        """Move every car; those that now overlap have crashed, without highway-env's jumps.

        The sums are those of `Vehicle.step`, a car each row: a bicycle, its slip angle halfway.
        """
        cars, self._local = self.vehicles, {}
        if not cars:
            return
        controls = np.array([car.controls(dt) for car in cars])
        steering, acceleration, speed, heading, length = controls.T
        slip = np.arctan(0.5 * np.tan(steering))
        course = heading + slip
        velocity = speed[:, None] * np.stack((np.cos(course), np.sin(course)), axis=1)
        positions = np.array([car.position for car in cars]) + velocity * dt
        heading = heading + speed * np.sin(slip) / (0.5 * length) * dt
        rows = np.array([self.table.rows[car.lane_index] for car in cars])
        motion = heading, speed + acceleration * dt, *self.table.own_places(rows, positions)
        for car, position, moved in zip(
            cars, positions, np.transpose(motion).tolist(), strict=True
        ):
            car.move_to(position, *moved)
        if len(cars) > 1:
            poses = np.column_stack((positions, heading))
            size = np.array([car.size for car in cars])
            for row in set(colliding_pairs(poses, size).ravel().tolist()):
                cars[row].crashed = True

    def forget(self) -> None:
        """Begin a new search: cars have moved, come or gone."""
        self._placed, self._local = {}, {}
        positions = np.array([car.position for car in self.vehicles]).reshape(-1, 2)
        self._seen = self.table.who_is_on(self.table.may_hold(positions), positions)
        for row, car in enumerate(self.vehicles):
            car.row = row
        self.changing = [car for car in self.vehicles if car.lane_index != car.target_lane_index]

    def neighbour_vehicles(self, vehicle: Any, lane_index: LaneIndex | None = None) -> Any:
        """The cars before and behind a car on a lane, each None if there is none."""
        index = lane_index or vehicle.lane_index
        if index == vehicle.lane_index:
            here = vehicle.along
        else:
            here = float(self.lanes[index].local_coordinates(vehicle.position)[0])
        places, rows = self._places(vehicle, index)
        ahead = bisect_left(places, here)
        behind = ahead - 1
        if ahead < len(rows) and rows[ahead] == vehicle.row:
            ahead += 1
        if behind >= 0 and rows[behind] == vehicle.row:
            behind -= 1
        return (
            self.vehicles[rows[ahead]] if ahead < len(rows) else None,
            self.vehicles[rows[behind]] if behind >= 0 else None,
        )

    def _places(self, vehicle: Any, index: LaneIndex) -> tuple[list[float], list[int]]:
        """Where cars are along a lane and what lies before and after it on a car's way, from the
        rear to the front, and which they are. Cars of one way ask the same."""
        key = (index, vehicle.way, vehicle.leg)
        if key not in self._placed:
            place: dict[int, float] = {}
            for ahead, offset in self.lanes_around(vehicle, index):
                for row, along in self._seen.get(ahead, ()):
                    place.setdefault(row, along + offset)
            # Of cars at one place highway-env takes the last in front and the first behind.
            order = sorted([(along, -row) for row, along in place.items()])
            self._placed[key] = [along for along, _ in order], [-row for _, row in order]
        return self._placed[key]

    def distance(self, car: Any, other: Any) -> float:
        """Metres between the centres along the first car's way; negative if the other is behind.

        Along the car's own lane where the other is on none of those around.
        """
        beside: float | None = None
        for index, offset in self.lanes_around(car, car.lane_index):
            if index == other.lane_index:
                along, aside = other.along, other.aside
            else:
                along, aside = self._place_on(index, other)
            reach, end = self._bounds[index]
            if abs(aside) <= reach and -OVERHANG_METRES <= along < end:
                return along + offset - car.along
            if beside is None:
                beside = along
        assert beside is not None
        return beside - car.along

    def _place_on(self, index: LaneIndex, car: Any) -> tuple[float, float]:
        """Where a car is along a lane that is not its own, and how far to the right."""
        key = (index, car)
        if key not in self._local:
            along, aside = self.lanes[index].local_coordinates(car.position)
            self._local[key] = float(along), float(aside)
        return self._local[key]

    def limits_ahead(self, car: Any) -> list[tuple[float, float]]:
        """Where the lanes after a car's own begin, metres along that, and their speed limits."""
        key = (car.lane_index, car.way, car.leg)
        if key not in self._limits:
            ahead = self.lanes_ahead(car)[1:]
            self._limits[key] = [(offset, self.lanes[index].speed_limit) for index, offset in ahead]
        return self._limits[key]

    def lanes_ahead(self, car: Any) -> list[tuple[LaneIndex, float]]:
        """The car's lane and those after it on its way, with where they begin along its lane."""
        return [pair for pair in self.lanes_around(car, car.lane_index) if pair[1] >= 0.0]

    def aside_on_way(self, car: Any, other: Any) -> float | None:
        """Metres that another one's centre lies beside the lanes ahead of a car; None: nowhere."""
        for index, _ in self.lanes_ahead(car):
            lane = self.network.get_lane(index)
            along, aside = lane.local_coordinates(other.position)
            if 0.0 <= along <= lane.length:
                return abs(float(aside))
        return None

    def next_on_way(self, car: Any) -> Any:
        """The next car that drives on the lanes ahead of a car itself; None: nobody."""
        offsets = dict(self.lanes_ahead(car))
        ahead = [
            (offsets[other.lane_index] + other.along, other.row)
            for other in self.vehicles
            if other.lane_index in offsets and other is not car
        ]
        beyond = [pair for pair in ahead if pair[0] > car.along]
        return self.vehicles[min(beyond)[1]] if beyond else None

    def course(self, car: Any, index: LaneIndex, along: float) -> float:
        """The direction of a lane, or of the one after it on the car's way, at some place."""
        lane = self.network.get_lane(index)
        path = self.layout.paths[car.way]
        if along > lane.length and car.leg + 1 < len(path) and index[:2] == path[car.leg]:
            along -= float(lane.length)
            lane = self.network.get_lane(self.onward(index, path[car.leg + 1])[0])
        return float(lane.heading_at(along))

    def lanes_around(self, car: Any, index: LaneIndex) -> list[tuple[LaneIndex, float]]:
        """A lane, those after it on a car's way, and those before it, with their offsets."""
        key = (index, car.way, car.leg)
        if key not in self._around:
            path = self.layout.paths[car.way]
            found = [(index, 0.0)]
            offset, last = 0.0, index
            for segment in path[car.leg + 1 :]:
                after, joins = self.onward(last, segment)
                offset += float(self.network.get_lane(last).length)
                if not joins or offset > MAX_BEHIND_METRES + self.network.get_lane(index).length:
                    break
                found.append((after, offset))
                last = after
            if car.leg > 0:
                for before in self.beside((*path[car.leg - 1], 0)):
                    if self.onward(before, path[car.leg]) == (index, True):
                        found.append((before, -float(self.network.get_lane(before).length)))
            self._around[key] = found
        return self._around[key]

    def beside(self, index: LaneIndex) -> list[LaneIndex]:
        """All lanes of the segment of a lane."""
        segment = index[:2]
        if segment not in self._beside:
            self._beside[segment] = self.network.all_side_lanes(index)
        return self._beside[segment]

    def onward(self, index: LaneIndex, segment: Segment) -> tuple[LaneIndex, bool]:
        """The lane of the next segment nearest to where a lane ends, and whether they join."""
        key = (index, segment)
        if key not in self._onward:
            lane = self.network.get_lane(index)
            end = lane.position(lane.length, 0.0)
            gaps = [
                float(np.hypot(*(self.network.get_lane(other).position(0.0, 0.0) - end)))
                for other in self.beside((*segment, 0))
            ]
            nearest = int(np.argmin(gaps))
            self._onward[key] = (*segment, nearest), gaps[nearest] < MAX_JOINT_METRES
        return self._onward[key]

    def is_closing(self, car: Any, index: LaneIndex) -> bool:
        """Whether a lane of the car's segment ends although its way goes on."""
        path = self.layout.paths[car.way]
        return car.leg + 1 < len(path) and not self.onward(index, path[car.leg + 1])[1]
