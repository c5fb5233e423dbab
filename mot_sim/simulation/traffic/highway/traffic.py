"""Live traffic on highway-env's roads and drivers, behind the `Traffic` protocol."""

from collections import deque
from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from mot_sim.simulation import random_numbers
from mot_sim.simulation.traffic.driving import COMMANDS, Driving
from mot_sim.simulation.traffic.highway.layout import (
    Layout,
    highway_layout,
    intersection_layout,
    merge_layout,
    roundabout_layout,
    street_layout,
    t_junction_layout,
)
from mot_sim.simulation.traffic.highway.simulation import EGO_NUMBER, Demand, Simulation
from mot_sim.simulation.traffic.highway.streets import bent_street_layout
from mot_sim.simulation.traffic.highway.town import town_layout
from mot_sim.simulation.traffic.traffic_state import STEP_SECONDS, TrafficState, collisions
from tracker.errors import BadConfig, UnknownName

# The name of a road: what builds it.
ROADS: dict[str, Callable[[], Layout]] = {
    "bent_street": bent_street_layout,
    "highway": highway_layout,
    "intersection": intersection_layout,
    "merge": merge_layout,
    "roundabout": roundabout_layout,
    "street": street_layout,
    "t_junction": t_junction_layout,
    "town": town_layout,
}
CRASHES = ("reject", "label")
MAX_LENGTH_METRES = 8.0  # what the lanes and parking places are made for
MAX_WIDTH_METRES = 2.2  # the same
MAX_ATTEMPTS = 20


