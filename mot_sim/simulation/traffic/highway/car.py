"""Cars that follow their ways by the Intelligent Driver Model (IDMVehicle), and the ego car."""

from functools import cached_property
from math import pi, sqrt

import numpy as np
from highway_env.road.road import LaneIndex
from highway_env.vehicle.behavior import IDMVehicle
from jaxtyping import Float
from numpy import cos
from numpy import ndarray as Array

from mot_sim.simulation.traffic.driving import Driving
from mot_sim.simulation.traffic.highway.driver import Driver
from mot_sim.simulation.traffic.highway.road import CarRoad

TICK_SECONDS = 0.05  # seconds: 20 Hz, two ticks a state
MAX_SPEED = 40.0  # m/s; lanes have their limits
STANDING_GAP_METRES = 2.0  # metres from bumper to bumper
MAX_BRAKING = 7.0  # m/s2 of braking
SLOWING = 1.5  # m/s2 of braking before a bend
MAX_LATERAL_ACCELERATION = 4.5  # m/s2 that a driver steers for at most; the sharpest bends take 4
MAX_LANE_ANGLE = 0.22  # radians between a car that changes lanes and the lane
# m/s a command: at 10 commands a second the rate of highway-env, 5 m/s a second.
SPEED_STEP = 0.5
STANDING_SPEED = 0.1  # m/s of who stands
# Ticks of standing after which a driver tries what he would not do else: 5 s.
PATIENT_TICKS = 100
PASSING_ROOM_METRES = 0.3  # metres between our sides then
MAX_ASIDE_SHARE = 0.5  # of a lane's width


