"""The road with its cars: a fast search of neighbours, and highway-env's step without impacts."""

from bisect import bisect_left
from typing import Any

import numpy as np
from highway_env.road.lane import AbstractLane, StraightLane
from highway_env.road.road import LaneIndex, Road
from jaxtyping import Float
from numpy import ndarray as Array

from mot_sim.simulation.traffic.highway.layout import Layout, Segment
from mot_sim.simulation.traffic.traffic_state import colliding_pairs

MAX_BEHIND_METRES = 120.0  # metres: lanes that begin farther behind this one are not looked at
LATERAL_MARGIN_METRES = 1.0  # highway-env's rule of who is on a lane
OVERHANG_METRES = 5.0  # the same, beyond its ends
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
        self._seen: dict[LaneIndex, list[tuple[int, float]]] = {}
        self._placed: dict[tuple[LaneIndex, int, int], tuple[list[float], list[int]]] = {}
        self._positions = np.zeros((0, 2))
        self._lanes = {index: row for row, index in enumerate(layout.network.lanes_dict())}
        self._circles = np.array([circle_around(lane) for lane in layout.network.lanes_list()])
        self._may_hold = [True] * len(self._lanes)
        self.changing: list[Any] = []  # cars on their way to another lane

    def act(self) -> None:
        """Let every car decide."""
        self.forget()
        super().act()

    def step(self, dt: float) -> None:
        """Move every car; those that now overlap have crashed, without highway-env's jumps."""
        for car in self.vehicles:
            car.step(dt)
        if len(self.vehicles) > 1:
            poses = np.array([car.pose for car in self.vehicles])
            size = np.array([car.size for car in self.vehicles])
            for row in set(colliding_pairs(poses, size).ravel().tolist()):
                self.vehicles[row].crashed = True

    def forget(self) -> None:
        """Begin a new search: cars have moved, come or gone."""
        self._seen, self._placed = {}, {}
        self._positions = np.array([car.position for car in self.vehicles]).reshape(-1, 2)
        x, y, radius = self._circles.T
        apart = np.hypot(x[:, None] - self._positions[:, 0], y[:, None] - self._positions[:, 1])
        self._may_hold = (apart < radius[:, None]).any(axis=1).tolist()
        for row, car in enumerate(self.vehicles):
            car.row = row
        self.changing = [car for car in self.vehicles if car.lane_index != car.target_lane_index]

    def neighbour_vehicles(self, vehicle: Any, lane_index: LaneIndex | None = None) -> Any:
        """The cars before and behind a car on a lane, each None if there is none."""
        index = lane_index or vehicle.lane_index
        if index == vehicle.lane_index:
            here = vehicle.along
        else:
            here = float(self.network.get_lane(index).local_coordinates(vehicle.position)[0])
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
                if self._may_hold[self._lanes[ahead]]:
                    for row, along in self._on_lane(ahead):
                        place.setdefault(row, along + offset)
            # Of cars at one place highway-env takes the last in front and the first behind.
            order = sorted(place, key=lambda row: (place[row], -row))
            self._placed[key] = [place[row] for row in order], order
        return self._placed[key]

    def _on_lane(self, index: LaneIndex) -> list[tuple[int, float]]:
        """Who is on a lane, and how far along it."""
        if index not in self._seen:
            lane = self.network.get_lane(index)
            along, aside = project(lane, self._positions)
            inside = (along >= -OVERHANG_METRES) & (along < lane.length + OVERHANG_METRES)
            on_it = inside & (np.abs(aside) <= 0.5 * lane.width_at(0.0) + LATERAL_MARGIN_METRES)
            rows = np.flatnonzero(on_it)
            self._seen[index] = list(zip(rows.tolist(), along[rows].tolist(), strict=True))
        return self._seen[index]

    def distance(self, car: Any, other: Any) -> float:
        """Metres between the centres along the first car's way; negative if the other is behind."""
        for index, offset in self.lanes_around(car, car.lane_index):
            lane = self.network.get_lane(index)
            if index == other.lane_index:
                along, aside = other.along, other.aside
            else:
                along, aside = lane.local_coordinates(other.position)
            if lane.on_lane(other.position, along, aside, margin=LATERAL_MARGIN_METRES):
                return float(along) + offset - car.along
        return float(car.lane_distance_to(other))

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


def circle_around(lane: AbstractLane) -> tuple[float, float, float]:
    """x, y, radius of a circle outside of which nobody is on a lane."""
    points = np.array([lane.position(along, 0.0) for along in np.linspace(0.0, lane.length, 9)])
    middle = 0.5 * (points.min(axis=0) + points.max(axis=0))
    reach = np.hypot(*(points - middle).T).max()
    # The points on a bend lie apart: a sixteenth of its length is more than it bulges between.
    beside = 0.5 * float(lane.width_at(0.0)) + LATERAL_MARGIN_METRES
    spare = OVERHANG_METRES + beside + (float(lane.length) - reach) / 16.0
    return float(middle[0]), float(middle[1]), float(reach + max(spare, OVERHANG_METRES + beside))


def project(
    lane: AbstractLane, positions: Float[Array, "n 2"]
) -> tuple[Float[Array, " n"], Float[Array, " n"]]:
    """`AbstractLane.local_coordinates` of many points: metres along a lane and right of it."""
    if isinstance(lane, StraightLane):
        apart = positions - lane.start
        return apart @ lane.direction, apart @ lane.direction_lateral
    apart = positions - lane.center
    turn = np.arctan2(apart[:, 1], apart[:, 0]) - lane.start_phase
    turn = (turn + np.pi) % (2.0 * np.pi) - np.pi
    aside = lane.radius - np.hypot(apart[:, 0], apart[:, 1])
    return lane.direction * turn * lane.radius, lane.direction * aside