@dataclass(eq=False)
class HighwayTraffic(Demand):
    """Cars on a road of ROADS, by the Intelligent Driver Model, with an ego car among them.

    The run ends where the road of the ego car does (`has_ended`); steps behind that let it drive
    straight on. The other fields: see `Demand`.
    """

    crashes: str = "reject"
    """`reject`: drive ahead and begin again, by the same seed, when cars crash in that time;
    `label`: only mark which cars have crashed."""
    clean_seconds: float = 20.0
    """Seconds, >= 0, that `reject` drives ahead; more: longer runs without crashes, slower
    resets."""

    def __post_init__(self) -> None:
        if self.road not in ROADS:
            raise UnknownName.of("road", self.road, ROADS)
        if self.route != "any" and self.route not in (
            routes := _layout_of(ROADS[self.road]).routes
        ):
            raise UnknownName.of(f"route on the {self.road}", self.route, ("any", *routes))
        if self.crashes not in CRASHES:
            raise UnknownName.of("treatment of crashes", self.crashes, CRASHES)
        for name in ("cars", "vans", "arrivals", "wander", "bumps", "clean_seconds"):
            value = getattr(self, name)
            if not 0 <= value < np.inf:
                raise BadConfig(f"{name} of the traffic is {value:g}: give 0 or more")
        if not 0.0 <= self.parked <= 1.0:
            raise BadConfig(f"parked is {self.parked:g}: it is a share, 0 to 1")
        shapes = np.vstack((self.sizes.reshape(-1, 3), self.van_size, self.ego_size))
        fits = (shapes > 0.0).all() and (
            shapes[:, [0, 2]] <= (MAX_LENGTH_METRES, MAX_WIDTH_METRES)
        ).all()
        if not (len(self.sizes) and fits):
            raise BadConfig(
                f"sizes (length, height, width) {shapes.tolist()}: give one or more, positive, at "
                f"most {MAX_LENGTH_METRES:g} m long and {MAX_WIDTH_METRES:g} m wide"
            )
        self.driven: Callable[[int], None] | None = None  # see `DrivenAhead`
        self._simulation: Simulation | None = None
        self._ahead: deque[tuple[TrafficState, bool]] = deque()
        self._has_ended = False

    @property
    def has_ended(self) -> bool:
        """Whether the ego car was behind the end of its road in the last state that was given."""
        return self._has_ended

    @property
    def ego_ways(self) -> int:
        """How many new ways the ego car has begun; 0 unless `continuous`."""
        return 0 if self._simulation is None else self._simulation.ego_ways

    def reset(self, rng: np.random.Generator) -> TrafficState:
        """A new run; the generator gives one number, everything else follows from it.

        Raises BadConfig for more cars than the road holds, and when no attempt was clean.
        """
        for attempt in attempts(rng):
            if self._try(attempt):
                return self.step()
        raise BadConfig(
            f"{self.cars} cars on the {self.road}: somebody crashed within "
            f"{self.clean_seconds:g} s in all of {MAX_ATTEMPTS} attempts; ask for fewer cars or "
            "arrivals, or crashes='label'"
        )

    def reset_live(self, rng: np.random.Generator) -> TrafficState:
        """A new run to drive in: the first attempt of `reset`, nothing of it driven ahead.

        Under autopilot it gives the states of `reset`, where nobody crashes in them. Raises
        BadConfig for more cars than the road holds.
        """
        self._simulation = Simulation(_layout_of(ROADS[self.road]), self, attempts(rng)[0])
        self._ahead, self._has_ended = deque(), False
        return self._simulation.state()

    def command(self, name: str) -> None:
        """What the ego car does from now on, one of COMMANDS. Raises UnknownName, and BadConfig
        before `reset_live` and where states were driven ahead."""
        if name not in COMMANDS:
            raise UnknownName.of("command", name, COMMANDS)
        self._driven().ego.obey(name)

    def steer(self, acceleration: float, angle: float) -> None:
        """Hold this acceleration (m/s2) and angle of the front wheels (rad, to the right) until the
        next call; it does not drive backwards. Raises BadConfig as `command` does."""
        self._driven().ego.told_action = acceleration, angle

    def driving(self) -> Driving:
        """How the ego car drives now."""
        simulation = self._driven()
        touches = bool((collisions(simulation.state()) == EGO_NUMBER).any())
        return simulation.ego.driving(touches)

    def _driven(self) -> Simulation:
        if self._simulation is None or self._ahead:
            raise BadConfig("nobody can drive in this traffic: begin it with reset_live(rng)")
        return self._simulation

    def _try(self, seed: int) -> bool:
        """Begin a run and drive it ahead; whether that was clean."""
        simulation = Simulation(_layout_of(ROADS[self.road]), self, seed)
        self._simulation = simulation
        self._ahead = deque([(simulation.state(), False)])
        if self.crashes == "label":
            return True
        for _ in range(round(self.clean_seconds / STEP_SECONDS)):
            simulation.step()
            if simulation.has_crashed:
                return False
            self._ahead.append((simulation.state(), simulation.has_ended))
            if self.driven is not None:
                self.driven(len(self._ahead) - 1)
            if simulation.has_ended:
                break
        return True

    def step(self) -> TrafficState:
        """The state 0.1 s later. Raises BadConfig before the first `reset`."""
        if self._simulation is None:
            raise BadConfig("traffic makes its first step: call reset(rng) before")
        if self._ahead:
            state, self._has_ended = self._ahead.popleft()
            return state
        self._simulation.step()
        self._has_ended = self._simulation.has_ended
        return self._simulation.state()


@lru_cache(maxsize=16)  # a town takes a sixth of a second
def _layout_of(road: Callable[[], Layout]) -> Layout:
    """The layout that a builder of ROADS gives; nobody changes it."""
    return road()


def attempts(rng: np.random.Generator) -> list[int]:
    """The seeds of the attempts at a run; the generator gives one number for all of them."""
    seed, numbers = int(rng.integers(2**62)), np.arange(MAX_ATTEMPTS)
    drawn = random_numbers.bits(seed, "attempt", numbers, np.zeros(MAX_ATTEMPTS, np.int64))
    return [int(attempt) >> 1 for attempt in drawn[:, 0].tolist()]
