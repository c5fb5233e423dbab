"""Live traffic on highway-env's roads and drivers, behind the `Traffic` protocol."""

from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from jaxtyping import Float
from numpy import ndarray as Array

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
from mot_sim.simulation.traffic.scripted import SEDAN_SIZE
from mot_sim.simulation.traffic.traffic_state import STEP, TrafficState, collisions
from tracker.errors import BadConfig, UnknownName

# The name of a road: what builds it.
ROADS: dict[str, Callable[[], Layout]] = {
    "highway": highway_layout,
    "intersection": intersection_layout,
    "merge": merge_layout,
    "roundabout": roundabout_layout,
    "street": street_layout,
    "t_junction": t_junction_layout,
}
CRASHES = ("reject", "label")
# Length, height, width of common cars, from small to large.
CAR_SIZES = (
    (3.6, 1.5, 1.64), (4.0, 1.46, 1.74), (4.3, 1.45, 1.79), (4.6, 1.43, 1.83),
    (4.75, 1.48, 1.82), (4.5, 1.66, 1.85), (4.85, 1.75, 1.93),
)  # fmt: skip
VAN_SIZE = (5.4, 2.3, 2.0)
MAX_LENGTH_METRES = 8.0  # what the lanes and parking places are made for
MAX_WIDTH_METRES = 2.2  # the same
MAX_ATTEMPTS = 20


@dataclass(eq=False)
class HighwayTraffic:
    """Cars on a road of ROADS, by the Intelligent Driver Model, with an ego car among them.

    cars: driving at time 0. arrivals: cars a second that come in later, over all entries; where
    an entry is full they wait, and more than three are turned away. parked: share of the kerb
    places that are taken, 0 to 1. vans: parked vans, on the places nearest to the middle.
    sizes: length, height, width that cars are drawn from. crashes: `reject` drives the first
    `clean_seconds` ahead and begins again, by the same seed, when anybody crashes in them;
    `label` only marks who has. The ego car drives on straight behind the end of its way.
    """

    road: str = "intersection"
    cars: int = 12
    arrivals: float = 0.5
    parked: float = 0.4
    vans: int = 0
    sizes: Float[Array, "m 3"] = field(default_factory=lambda: np.array(CAR_SIZES))
    van_size: tuple[float, float, float] = VAN_SIZE
    ego_size: tuple[float, float, float] = SEDAN_SIZE
    crashes: str = "reject"
    clean_seconds: float = 20.0

    def __post_init__(self) -> None:
        if self.road not in ROADS:
            raise UnknownName.of("road", self.road, ROADS)
        if self.crashes not in CRASHES:
            raise UnknownName.of("treatment of crashes", self.crashes, CRASHES)
        for name in ("cars", "vans", "arrivals", "clean_seconds"):
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
        self._simulation: Simulation | None = None
        self._ahead: deque[TrafficState] = deque()

    def reset(self, rng: np.random.Generator) -> TrafficState:
        """A new run; the generator gives one number, everything else follows from it.

        Raises BadConfig for more cars than the road holds, and when no attempt was clean.
        """
        for attempt in attempts(rng):
            if self._try(attempt):
                return self._ahead.popleft()
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
        self._simulation = Simulation(ROADS[self.road](), self.demand, attempts(rng)[0])
        self._ahead = deque()
        return self._simulation.state()

    def command(self, name: str) -> None:
        """What the ego car does from now on, one of COMMANDS. Raises UnknownName, and BadConfig
        before `reset_live` and where states were driven ahead."""
        if name not in COMMANDS:
            raise UnknownName.of("command", name, COMMANDS)
        self._driven().ego.obey(name)

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
        simulation = Simulation(ROADS[self.road](), self.demand, seed)
        self._simulation = simulation
        self._ahead = deque([simulation.state()])
        if self.crashes == "label":
            return True
        for _ in range(round(self.clean_seconds / STEP)):
            simulation.step()
            if simulation.has_crashed:
                return False
            self._ahead.append(simulation.state())
        return True

    def step(self) -> TrafficState:
        """The state 0.1 s later. Raises BadConfig before the first `reset`."""
        if self._simulation is None:
            raise BadConfig("traffic makes its first step: call reset(rng) before")
        if self._ahead:
            return self._ahead.popleft()
        self._simulation.step()
        return self._simulation.state()

    @property
    def demand(self) -> Demand:
        """What a run needs to know."""
        return Demand(
            self.road,
            self.cars,
            self.arrivals,
            self.parked,
            self.vans,
            self.sizes,
            self.van_size,
            self.ego_size,
        )


def attempts(rng: np.random.Generator) -> list[int]:
    """The seeds of the attempts at a run; the generator gives one number for all of them."""
    seed, numbers = int(rng.integers(2**62)), np.arange(MAX_ATTEMPTS)
    drawn = random_numbers.bits(seed, "attempt", numbers, np.zeros(MAX_ATTEMPTS, np.int64))
    return [int(attempt) >> 1 for attempt in drawn[:, 0].tolist()]