class Car(IDMVehicle):
    """One car. All that highway-env's classes hold as class attributes is set here anew, so
    that no other environment of the process can change it.
    """

    target_lane_index: LaneIndex
    LENGTH, HEIGHT, WIDTH = 4.4, 1.45, 1.8
    MAX_SPEED, MIN_SPEED = 40.0, 0.0
    HISTORY_SIZE = 1
    TAU_ACC, TAU_HEADING, TAU_LATERAL = 0.6, 0.2, 0.6
    TAU_PURSUIT = 0.5 * TAU_HEADING
    KP_A, KP_HEADING, KP_LATERAL = 1.0 / TAU_ACC, 1.0 / TAU_HEADING, 1.0 / TAU_LATERAL
    MAX_STEERING_ANGLE = 0.7
    DELTA_SPEED = 5.0
    # Drivers as in Treiber, Hennecke and Helbing, Phys. Rev. E 62 (2000), a little brisker.
    ACC_MAX, COMFORT_ACC_MAX, COMFORT_ACC_MIN = 6.0, 1.8, -2.5
    DISTANCE_WANTED, TIME_WANTED, DELTA = STANDING_GAP_METRES, 1.2, 4.0
    POLITENESS, LANE_CHANGE_MIN_ACC_GAIN = 0.0, 0.2
    LANE_CHANGE_MAX_BRAKING_IMPOSED, LANE_CHANGE_DELAY = 2.0, 1.0

    def __init__(
        self,
        road: CarRoad,
        number: int,
        size: tuple[float, float, float],
        way: tuple[int, int],
        place: tuple[int, float],
        speed: float,
        eagerness: float,
        driver: Driver | None = None,
    ) -> None:
        """A car of an id and a size (length, height, width).

        way: which path of the layout, and which segment of it. place: lane and metres on that.
        eagerness: its wanted speed as a part of the limits. driver: what errors it is driven with.
        """
        self.way, self.leg = way
        self.path = road.layout.paths[self.way]
        lane_index = (*self.path[self.leg], place[0])
        lane = road.network.get_lane(lane_index)
        self.driver, self.ticks = driver, 0
        self.drift, self.pace = (0.0, 1.0) if driver is None else driver.at(0.0)
        if driver is not None:
            self.COMFORT_ACC_MAX *= driver.briskness
        self.slowing = SLOWING * (1.0 if driver is None else driver.briskness)  # before bends, m/s2
        position, heading = lane.position(place[1], self.drift), lane.heading_at(place[1])
        # (With a road highway-env would look for the nearest of all lanes.)
        super().__init__(None, position, float(heading), speed, lane_index, MAX_SPEED)
        self.road = road
        self.LENGTH, self.HEIGHT, self.WIDTH = size
        self.diagonal = float(np.hypot(self.LENGTH, self.WIDTH))
        self.number, self.eagerness, self.row = number, eagerness, 0
        self.lane_index, self.lane = lane_index, lane
        self.slip: float | None = None  # sine of its angle; None: the wheels' angle is told
        self.held = False  # at the line before the next segment of its way
        # Gap to, and speed of, a car that will merge in front of this one.
        self.before: tuple[float, float] | None = None
        self.crashed_for = 0  # ticks
        self.stood_for = 0  # ticks
        self.passed: Car | None = None  # who stands facing us, and beside whom we drive past
        self.leaves_late = False  # a lane that ends, over its end
        self.timer = 0.618 * number % self.LANE_CHANGE_DELAY
        self._note_place()

    def _note_place(self) -> None:
        self._limit: float | None = None
        self.along, self.aside = map(float, self.lane.local_coordinates(self.position))

    @property
    def pose(self) -> Float[Array, "3"]:
        """x, y, heading; the heading is not wrapped."""
        return np.array([self.position[0], self.position[1], self.heading])

    @property
    def has_left(self) -> bool:
        """Whether the whole car is behind the end of its way."""
        is_last = self.leg == len(self.path) - 1
        return bool(is_last and self.along > self.lane.length + 0.5 * self.LENGTH)

    @property
    def is_past_end(self) -> bool:
        """Whether its centre is behind the end of its way."""
        return bool(self.leg == len(self.path) - 1 and self.along > self.lane.length)

    @property
    def to_line(self) -> float:
        """Metres from the front bumper to the end of this lane."""
        return float(self.lane.length) - self.along - 0.5 * self.LENGTH

    def act(self, action: object = None) -> None:
        """Choose lane, steering and acceleration for the next tick."""
        self.ticks += 1
        self.stood_for = self.stood_for + 1 if self.speed < STANDING_SPEED else 0
        if self.driver is not None:
            self.drift, self.pace = self.driver.at(self.ticks * TICK_SECONDS)
            self._limit = None
        if self.crashed:
            self.crashed_for += 1
            braking = min(6.0, self.speed / TICK_SECONDS)
            self.slip, self.action = None, {"steering": 0.0, "acceleration": -braking}
            return
        if len(self.road.beside(self.lane_index)) > 1:
            self.choose_lane()
        wanted = self.follow(self.lane_index)
        if self.lane_index != self.target_lane_index:
            wanted = min(wanted, self.follow(self.target_lane_index))
        wanted = max(min(wanted, self.COMFORT_ACC_MAX), -MAX_BRAKING, -self.speed / TICK_SECONDS)
        self.slip, self.action = self.wanted_slip(), {"acceleration": wanted}

    def follow(self, lane_index: LaneIndex) -> float:
        """The acceleration that a lane allows: the car in front, one coming in, a line, its end."""
        front, _ = self.road.neighbour_vehicles(self, lane_index)
        if front is not None and self._gets_past(front):
            front = self.road.next_on_way(self)
        free = self._free_acceleration()
        wanted = free if front is None else self._behind(front, free)
        for other in self.road.changing:
            comes_in = other is not self and other.target_lane_index == lane_index
            if comes_in and self.road.distance(self, other) > 0.0:
                wanted = min(wanted, self._behind(other, free))
        if self.before is not None:
            gap, speed = self.before
            wanted = min(wanted, free + self.brake(gap, self.speed - speed))
        if self.held:
            gap = self.to_line + 0.5 * STANDING_GAP_METRES
            wanted = min(wanted, free + self.brake(gap, self.speed))
        if self.road.is_closing(self, lane_index) and not self._leaves_late():
            left = float(self.road.lanes[lane_index].length) - self.along - 0.5 * self.LENGTH
            wanted = min(wanted, free + self.brake(left, self.speed))
        return wanted

    def _leaves_late(self) -> bool:
        """Whether we stood before the end of a lane and now have a gap in the one beside: nobody
        gets there who must not drive on."""
        if self.lane_index == self.target_lane_index:
            self.leaves_late = False
        elif self.stood_for > PATIENT_TICKS:
            self.leaves_late = True
        return self.leaves_late

    def _gets_past(self, front: "Car") -> bool:
        """Whether a car before us stands in the lane beside, facing us, so that we drive on.

        Where a bend ends, highway-env's rule of who is on a lane counts those who wait in the other
        lane as before us: each would wait for the other for ever.
        """
        if front is self.passed:
            return True
        self.passed = None
        if self.stood_for <= PATIENT_TICKS or self.held or front.speed >= STANDING_SPEED:
            return False
        aside = self.road.aside_on_way(self, front)
        apart = 0.5 * (self.WIDTH + front.WIDTH) + PASSING_ROOM_METRES
        if np.cos(front.heading - self.heading) < 0.0 and aside is not None and aside > apart:
            self.passed = front
        return self.passed is not None

    def acceleration(
        self,
        ego_vehicle: "Car | None" = None,
        front_vehicle: "Car | None" = None,
        rear_vehicle: "Car | None" = None,
    ) -> float:
        """The Intelligent Driver Model, with gaps between bumpers instead of centres."""
        car = ego_vehicle
        if car is None:
            return 0.0
        # (Another car is judged by our acceleration and its own braking.)
        free = self._free_acceleration(car)
        return free if front_vehicle is None else car._behind(front_vehicle, free)

    def _free_acceleration(self, other: "Car | None" = None) -> float:
        """The acceleration of this car, or of another that is as brisk, with nobody before it."""
        car = other or self
        limit = max(car.speed_limit(), 0.1)
        free = self.COMFORT_ACC_MAX * (1.0 - (car.speed / limit) ** self.DELTA)
        # Faster than wanted, as before a bend: brake gently, not with the fourth power.
        return max(free, -2.5)

    def _behind(self, front: "Car", free: float) -> float:
        """The acceleration behind a car; free: that with nobody there."""
        apart = self.road.distance(self, front)
        gap = apart - 0.5 * (self.LENGTH + front.LENGTH)
        turn = float(np.cos(front.heading - self.heading))
        closing = self.speed - front.speed * max(turn, 0.0)
        return free + min(self.brake(gap, closing), 0.0)

    def brake(self, gap: float, closing: float) -> float:
        """What a gap takes from the acceleration, when it shrinks by `closing` metres a second."""
        reach = self.TIME_WANTED * self.speed
        reach += self.speed * closing / (2.0 * sqrt(-self.COMFORT_ACC_MAX * self.COMFORT_ACC_MIN))
        wanted = self.DISTANCE_WANTED + max(0.0, float(reach))
        return -self.COMFORT_ACC_MAX * (wanted / max(gap, 0.1)) ** 2

    def speed_limit(self) -> float:
        """What this driver wants here, in time for the bends ahead."""
        if self._limit is None:
            wanted = self.eagerness * self.pace
            limit = self.lane.speed_limit * wanted
            for offset, next_limit in self.road.limits_ahead(self):
                ahead, apart = next_limit * wanted, max(offset - self.along, 0.0)
                limit = min(limit, sqrt(ahead**2 + 2.0 * self.slowing * apart))
            self._limit = float(limit)
        return self._limit

    def wanted_slip(self) -> float:
        """The sine of the slip angle that leads to the middle of the lane that it wants to be in.

        highway-env's cascade (place, heading, heading rate), but a slow car does not turn across
        the road to get there: it keeps within STEEPEST of the lane's direction.
        """
        index = self.target_lane_index
        along, aside = self.along, self.aside
        if index != self.lane_index:
            along, aside = map(float, self.road.lanes[index].local_coordinates(self.position))
        speed = max(self.speed, 0.5)
        aside -= self.drift
        across = max(min(self.KP_LATERAL * aside / speed, MAX_LANE_ANGLE), -MAX_LANE_ANGLE)
        course = self.road.course(self, index, along + speed * self.TAU_PURSUIT)
        error = (course - across - self.heading + pi) % (2.0 * pi) - pi
        most = min(MAX_LATERAL_ACCELERATION * 0.5 * self.LENGTH / speed**2, 1.0)
        return max(min(0.5 * self.LENGTH / speed * self.KP_HEADING * error, most), -most)

    def choose_lane(self) -> None:
        """Leave a lane that ends as soon as there is a gap; else change as MOBIL says."""
        if self.lane_index != self.target_lane_index:
            return
        if not self.road.is_closing(self, self.lane_index):
            self.change_lane_policy()
            return
        for index in self.road.network.side_lanes(self.lane_index):
            if not self.road.is_closing(self, index) and self.is_safe(index):
                self.target_lane_index = index
                return

    def mobil(self, lane_index: LaneIndex) -> bool:
        """MOBIL, and nobody beside us who is in that lane or on his way into it."""
        if self.road.is_closing(self, lane_index) or not self.is_safe(lane_index):
            return False
        return bool(super().mobil(lane_index))

    def is_safe(self, lane_index: LaneIndex) -> bool:
        """Whether nobody has to brake hard when we change to a lane.

        Who is on the way there from our lane, behind us, follows us in either.
        """
        for other in self.road.vehicles:
            if other is not self and lane_index in (other.lane_index, other.target_lane_index):
                apart = self.road.distance(self, other)
                follows = other.lane_index == self.lane_index and apart < 0.0
                room = 0.5 * (self.LENGTH + other.LENGTH) + STANDING_GAP_METRES
                if abs(apart) < room and not follows:
                    return False
        front, rear = self.road.neighbour_vehicles(self, lane_index)
        least = -self.LANE_CHANGE_MAX_BRAKING_IMPOSED
        if self.acceleration(self, front) < least:
            return False
        return bool(rear is None or self.acceleration(rear, self) >= least)

    def controls(self, dt: float) -> tuple[float, float, float, float, float]:
        """Steering, rad, acceleration, m/s2, speed, m/s, heading, rad, and length, m, of a tick.

        dt: seconds of it.
        """
        self.timer += dt
        self.clip_actions()
        told = self.action
        return told["steering"], told["acceleration"], self.speed, self.heading, self.LENGTH

    def move_to(
        self, position: Float[Array, "2"], heading: float, speed: float, along: float, aside: float
    ) -> None:
        """Note where a tick has led, along and aside of the lane; go on to the next of the way."""
        self.position, self.heading, self.speed = position, heading, speed
        self.along, self.aside, self._limit = along, aside, None
        if self.along > self.lane.length and self.leg + 1 < len(self.path):
            after = self.path[self.leg + 1]
            self.target_lane_index = self.road.onward(self.target_lane_index, after)[0]
            self.lane_index = self.road.onward(self.lane_index, after)[0]
            self.leg += 1
        elif self.lane_index != self.target_lane_index:
            beside = self.road.beside(self.lane_index)
            self.lane_index = min(beside, key=self._aside_of)
        else:
            return
        self.lane = self.road.network.get_lane(self.lane_index)
        self._note_place()

    def _aside_of(self, lane_index: LaneIndex) -> float:
        lane = self.road.network.get_lane(lane_index)
        return abs(float(lane.local_coordinates(self.position)[1]))

    @cached_property
    def size(self) -> Float[Array, "3"]:
        """Length, height, width."""
        return np.array([self.LENGTH, self.HEIGHT, self.WIDTH])


