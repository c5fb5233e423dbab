"""Traffic by script: cars follow way-points with given speeds, in closed form."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from jaxtyping import Float
from numpy import ndarray as Array

from mot_sim.simulation.traffic.traffic_state import STEP_SECONDS, TrafficState
from tracker.errors import BadConfig
from tracker.geometry import wrap_angle

SEDAN_SIZE = (4.4, 1.45, 1.8)  # length, height, width
MIN_ARC_METRES = 1e-9  # metres, radians: below it a corner is none
MIN_PIECE_METRES = 1e-6
MAX_TURN_RADIANS = 2.9  # radians at one way-point: beyond it the arc shrinks to a turn on the spot


@dataclass(frozen=True, eq=False)
class Route:
    """Straight lines between way-points, joined by arcs of circles; straight on beyond both
    ends."""

    waypoints: Sequence[tuple[float, float]]
    """Points x, y in world, metres: two or more, no two neighbours equal."""
    radius: float = 7.0
    """Of every corner, metres, > 0; smaller where the legs are too short. Larger: wider bends."""

    def __post_init__(self) -> None:
        points = np.asarray(self.waypoints, dtype=float)
        is_list = points.ndim == 2 and points.shape[1] == 2 and len(points) >= 2
        if not is_list or not np.isfinite(points).all():
            raise BadConfig(f"way-points {self.waypoints}: give two or more finite points x, y")
        if (np.hypot(*np.diff(points, axis=0).T) <= 0.0).any():
            raise BadConfig(f"way-points {self.waypoints}: two neighbours are the same point")
        headings = np.arctan2(*np.diff(points, axis=0).T[::-1])
        if (np.abs(wrap_angle(np.diff(headings))) > MAX_TURN_RADIANS).any():
            raise BadConfig(f"way-points {self.waypoints}: a turn back needs more points")
        if not self.radius > 0.0:
            raise BadConfig(f"corner radius {self.radius:g} m: it must be positive")

    @property
    def length(self) -> float:
        """Metres from the first to the last way-point, along the arcs."""
        return float(self._pieces[-1, 0])

    def at(self, distance: Float[Array, " n"]) -> Float[Array, "n 3"]:
        """x, y, heading after a distance in metres. Heading is continuous and not wrapped."""
        return along_pieces(self.pieces_at(distance), distance)

    def pieces_at(self, distance: Float[Array, " n"]) -> Float[Array, "n 5"]:
        """The line or arc that each distance lies on; see `along_pieces`."""
        starts = self._pieces[:-1]
        row = np.clip(np.searchsorted(starts[:, 0], distance, side="right") - 1, 0, None)
        return starts[row]

    @property
    def pieces(self) -> Float[Array, "m 6"]:
        """Its lines and arcs: where each starts, metres along the route, x, y; heading there,
        curvature (1/m, > 0 to the right, 0 of a line), length. None is shorter than a
        micrometre."""
        starts, length = self._pieces[:-1], np.diff(self._pieces[:, 0])
        return np.column_stack((starts, length))[length > MIN_PIECE_METRES]

    @cached_property
    def _pieces(self) -> Float[Array, "m 5"]:
        """Lines and arcs in turn: start along the route, x, y, heading, curvature; then the end."""
        points = np.asarray(self.waypoints, dtype=float)
        legs = np.diff(points, axis=0)
        lengths = np.hypot(legs[:, 0], legs[:, 1])
        headings = np.unwrap(np.arctan2(legs[:, 1], legs[:, 0]))
        x, y = points[0]
        rows = [(0.0, x, y, headings[0], 0.0)]
        used = 0.0  # of this leg, by the corner before it
        for leg, turn in enumerate(np.diff(headings)):
            start, x, y, heading, _ = rows[-1]
            # No corner takes more than half of a leg, so that the next one finds its half.
            room = 0.5 * min(lengths[leg], lengths[leg + 1])
            tangent = np.tan(0.5 * abs(turn))
            cut = min(room, self.radius * tangent)
            line = lengths[leg] - used - cut
            arc_start = (start + line, x + line * np.cos(heading), y + line * np.sin(heading))
            arc = cut / tangent * abs(turn) if tangent > MIN_ARC_METRES else 2.0 * cut
            rows.append((*arc_start, heading, turn / arc if arc > MIN_ARC_METRES else 0.0))
            leave = points[leg + 1] + cut * legs[leg + 1] / lengths[leg + 1]
            rows.append((start + line + arc, *leave, headings[leg + 1], 0.0))
            used = cut
        rows.append((rows[-1][0] + lengths[-1] - used, *points[-1], headings[-1], 0.0))
        return np.array(rows)


def along_pieces(pieces: Float[Array, "n 5"], distance: Float[Array, " n"]) -> Float[Array, "n 3"]:
    """x, y, heading after distances along routes, each on a line or arc of its own.

    pieces: where the piece starts, metres along the route, x, y; heading there, curvature.
    """
    start, x, y, heading, curvature = pieces.T
    along = distance - start
    turn = curvature * along
    # Along an arc the chord is 2 sin(turn / 2) / curvature long and points half the turn.
    chord = along * np.sinc(turn / (2.0 * np.pi))
    middle = heading + 0.5 * turn
    return np.stack((x + chord * np.cos(middle), y + chord * np.sin(middle), heading + turn), 1)


@dataclass(frozen=True, eq=False)
class Script:
    """What one car does: its route, where on it the car begins, and its speed over time."""

    route: Route
    """Where it drives; it is gone after the end of the route."""
    speeds: Sequence[tuple[float, float]]
    """(time, speed) in seconds (increasing) and m/s (>= 0); linear between, constant outside."""
    start: float = 0.0
    """Metres along the route at time 0."""
    size: tuple[float, float, float] = SEDAN_SIZE
    """Length, height, width, metres, > 0."""
    begin: float = 0.0
    """Seconds, in the run's time, from which on the car is there."""
    kind: str = "Car"
    """KITTI's class: 'Car' or 'Van'."""

    def __post_init__(self) -> None:
        table = np.asarray(self.speeds, dtype=float)
        if table.ndim != 2 or table.shape[0] == 0 or (np.diff(table[:, 0]) <= 0.0).any():
            raise BadConfig(f"speeds {self.speeds}: give (time, speed) with increasing times")
        if (table[:, 1] < 0.0).any() or min(self.size) <= 0.0:
            raise BadConfig(f"speeds {self.speeds}, size {self.size}: nothing may be negative")

    @cached_property
    def _table(self) -> Float[Array, "3 k"]:
        """Times from 0 on, the speeds then, and the metres driven until then."""
        times, speeds = np.asarray(self.speeds, dtype=float).T
        knots = np.concatenate(([0.0], times[times > 0.0]))
        paces = np.interp(knots, times, speeds)
        driven = np.cumsum(0.5 * (paces[1:] + paces[:-1]) * np.diff(knots))
        return np.stack((knots, paces, np.concatenate(([0.0], driven))))

    def speed(self, time: float) -> float:
        """Metres per second at a time, 0 or later."""
        return float(np.interp(time, *self._table[:2]))

    def distance(self, time: float) -> float:
        """Metres along the route at a time: `start` and the exact integral of the speed."""
        knots, paces, driven = self._table
        row = int(np.searchsorted(knots, time, side="right")) - 1
        passed = 0.5 * (float(paces[row]) + self.speed(time)) * (time - float(knots[row]))
        return self.start + float(driven[row]) + passed