class EgoCar(Car):
    """The ego car. Under command it follows its lane and holds a speed, whoever is in its way:
    it neither yields nor brakes for others, as highway-env's MDPVehicle.
    """

    told_speed: float | None = None  # m/s; None: it drives itself
    told_action: tuple[float, float] | None = (
        None  # m/s2, rad of the front wheels; None: no one steers
    )

    def obey(self, command: str) -> None:
        """Take a command of COMMANDS; a lane that is not there, or one more while it changes
        lanes, changes nothing but who drives."""
        self.told_action = None
        if command == "autopilot":
            self.told_speed = None
            return
        told = float(self.speed) if self.told_speed is None else self.told_speed
        told += {"faster": SPEED_STEP, "slower": -SPEED_STEP}.get(command, 0.0)
        self.told_speed = min(max(told, 0.0), MAX_SPEED)
        aside = {"lane_left": -1, "lane_right": 1}.get(command, 0)
        if aside and self.lane_index == self.target_lane_index:
            beside = (*self.lane_index[:2], self.lane_index[2] + aside)
            if beside in self.road.beside(self.lane_index):
                self.target_lane_index = beside

    def act(self, action: object = None) -> None:
        """Steering and acceleration for the next tick."""
        if self.told_action is not None:  # it does not drive backwards
            wanted, angle = self.told_action
            wanted = max(wanted, -float(self.speed) / TICK_SECONDS)
            self.slip, self.action = None, {"steering": angle, "acceleration": wanted}
            return
        if self.crashed or self.told_speed is None:
            super().act(action)
            return
        wanted = self.KP_A * (self.told_speed - self.speed)
        wanted = max(min(wanted, self.ACC_MAX), -MAX_BRAKING, -self.speed / TICK_SECONDS)
        self.slip, self.action = self.wanted_slip(), {"acceleration": float(wanted)}

    def driving(self, touches: bool) -> Driving:
        """How it drives now; touches: whether it overlaps another car."""
        turned = self.heading - float(self.lane.heading_at(self.along))
        return Driving(
            speed=float(self.speed * cos(turned)),
            limit=float(self.lane.speed_limit),
            lane=int(self.lane_index[2]),
            lanes=len(self.road.beside(self.lane_index)),
            on_road=not self.is_past_end
            and abs(self.aside) <= MAX_ASIDE_SHARE * float(self.lane.width_at(self.along)),
            crashed=bool(self.crashed) or touches,
            road_ended=self.is_past_end,
        )