@dataclass(eq=False)
class Scripted:
    """Traffic that does the same for every seed; the id of a car is its place in `cars`."""

    cars: Sequence[Script]
    """Every car but ours; its place here is its id."""
    ego: Script
    """The car that carries the camera."""
    steps: int = field(default=0, init=False)
    """Steps of 0.1 s taken since the last reset."""

    def reset(self, rng: np.random.Generator) -> TrafficState:
        """The state at time 0; nothing is drawn from the generator."""
        self.steps = 0
        return self.at(0.0)

    def step(self) -> TrafficState:
        """The state 0.1 s later."""
        self.steps += 1
        return self.at(self.steps * STEP_SECONDS)

    def at(self, time: float) -> TrafficState:
        """The state at any time."""
        driven = {number: car.distance(time) for number, car in enumerate(self.cars)}
        ids = [
            number
            for number, car in enumerate(self.cars)
            if time >= car.begin and driven[number] <= car.route.length
        ]
        cars = [self.cars[number] for number in ids]
        distances = np.array([[driven[number]] for number in ids] + [[self.ego.distance(time)]])
        routes = [car.route for car in (*cars, self.ego)]
        pieces = [route.pieces_at(at)[0] for route, at in zip(routes, distances, strict=True)]
        poses = along_pieces(np.array(pieces), distances[:, 0])
        return TrafficState(
            time=time,
            ids=np.array(ids, dtype=np.int64),
            x=poses[:-1, 0],
            y=poses[:-1, 1],
            heading=poses[:-1, 2],
            speed=np.array([car.speed(time) for car in cars], dtype=float),
            size=np.array([car.size for car in cars], dtype=float).reshape(-1, 3),
            ego=poses[-1],
            ego_size=np.array(self.ego.size, dtype=float),
            kinds=np.array([car.kind for car in cars], dtype="<U16"),
        )


@dataclass(eq=False)
class Improvised:
    """Scripted traffic whose script is written anew at every reset, from the random numbers."""

    write: Callable[[np.random.Generator], Scripted]
    """Draws a script from a generator."""
    _scripted: Scripted | None = field(default=None, init=False)

    def reset(self, rng: np.random.Generator) -> TrafficState:
        """The first state of a new script."""
        self._scripted = self.write(rng)
        return self._scripted.reset(rng)

    def step(self) -> TrafficState:
        """The state 0.1 s later. Raises BadConfig before the first `reset`."""
        if self._scripted is None:
            raise BadConfig("traffic makes its first step: call reset(rng) before")
        return self._scripted.step()
